//! The facts of a build, line by line, with its recorded outcomes and its events.

use language::say;
use ledger::{BuildRow, EventKind, EventRow, OutcomeRow, UtcTimestamp};
use settings::MachineProfile;

use crate::tables::{
    columns::{
        cell_value::CellValue,
        field_definition::{FieldDefinition, SheetFact},
        table_column::TableColumn as Column,
        time_view::TimeView,
    },
    fields,
};

/// The recorded outcomes of a build.
pub const OUTCOME_COLUMNS: &[Column<OutcomeRow>] = &[
    Column::new("told_at", fields::OUTCOME_RECORDED, |row| row.told_at.into()),
    Column::new("outcome", fields::OUTCOME, |row| row.outcome.into()),
    Column::new("told_by", fields::OUTCOME_BY, |row| (&row.told_by).into()),
    Column::new("note", fields::NOTE, |row| (&row.note).into()),
];

/// The kind of an event as people say it.
fn event_word(kind: &EventKind) -> String {
    match kind {
        EventKind::Claimed => say!("event-taken"),
        EventKind::Batched => language::say_word("event", "in a build"),
        EventKind::Built => language::say_word("event", "in the queue"),
        other => language::say_word("event", &other.to_string().replace('_', " ")),
    }
}

/// The events of a build or a part.
pub const EVENT_COLUMNS: &[Column<EventRow>] = &[
    Column::new("at", fields::EVENT, |event| event.at.into()),
    Column::new("kind", fields::KIND, |event| event_word(&event.kind).into()),
    Column::new("build", fields::BUILD, |event| event.build_id.into()),
    Column::new("detail", fields::DETAIL, |event| CellValue::Prose(event.detail.clone())),
];

/// Events of the parts of an order.
pub const ORDER_EVENT_COLUMNS: &[Column<EventRow>] = &[
    Column::new("at", fields::EVENT, |event| event.at.into()),
    Column::new("kind", fields::KIND, |event| event_word(&event.kind).into()),
    Column::new("part_id", fields::PART, |event| event.part_id.map_or(CellValue::Missing, CellValue::Part)),
    Column::new("build", fields::BUILD, |event| event.build_id.into()),
    Column::new("detail", fields::DETAIL, |event| CellValue::Prose(event.detail.clone())),
];

/// The facts of a build. `machine` is its machine profile at the time of the build. An open build has fewer facts.
/// `copies` is the text with its number of copies, `file` the path of its file.
pub fn build_facts(
    row: &BuildRow,
    machine: Option<&MachineProfile>,
    (copies, file): (String, Option<String>),
    view: &TimeView,
) -> Vec<SheetFact> {
    let layers =
        row.measures.layers.or_else(|| Some((row.measures.height_mm? / machine?.space.layer_mm).ceil() as u32));
    let thick = machine.and_then(|machine| fields::LAYER_THICKNESS.with_unit(machine.space.layer_mm));
    let volume = row.measures.part_volume_mm3.and_then(|mm3| fields::PART_VOLUME.with_unit(mm3 / 1000.0));
    let fired_by = (!row.fired_by.is_empty()).then(|| {
        say!("fired-and-nested", trigger = language::say_word("trigger", &row.fired_by), count = row.attempts)
    });
    let content = row.staged.file_hash.as_ref().map(|hash| content(row.staged.file_bytes.unwrap_or_default(), hash));
    let bound = fields::LOWER_BOUND.with_unit(row.measures.lower_bound_mm);
    let ago = |at: UtcTimestamp| {
        view.now()
            .and_then(|now| at.age_text(now))
            .map_or_else(String::new, |age| format!(", {}", say!("ago", age = age)))
    };
    let published = row
        .times
        .published_at
        .map(|at| SheetFact { at: Some(at), ..fields::PUBLISHED.fact_of(view.time_text(at) + &ago(at)) });
    let released = row.place.released_at.zip(row.place.released_by.as_ref());
    let released = released.map(|(at, by)| say!("time-by", time = view.time_text(at), by = by));
    let printer = row.place.printer.as_ref().filter(|printer| **printer != row.machine);
    let printer = printer.map(|printer| match &row.place.move_to {
        Some(to) => say!("on-its-way-to", printer = printer, other = to),
        None => printer.clone(),
    });
    let optional_fact = |field: FieldDefinition, text: Option<String>| text.map(|text| field.fact_of(text));
    let lines = [
        optional_fact(fields::HEIGHT, height(row.measures.height_mm, machine.map(|machine| machine.space.volume_mm.z))),
        optional_fact(fields::LOWER_BOUND, bound.map(|bound| say!("bound-text", bound = bound))),
        optional_fact(fields::LAYERS, layers.map(|layers| of_all(layers.to_string(), thick))),
        fields::DENSITY.fact(row.measures.density),
        fields::MATERIAL.fact(&row.material),
        fields::LOT.fact(&row.lot),
        Some(fields::COPIES.fact_of(joined([Some(copies), volume], ", "))),
        optional_fact(fields::CLEARANCE, clearance(row, machine)),
        optional_fact(fields::SEARCH, row.search.method.as_ref().map(|method| search(method, row))),
        optional_fact(fields::FIRED_BY, fired_by),
        view.time_fact(fields::OPENED, row.times.opened_at),
        view.time_fact(fields::NESTING, row.times.nesting_at),
        view.time_fact(fields::VERIFIED, row.times.verified_at),
        optional_fact(fields::RELEASED, released),
        published,
        optional_fact(fields::PRINTER, printer),
        view.time_fact(fields::TAKEN, row.place.taken_at),
        view.time_fact(fields::WITHDRAWN, row.place.withdrawn_at),
        fields::FILE.fact(file.as_ref().or(row.staged.file_name.as_ref())),
        optional_fact(fields::CONTENT, content),
    ];
    lines.into_iter().flatten().collect()
}

/// `87.50 mm of 200 mm`.
pub fn height(height_mm: Option<f64>, volume_z_mm: Option<f64>) -> Option<String> {
    let volume = volume_z_mm.filter(|z| *z > 0.0).and_then(|z| fields::VOLUME_Z.with_unit(z));
    Some(of_all(fields::HEIGHT.with_unit(height_mm)?, volume))
}

/// A value, of all that there is where that is known: `87.50 mm of 380 mm`.
fn of_all(value: String, all: Option<String>) -> String {
    match all {
        Some(all) => say!("number-of", number = value, all = all),
        None => value,
    }
}

fn clearance(row: &BuildRow, machine: Option<&MachineProfile>) -> Option<String> {
    let asked_mm = row.measures.clearance_mm.or(machine.map(|machine| machine.space.clearance_mm));
    clearance_text(asked_mm, row.measures.clearance_proved_mm, row.times.verified_at)
}

/// The clearance that was asked for, and what is proved of it.
pub(super) fn clearance_text(
    asked_mm: Option<f64>,
    proved_mm: Option<f64>,
    verified_at: Option<UtcTimestamp>,
) -> Option<String> {
    let asked = fields::CLEARANCE.with_unit(asked_mm)?;
    let proved = match (fields::CLEARANCE_PROVED.with_unit(proved_mm), verified_at) {
        (Some(proved), _) => say!("clearance-proved", clearance = proved),
        (None, Some(_)) => say!("clearance-no-two"),
        (None, None) => say!("clearance-once-fired"),
    };
    Some(say!("clearance-asked", asked = asked, proved = proved))
}

fn search(method: &str, row: &BuildRow) -> String {
    let pieces = [
        Some(method.to_owned()),
        row.search.seed.map(|seed| say!("seed", seed = seed.to_string())),
        row.search.evaluations.map(|evaluations| say!("evaluations", count = evaluations)),
        fields::CPU.plain_text(&row.search.cpu_secs.into()).map(|secs| say!("cpu-secs", secs = secs)),
        fields::WALL.plain_text(&row.search.wall_secs.into()).map(|secs| say!("wall-secs", secs = secs)),
        row.search.version.as_ref().map(|version| format!("nestd {version}")),
    ];
    joined(pieces, ", ")
}

/// Size and hash of a file.
pub(crate) fn content(bytes: u64, hash: &str) -> String {
    say!("bytes-and-hash", bytes = bytes.to_string(), hash = hash)
}

/// Joins the pieces that are known into one line.
pub(crate) fn joined<const N: usize>(pieces: [Option<String>; N], between: &str) -> String {
    pieces.into_iter().flatten().collect::<Vec<_>>().join(between)
}
