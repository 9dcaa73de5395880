//! What a section found: a row of the table.

/// A row of the table.
#[derive(Debug, Default)]
pub struct Row {
    /// Its name; the runner fills it in.
    pub section: &'static str,
    /// Different points, states or inputs that were tried.
    pub points: u64,
    /// Faults that were injected: kills, errors, lost operations.
    pub faults: u64,
    /// Files that went in.
    pub files: u64,
    /// Builds that came out.
    pub builds: u64,
    /// Every invariant that was found broken, as a sentence; must be empty.
    pub broken: Vec<String>,
    /// Wall time; the runner fills it in.
    pub seconds: f64,
    /// What a reader of the table should know: what was left out and why, figures of its own.
    pub note: String,
}

impl Row {
    /// What rows amount to together, without a name and a note.
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
