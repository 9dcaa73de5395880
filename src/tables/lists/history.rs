//! The history: one row per build, and the totals of the published builds of each machine. A column added here
//! appears in the terminal, on the page and in the CSV. A test requires a column for each field of the JSON.

use farm::DatedBuild;
use ledger::HeightSummary;

use crate::tables::{
    columns::{cell_value::CellValue, table_column::TableColumn},
    fields,
};

/// Builds that are past nesting.
pub const HISTORY_COLUMNS: &[TableColumn<DatedBuild>] = &[
    TableColumn::new("build", fields::BUILD, |dated| dated.row.build.into()),
    TableColumn::new("machine", fields::MACHINE, |dated| (&dated.row.machine).into()),
    TableColumn::new("printer", fields::PRINTER, |dated| dated.row.printer.as_ref().into()),
    TableColumn::for_programs("state", fields::LEDGER_STATE, |dated| dated.row.state.into()),
    TableColumn::new("state_word", fields::STATE, |dated| CellValue::State(dated.fact.word.clone())),
    TableColumn::for_programs("ends_at", fields::DONE, |dated| dated.fact.ends_at.into()),
    TableColumn::new("at", fields::TIME, |dated| dated.row.at.into()),
    TableColumn::for_programs("published_at", fields::PUBLISHED, |dated| dated.row.published_at.into()),
    TableColumn::for_programs("withdrawn_at", fields::WITHDRAWN, |dated| dated.row.withdrawn_at.into()),
    TableColumn::new("height_mm", fields::HEIGHT, |dated| dated.row.measures.height_mm.into()),
    TableColumn::for_programs("volume_z_mm", fields::VOLUME_Z, |dated| dated.row.volume_z_mm.into()),
    TableColumn::for_people("used", fields::USED, |dated| dated.row.height_share().into()),
    TableColumn::new("density", fields::DENSITY, |dated| dated.row.measures.density.into()),
    TableColumn::new("lower_bound_mm", fields::LOWER_BOUND, |dated| dated.row.measures.lower_bound_mm.into()),
    TableColumn::new("layers", fields::LAYERS, |dated| dated.row.measures.layers.into()),
    TableColumn::new("parts", fields::PARTS, |dated| dated.row.parts.into()),
    TableColumn::new("copies", fields::COPIES, |dated| dated.row.measures.copies.into()),
    TableColumn::for_programs("part_volume_mm3", fields::PART_VOLUME_MM3, |dated| {
        dated.row.measures.part_volume_mm3.into()
    }),
    TableColumn::for_programs("clearance_mm", fields::CLEARANCE, |dated| dated.row.measures.clearance_mm.into()),
    TableColumn::new("clearance_proved_mm", fields::CLEARANCE_PROVED, |dated| {
        dated.row.measures.clearance_proved_mm.into()
    }),
    TableColumn::new("cpu_secs", fields::CPU, |dated| dated.row.search.cpu_secs.into()),
    TableColumn::for_programs("wall_secs", fields::WALL, |dated| dated.row.search.wall_secs.into()),
    TableColumn::for_programs("evaluations", fields::EVALUATIONS, |dated| dated.row.search.evaluations.into()),
    TableColumn::for_programs("seed", fields::SEED, |dated| dated.row.search.seed.into()),
    TableColumn::for_programs("method", fields::METHOD, |dated| dated.row.search.method.as_ref().into()),
    TableColumn::for_programs("version", fields::VERSION, |dated| dated.row.search.version.as_ref().into()),
    TableColumn::for_programs("repeats", fields::REPEATS, |dated| dated.row.search.repeats.into()),
    TableColumn::for_programs("material", fields::MATERIAL, |dated| (&dated.row.material).into()),
    TableColumn::for_programs("lot", fields::LOT, |dated| (&dated.row.lot).into()),
    TableColumn::for_programs("fired_by", fields::FIRED_BY, |dated| (&dated.row.fired_by).into()),
    TableColumn::for_programs("file_name", fields::FILE, |dated| dated.row.result.file_name.as_ref().into()),
    TableColumn::for_programs("reason", fields::REASON, |dated| CellValue::Prose(dated.row.result.reason.clone())),
    TableColumn::for_programs("note", fields::NOTE, |dated| (&dated.row.result.note).into()),
    TableColumn::for_people("file_or_reason", fields::FILE_OR_REASON, file_or_reason),
];

/// The columns of the page of the history, by their keys.
pub const HISTORY_PAGE_KEYS: [&str; 11] =
    ["build", "machine", "printer", "state_word", "at", "height_mm", "used", "density", "parts", "copies", "reason"];

fn file_or_reason(DatedBuild { row, .. }: &DatedBuild) -> CellValue {
    match &row.result.file_name {
        Some(file) => file.into(),
        None => CellValue::Prose(row.result.reason.clone()),
    }
}

/// The totals of the published builds of a machine.
pub const HEIGHT_SUM_COLUMNS: &[TableColumn<HeightSummary>] = &[
    TableColumn::new("machine", fields::MACHINE, |row| (&row.machine).into()),
    TableColumn::new("height_mm", fields::HEIGHT, |row| row.height_mm.into()),
    TableColumn::new("builds", fields::BUILDS, |row| row.builds.into()),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("mean_density", fields::MEAN_DENSITY, |row| row.mean_density.into()),
];
