//! The pick map `.parts.csv`: lists which part belongs to which order, and where it is in the cake.

use std::io::Write;

use glam::DVec3;

use crate::{BuildFile, BuildFileItem, FileWriteError, OrderWords, csv_cell};

/// The columns of the pick map.
const COLUMNS: [Column<PickMapRow>; 18] = [
    ("item", |row| row.item.to_string()),
    ("part", |row| csv_cell(&row.part)),
    ("part_number", |row| csv_cell(&row.part_number)),
    ("order", |row| csv_cell(row.words.order.as_deref().unwrap_or_default())),
    ("copy", |row| row.copy.to_string()),
    ("source", |row| csv_cell(&row.source_name)),
    ("center_x_mm", |row| millimetres(row.center_mm.x)),
    ("center_y_mm", |row| millimetres(row.center_mm.y)),
    ("center_z_mm", |row| millimetres(row.center_mm.z)),
    ("size_x_mm", |row| millimetres(row.size_mm.x)),
    ("size_y_mm", |row| millimetres(row.size_mm.y)),
    ("size_z_mm", |row| millimetres(row.size_mm.z)),
    ("top_mm", |row| millimetres(row.top_mm)),
    ("source_hash", |row| row.source_hash.clone()),
    ("due", |row| csv_cell(row.words.due.as_deref().unwrap_or_default())),
    ("note", |row| csv_cell(row.words.note.as_deref().unwrap_or_default())),
    ("reference", |row| csv_cell(row.words.reference.as_deref().unwrap_or_default())),
    ("material", |row| csv_cell(row.words.material.as_deref().unwrap_or_default())),
];

/// One placed copy, for the person who unpacks the build.
#[derive(Debug, Clone, PartialEq)]
pub struct PickMapRow {
    /// Item number in the build, from 1.
    pub item: usize,
    /// Name of the part.
    pub part: String,
    /// The farm's number of the part.
    pub part_number: String,
    /// What its order says of it.
    pub words: OrderWords,
    /// Copy number, from 1.
    pub copy: u32,
    /// File name under which the part was dropped.
    pub source_name: String,
    /// BLAKE3 of the dropped file.
    pub source_hash: String,
    /// Middle of the placed bounds, mm in the machine frame.
    pub center_mm: DVec3,
    /// Edge lengths of the placed bounds, mm.
    pub size_mm: DVec3,
    /// Top of the placement, mm.
    pub top_mm: f64,
}

/// The rows of a build, in the order of its items. Items without an object are skipped.
pub fn pick_rows(build: &BuildFile) -> Vec<PickMapRow> {
    let row = |(item, placed): (usize, &BuildFileItem)| {
        let object = build.objects.get(placed.object)?;
        let bounds = object.mesh.bounds_at(&placed.pose);
        Some(PickMapRow {
            item,
            part: object.name.clone(),
            part_number: object.part_number.clone(),
            words: placed.words.clone(),
            copy: placed.copy,
            source_name: placed.source_name.clone(),
            source_hash: placed.source_hash.clone(),
            center_mm: bounds.center(),
            size_mm: bounds.size(),
            top_mm: bounds.max.z,
        })
    };
    (1..).zip(&build.items).filter_map(row).collect()
}

/// Writes rows as CSV with a header.
pub fn write_pick_map(rows: impl IntoIterator<Item = PickMapRow>, out: impl Write) -> Result<(), FileWriteError> {
    write_columns(COLUMNS, rows, out)
}

/// A column of a table: its name, and the text of its cell in a row.
pub(super) type Column<R> = (&'static str, fn(&R) -> String);

/// Writes rows as CSV with a header.
pub(super) fn write_columns<R, const N: usize>(
    columns: [Column<R>; N],
    rows: impl IntoIterator<Item = R>,
    out: impl Write,
) -> Result<(), FileWriteError> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(columns.map(|(name, _)| name)).map_err(csv_error)?;
    for row in rows {
        csv.write_record(columns.map(|(_, cell)| cell(&row))).map_err(csv_error)?;
    }
    csv.flush()?;
    Ok(())
}

fn millimetres(value: f64) -> String {
    format!("{value:.3}")
}

pub(super) fn csv_error(error: csv::Error) -> FileWriteError {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => FileWriteError::Io(error),
        other => FileWriteError::Package(format!("{other:?}")),
    }
}
