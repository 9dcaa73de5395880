//! The result of a section: a row of the table.

/// A row of the table.
#[derive(Debug, Default)]
pub struct SectionResult {
    /// The name of the section; the runner fills it in.
    pub section: &'static str,
    /// Different points, states or inputs that were tried.
    pub points: u64,
    /// Faults that were injected: kills, errors, lost operations.
    pub faults: u64,
    /// Dropped files.
    pub files: u64,
    /// Finished builds.
    pub builds: u64,
    /// Every violation of an invariant, as a sentence; must be empty.
    pub broken: Vec<String>,
    /// Wall time; the runner fills it in.
    pub seconds: f64,
    /// Notes for readers of the table: omissions with their reasons, further figures.
    pub note: String,
}

impl SectionResult {
    /// The sum of rows, without a name and a note.
    pub fn sum(rows: &[Self]) -> Self {
        Self {
            points: rows.iter().map(|row| row.points).sum(),
            faults: rows.iter().map(|row| row.faults).sum(),
            files: rows.iter().map(|row| row.files).sum(),
            builds: rows.iter().map(|row| row.builds).sum(),
            broken: rows.iter().flat_map(|row| row.broken.clone()).collect(),
            seconds: rows.iter().map(|row| row.seconds).sum(),
            ..Self::default()
        }
    }
}
