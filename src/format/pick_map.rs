//! The pick map `.parts.csv`: who takes which part out of the cake, and where it is.

use std::io::Write;

use glam::DVec3;

use super::{BuildFile, WriteError};

/// One placed copy, for the person who breaks the build out.
#[derive(Debug, Clone, PartialEq)]
pub struct PickRow {
    /// Item number in the build, from 1.
    pub item: usize,
    /// Name of the part.
    pub part: String,
    /// The farm's number of the part.
    pub part_number: String,
    /// Order or kit that the copy is for.
    pub order: Option<String>,
    /// Copy number, from 1.
    pub copy: u32,
    /// Name that the part was dropped under.
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

/// The rows of a build, in the order of its items.
pub fn pick_rows(build: &BuildFile) -> Vec<PickRow> {
    let _ = build;
    Vec::new()
}

/// Writes rows as CSV with a header.
pub fn write_pick_map(rows: impl IntoIterator<Item = PickRow>, out: impl Write) -> Result<(), WriteError> {
    let _ = (rows.into_iter().count(), out);
    Err(WriteError::Build("empty".to_owned()))
}
