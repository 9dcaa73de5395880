//! The result of a section: a row of the table.

/// How often something was done to the farms of a run, as far as its sections count it.
#[derive(Debug, Default, Clone, Copy)]
pub struct ActionCounts {
    /// kill -9 of a daemon, or of a command.
    pub kills: u64,
    /// Ledgers that were put back from a backup, each followed by a deep check.
    pub restores: u64,
    /// Changes of copies or terms after the drop.
    pub edits: u64,
    /// Orders over HTTP.
    pub door_orders: u64,
}

impl std::ops::Add for ActionCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            kills: self.kills + other.kills,
            restores: self.restores + other.restores,
            edits: self.edits + other.edits,
            door_orders: self.door_orders + other.door_orders,
        }
    }
}

/// How a violation begins that is about copies in the files that printers took.
pub const LOST: &str = "LOST";
/// Likewise.
pub const DOUBLED: &str = "DOUBLED";
/// Likewise.
pub const WRONG_IN_SIZE: &str = "WRONG IN SIZE";

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
    /// What was done.
    pub counts: ActionCounts,
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
            counts: rows.iter().fold(ActionCounts::default(), |sum, row| sum + row.counts),
            ..Self::default()
        }
    }

    /// What was done, and how many violations there are of each kind, as a line.
    pub fn summary(&self) -> String {
        let ActionCounts { kills, restores, edits, door_orders } = self.counts;
        let of = |kind: &str| self.broken.iter().filter(|text| text.contains(&format!("{kind}:"))).count();
        let [lost, doubled, sizes] = [LOST, DOUBLED, WRONG_IN_SIZE].map(of);
        format!(
            "{kills} kills, {restores} restores, {edits} edits, {door_orders} orders over HTTP, {} builds: {lost} lost, {doubled} doubled, \
             {sizes} wrong in size, {} violations in all",
            self.builds,
            self.broken.len()
        )
    }
}
