//! A build as its row says, and what is recorded of one that is proved.

use schemars::JsonSchema;
use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildState, Utc};

/// Points of a curve that are kept.
const MOST_POINTS: usize = 300;

/// A build. Of an open build height, density and copies are those of its layout so far.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct BuildRow {
    /// Its number.
    pub id: BuildId,
    /// Machine profile.
    pub profile: String,
    /// Where it stands.
    pub state: BuildState,
    /// Why it failed, or the outcome's note.
    pub reason: String,
    /// Trigger: full, fill, copies, max_wait, due, at, flush.
    pub fired_by: String,
    /// How often nesting was begun.
    pub attempts: u32,
    /// How often a search was begun since one came to its end.
    pub searches: u32,
    /// When it was where in its life.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub times: BuildTimes,
    /// Its file.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub staged: StagedFile,
    /// What was measured of it.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub measures: BuildMeasures,
    /// What the search for it took.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub search: SearchEffort,
    /// What is kept of it as JSON.
    #[serde(flatten)]
    #[sqlx(flatten)]
    pub kept: BuildDocuments,
}

/// When a build was where in its life.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, FromRow)]
pub struct BuildTimes {
    /// When it was opened.
    pub opened_at: Utc,
    /// When it fired.
    pub nesting_at: Option<Utc>,
    /// When its file was proved.
    pub verified_at: Option<Utc>,
    /// When it came into the queue.
    pub published_at: Option<Utc>,
    /// When its state was entered.
    pub state_at: Utc,
}

/// The file of a build, where it was staged, and how far its publishing went.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct StagedFile {
    /// Name of the build file in the queue folder.
    pub file_name: Option<String>,
    /// Which queue folder it was staged in (its marker).
    pub queue_id: Option<String>,
    /// BLAKE3 of the build file, 64 hex digits.
    pub file_hash: Option<String>,
    /// Size of the build file.
    pub file_bytes: Option<u64>,
    /// When the first rename that publishes it was about to be tried.
    pub publishing_at: Option<Utc>,
}

/// What was measured of a build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, FromRow)]
pub struct BuildMeasures {
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Part volume / (base area x height), 0..1.
    pub density: Option<f64>,
    /// No build of these parts can be lower, mm.
    pub lower_bound_mm: Option<f64>,
    /// Layers to print.
    pub layers: Option<u32>,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: Option<f64>,
    /// Placements.
    pub copies: Option<u32>,
    /// Clearance asked, mm.
    pub clearance_mm: Option<f64>,
    /// Least distance found on the triangles of the written file, mm.
    pub clearance_proved_mm: Option<f64>,
}

/// What the search for a build took, and what it is repeated with.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, FromRow)]
pub struct SearchEffort {
    /// CPU seconds of all nesting for it.
    pub cpu_secs: Option<f64>,
    /// Wall seconds of the final nesting.
    pub wall_secs: Option<f64>,
    /// Evaluations of the final nesting.
    pub evaluations: Option<u64>,
    /// Seed of the final nesting, its bits as a signed number.
    pub seed: Option<i64>,
    /// nestd or paper.
    pub method: Option<String>,
    /// Version of nestd.
    pub version: Option<String>,
}

/// What is kept of a build as JSON; faces leave out what is too long for a person.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct BuildDocuments {
    /// The best layout so far while open or nesting.
    #[serde(skip)]
    pub layout: Option<String>,
    /// The profile as it was.
    pub profile_snapshot: Option<String>,
    /// How the height fell: see [`BuildRow::curve`].
    #[serde(skip)]
    curve: Option<String>,
    /// What is staged beside the build file: see [`BuildRow::sidecars`].
    #[serde(skip)]
    sidecars: Option<String>,
}

impl BuildRow {
    /// How the height fell: (wall seconds, build height in mm) of the search's improvements; empty until verified.
    pub fn curve(&self) -> Vec<(f64, f64)> {
        self.kept.curve.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }

    /// Name and BLAKE3 of each file that is staged beside the build file; empty where that is not known.
    pub fn sidecars(&self) -> Vec<(String, String)> {
        self.kept.sidecars.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }
}

/// The layout of an open build as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenLayout {
    /// JSON, the layout itself.
    pub layout: String,
    /// Its height, mm.
    pub height_mm: f64,
    /// Its density, 0..1.
    pub density: f64,
    /// Copies placed in it.
    pub copies: u32,
    /// Volume of the placed parts, mm3.
    pub part_volume_mm3: f64,
}

/// What is known of a build whose file is written and proved.
#[derive(Debug, Clone, PartialEq)]
pub struct Verified {
    /// Its file.
    pub file: ProvedFile,
    /// What was measured of it.
    pub measures: ProvedMeasures,
    /// What the search for it took.
    pub search: FinalSearch,
    /// JSON, the profile as it was.
    pub profile_snapshot: String,
}

/// A build file that is proved and staged.
#[derive(Debug, Clone, PartialEq)]
pub struct ProvedFile {
    /// Name of the build file in the queue folder.
    pub file_name: String,
    /// Marker of the queue folder that it is staged in.
    pub queue_id: String,
    /// BLAKE3 of the build file, 64 hex digits.
    pub file_hash: String,
    /// Size of the build file.
    pub file_bytes: u64,
    /// Name and BLAKE3 of each file that is staged beside it.
    pub sidecars: Vec<(String, String)>,
}

/// What was measured of a build that is proved.
#[derive(Debug, Clone, PartialEq)]
pub struct ProvedMeasures {
    /// Build height, mm.
    pub height_mm: f64,
    /// Part volume / (base area x height), 0..1.
    pub density: f64,
    /// No build of these parts can be lower, mm.
    pub lower_bound_mm: f64,
    /// Layers to print.
    pub layers: u32,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: f64,
    /// Placements.
    pub copies: u32,
    /// Clearance asked, mm.
    pub clearance_mm: f64,
    /// Least distance found on the triangles of the written file, mm; `None` = a single copy has no neighbour.
    pub clearance_proved_mm: Option<f64>,
}

/// The final search for a build.
#[derive(Debug, Clone, PartialEq)]
pub struct FinalSearch {
    /// CPU seconds; they are added to those of [`super::Ledger::add_cpu_secs`].
    pub cpu_secs: f64,
    /// Wall seconds.
    pub wall_secs: f64,
    /// Evaluations.
    pub evaluations: u64,
    /// Seed.
    pub seed: u64,
    /// nestd or paper.
    pub method: String,
    /// Version of nestd.
    pub version: String,
    /// How the height fell: (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
}

impl FinalSearch {
    /// The curve as the ledger keeps it, of a few hundred points at most, the last one always.
    pub(super) fn curve_json(&self) -> String {
        let step = self.curve.len().div_ceil(MOST_POINTS).max(1);
        let kept = self.curve.iter().rev().step_by(step);
        let rounded = |&(secs, mm): &(f64, f64)| ((1e3 * secs).round() / 1e3, (1e4 * mm).round() / 1e4);
        let mut points: Vec<(f64, f64)> = kept.map(rounded).collect();
        points.reverse();
        serde_json::to_string(&points).unwrap_or_default()
    }
}
