//! How the copies of a part were made, for a customer or an auditor who asks: for each build the powder, the file, its proof and the print,
//! and for each copy where it stood and who took it out of the cake.

use std::collections::BTreeMap;

use anyhow::Result;
use ledger::{
    BuildId, BuildRow, BuildTimes, Ledger, OutcomeRow, PartId, PickMark, PickMarkRow, PlacementRow, PrinterPlace,
    UtcTimestamp,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    build_fact::{BuildFact, build_fact},
    copy_fact::{CopyWord, copy_fact},
};
use crate::planning::MachinePlan;

/// A build that made copies of a part.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RecordedBuild {
    /// Its number.
    pub build: BuildId,
    /// Machine.
    pub machine: String,
    /// How far it is.
    #[serde(flatten)]
    pub fact: BuildFact,
    /// What it is made of; "" = not known.
    pub material: String,
    /// The lot of its powder; "" = not said.
    pub lot: String,
    /// Its printer, when that took its file, and who released it.
    #[serde(flatten)]
    pub place: PrinterPlace,
    /// Times of its states.
    #[serde(flatten)]
    pub times: BuildTimes,
    /// Name of its file.
    pub file_name: Option<String>,
    /// BLAKE3 of its file, 64 hex digits.
    pub file_blake3: Option<String>,
    /// Size of its file.
    pub file_bytes: Option<u64>,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Clearance that was asked for, mm.
    pub clearance_mm: Option<f64>,
    /// Smallest distance that was measured between the triangles of its file, mm.
    pub clearance_proved_mm: Option<f64>,
    /// What was told of its print last.
    pub told: Option<RecordedOutcome>,
    /// The copies of the part in it.
    pub copies: Vec<RecordedCopy>,
}

/// What somebody told of the print of a build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RecordedOutcome {
    /// The outcome.
    pub outcome: ledger::PrintOutcome,
    /// Free text.
    pub note: String,
    /// Who told it.
    pub told_by: String,
    /// When.
    pub told_at: UtcTimestamp,
}

/// A copy in the record of its part.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RecordedCopy {
    /// Its number, from 1.
    pub copy: u32,
    /// What became of it.
    pub copy_state: CopyWord,
    /// Rotation from the file's frame to the machine's, a unit quaternion; `None` = its row is damaged.
    pub rotation_xyzw: Option<[f64; 4]>,
    /// Where the origin of the file stood, machine frame, mm.
    pub translation_mm: Option<[f64; 3]>,
    /// What was said of it when the build was broken out: out, bad, missing; `None` = nothing.
    pub mark: Option<PickMark>,
    /// Who said so.
    pub marked_by: Option<String>,
    /// When.
    pub marked_at: Option<UtcTimestamp>,
}

impl From<OutcomeRow> for RecordedOutcome {
    fn from(row: OutcomeRow) -> Self {
        Self { outcome: row.outcome, note: row.note, told_by: row.told_by, told_at: row.told_at }
    }
}

impl RecordedCopy {
    fn new(placed: &PlacementRow, marks: &[PickMarkRow], plans: &[MachinePlan]) -> Self {
        let of_copy = |row: &&PickMarkRow| (row.part_id, row.copy) == (placed.part_id, placed.copy);
        let mark = marks.iter().find(of_copy);
        let pose = placed.pose();
        Self {
            copy: placed.copy + 1,
            copy_state: copy_fact(placed, plans),
            rotation_xyzw: pose.map(|pose| pose.rotation.to_array()),
            translation_mm: pose.map(|pose| pose.translation.to_array()),
            mark: mark.map(|row| row.mark),
            marked_by: mark.map(|row| row.told_by.clone()),
            marked_at: mark.map(|row| row.told_at),
        }
    }
}

impl RecordedBuild {
    fn new(build: BuildRow, told: Option<RecordedOutcome>, copies: Vec<RecordedCopy>, plans: &[MachinePlan]) -> Self {
        Self {
            fact: build_fact(&build, plans),
            build: build.id,
            machine: build.machine,
            material: build.material,
            lot: build.lot,
            place: build.place,
            times: build.times,
            file_name: build.staged.file_name,
            file_blake3: build.staged.file_hash,
            file_bytes: build.staged.file_bytes,
            height_mm: build.measures.height_mm,
            clearance_mm: build.measures.clearance_mm,
            clearance_proved_mm: build.measures.clearance_proved_mm,
            told,
            copies,
        }
    }
}

/// The builds that made copies of a part, in the order of their numbers. A build counts once its file is proved; one that was taken back
/// out of the queue made nothing.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_part_record(ledger: &Ledger, part: PartId, plans: &[MachinePlan]) -> Result<Vec<RecordedBuild>> {
    let mut placed: BTreeMap<BuildId, Vec<PlacementRow>> = BTreeMap::new();
    for row in ledger.placements_of_part(part).await? {
        if !row.is_withdrawn {
            placed.entry(row.build_id).or_default().push(row);
        }
    }
    let mut record = Vec::with_capacity(placed.len());
    for (id, placed) in placed {
        let Some(build) = ledger.find_build(id).await?.filter(|build| build.times.verified_at.is_some()) else {
            continue;
        };
        let marks = ledger.picks_of_build(id).await?;
        let copies = placed.iter().map(|placed| RecordedCopy::new(placed, &marks, plans)).collect();
        let told = ledger.outcomes_of_build(id).await?.pop().map(RecordedOutcome::from);
        record.push(RecordedBuild::new(build, told, copies, plans));
    }
    Ok(record)
}
