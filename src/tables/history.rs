//! The history: a build a row, and what the published builds of each machine come to. A column that is added here stands in the
//! terminal, on the page and in the CSV; a test demands that each field of the JSON is a column.

use super::{cell_value::CellValue, fields, table_column::TableColumn as Column};
use crate::ledger::{HeightSummary, HistoryRow};

/// Builds that are past nesting.
pub const HISTORY_COLUMNS: &[Column<HistoryRow>] = &[
    Column::new("build", fields::BUILD, |row| row.build.into()),
    Column::new("profile", fields::PROFILE, |row| (&row.profile).into()),
    Column::new("state", fields::STATE, |row| row.state.into()),
    Column::new("at", fields::TIME, |row| row.at.into()),
    Column::for_programs("published_at", fields::PUBLISHED, |row| row.published_at.into()),
    Column::new("height_mm", fields::HEIGHT, |row| row.measures.height_mm.into()),
    Column::for_programs("volume_z_mm", fields::VOLUME_Z, |row| row.volume_z_mm.into()),
    Column::for_people("used", fields::USED, |row| row.height_share().into()),
    Column::new("density", fields::DENSITY, |row| row.measures.density.into()),
    Column::new("lower_bound_mm", fields::LOWER_BOUND, |row| row.measures.lower_bound_mm.into()),
    Column::new("layers", fields::LAYERS, |row| row.measures.layers.into()),
    Column::new("parts", fields::PARTS, |row| row.parts.into()),
    Column::new("copies", fields::COPIES, |row| row.measures.copies.into()),
    Column::for_programs("part_volume_mm3", fields::PART_VOLUME_MM3, |row| row.measures.part_volume_mm3.into()),
    Column::for_programs("clearance_mm", fields::CLEARANCE, |row| row.measures.clearance_mm.into()),
    Column::new("clearance_proved_mm", fields::CLEARANCE_PROVED, |row| row.measures.clearance_proved_mm.into()),
    Column::new("cpu_secs", fields::CPU, |row| row.search.cpu_secs.into()),
    Column::for_programs("wall_secs", fields::WALL, |row| row.search.wall_secs.into()),
    Column::for_programs("evaluations", fields::EVALUATIONS, |row| row.search.evaluations.into()),
    Column::for_programs("seed", fields::SEED, |row| row.search.seed.into()),
    Column::for_programs("method", fields::METHOD, |row| row.search.method.as_ref().into()),
    Column::for_programs("version", fields::VERSION, |row| row.search.version.as_ref().into()),
    Column::for_programs("fired_by", fields::FIRED_BY, |row| (&row.fired_by).into()),
    Column::for_programs("file_name", fields::FILE, |row| row.result.file_name.as_ref().into()),
    Column::for_programs("reason", fields::REASON, |row| (&row.result.reason).into()),
    Column::for_programs("note", fields::NOTE, |row| (&row.result.note).into()),
    Column::for_people("file_or_reason", fields::FILE_OR_REASON, file_or_reason),
];

fn file_or_reason(row: &HistoryRow) -> CellValue {
    row.result.file_name.as_ref().unwrap_or(&row.result.reason).into()
}

/// What the published builds of a machine come to.
pub const HEIGHT_SUM_COLUMNS: &[Column<HeightSummary>] = &[
    Column::new("profile", fields::PROFILE, |row| (&row.profile).into()),
    Column::new("height_mm", fields::HEIGHT, |row| row.height_mm.into()),
    Column::new("builds", fields::BUILDS, |row| row.builds.into()),
    Column::new("copies", fields::COPIES, |row| row.copies.into()),
    Column::new("mean_density", fields::MEAN_DENSITY, |row| row.mean_density.into()),
];
