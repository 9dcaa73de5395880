//! The record of a part: a sheet for each build that made copies of it, and its copies there.

use farm::{RecordedBuild, RecordedCopy};
use glam::DQuat;
use language::say;
use ledger::PickMark;

use super::build_sheet::{clearance_text, content};
use crate::tables::{
    columns::{
        cell_value::CellValue,
        field_definition::{FieldDefinition, SheetFact},
        table_column::TableColumn as Column,
        time_view::TimeView,
    },
    fields,
};

/// A copy that is turned by less stands as in its file, degrees.
const SLIGHT_DEG: f64 = 0.005;

/// The copies of a part in a build.
pub const RECORDED_COPY_COLUMNS: &[Column<RecordedCopy>] = &[
    Column::new("copy", fields::COPY, |row| row.copy.into()),
    Column::for_people("copy_state", fields::STATE, |row| CellValue::State(row.copy_state.word().to_owned())),
    Column::for_people("translation_mm", fields::ORIGIN_AT, |row| row.translation_mm.map(at_text).into()),
    Column::for_people("rotation_xyzw", fields::TURN, |row| row.rotation_xyzw.map(turn_text).into()),
    Column::for_people("mark", fields::BREAK_OUT, |row| row.mark.map(mark_word).into()),
    Column::for_people("marked_by", fields::TOLD_BY, |row| row.marked_by.as_ref().into()),
    Column::for_people("marked_at", fields::OUTCOME_RECORDED, |row| row.marked_at.into()),
];

/// A mark of a break-out in words.
pub fn mark_word(mark: PickMark) -> String {
    match mark {
        PickMark::Out => say!("mark-out"),
        PickMark::Bad => say!("mark-bad"),
        PickMark::Missing => say!("mark-missing"),
        PickMark::Open => say!("mark-open"),
    }
}

/// The facts of a build in the record of a part.
pub fn record_facts(build: &RecordedBuild, view: &TimeView) -> Vec<SheetFact> {
    let optional_fact = |field: FieldDefinition, text: Option<String>| text.map(|text| field.fact_of(text));
    let released = build.place.released_at.zip(build.place.released_by.as_ref());
    let released = released.map(|(at, by)| say!("time-by", time = view.time_text(at), by = by));
    let told = build.told.as_ref();
    let outcome = told.map(|told| language::say_word("state", &told.outcome.to_string()));
    let lines = [
        Some(fields::STATE.fact_of(language::say_word("state", &build.fact.word))),
        fields::MACHINE.fact(&build.machine),
        fields::PRINTER.fact(build.place.printer.as_ref().filter(|printer| **printer != build.machine)),
        fields::MATERIAL.fact(&build.material),
        fields::LOT.fact(&build.lot),
        fields::HEIGHT.fact(build.height_mm),
        optional_fact(
            fields::CLEARANCE,
            clearance_text(build.clearance_mm, build.clearance_proved_mm, build.times.verified_at),
        ),
        view.time_fact(fields::VERIFIED, build.times.verified_at),
        optional_fact(fields::RELEASED, released),
        view.time_fact(fields::PUBLISHED, build.times.published_at),
        view.time_fact(fields::TAKEN, build.place.taken_at),
        optional_fact(fields::OUTCOME, outcome),
        fields::NOTE.fact(told.map(|told| &told.note)),
        fields::TOLD_BY.fact(told.map(|told| &told.told_by)),
        view.time_fact(fields::OUTCOME_RECORDED, told.map(|told| told.told_at)),
        fields::FILE.fact(build.file_name.as_ref()),
        optional_fact(
            fields::CONTENT,
            build.file_blake3.as_ref().map(|hash| content(build.file_bytes.unwrap_or_default(), hash)),
        ),
    ];
    lines.into_iter().flatten().collect()
}

/// `12.30 / 45.60 / 78.90 mm`.
fn at_text(translation_mm: [f64; 3]) -> String {
    let [x, y, z] = translation_mm.map(|mm| fields::SIZE.plain_text(&mm.into()).unwrap_or_default());
    format!("{x} / {y} / {z} mm")
}

/// `35.26° about 0.00 / 1.00 / 0.00`, by half a turn at most.
fn turn_text(rotation_xyzw: [f64; 4]) -> String {
    let rotation = DQuat::from_array(rotation_xyzw);
    let (axis, angle) = if rotation.w < 0.0 { -rotation } else { rotation }.to_axis_angle();
    let degrees = angle.to_degrees();
    if degrees < SLIGHT_DEG {
        return say!("turned-not");
    }
    let number = |number: f64| fields::SIZE.plain_text(&number.into()).unwrap_or_default();
    say!("turned-about", degrees = number(degrees), axis = axis.to_array().map(number).join(" / "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_told_by_half_a_turn_at_most() {
        let turned = |degrees: f64| turn_text(DQuat::from_rotation_y(degrees.to_radians()).to_array());
        assert_eq!(turned(0.0), "as in the file");
        assert_eq!(turned(0.001), "as in the file");
        assert_eq!(turned(35.264), "35.26\u{b0} about 0.00 / 1.00 / 0.00");
        assert_eq!(turned(270.0), "90.00\u{b0} about 0.00 / -1.00 / 0.00");
        assert_eq!(at_text([1.5, -0.001, 300.0]), "1.50 / 0.00 / 300.00 mm");
    }
}
