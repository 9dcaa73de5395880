//! The row of a build, and the data recorded for a verified build.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{BuildId, BuildState, UtcTimestamp, base::sql::sql_row};

/// Maximum number of points of a stored curve.
const MAX_POINTS: usize = 300;

/// A build. While it is open, height, density and copies describe its layout so far.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildRow {
    /// Its number.
    pub id: BuildId,
    /// Machine.
    pub machine: String,
    /// Current state.
    pub state: BuildState,
    /// Why it failed, or the note of its outcome.
    pub reason: String,
    /// What was loaded on its machine when it fired; "" = not known, or it has not fired.
    pub material: String,
    /// The lot of its powder that was loaded when its printer took it; "" = not said.
    pub lot: String,
    /// Trigger: full, fill, copies, max_wait, due, at, flush.
    pub fired_by: String,
    /// Number of times that nesting was started.
    pub attempts: u32,
    /// Number of searches started since the last one that finished.
    pub searches: u32,
    /// Times of its states.
    #[serde(flatten)]
    pub times: BuildTimes,
    /// Its file.
    #[serde(flatten)]
    pub staged: StagedFile,
    /// The printer that it is for.
    #[serde(flatten)]
    pub place: PrinterPlace,
    /// Its measurements.
    #[serde(flatten)]
    pub measures: BuildMeasures,
    /// Cost and parameters of its search.
    #[serde(flatten)]
    pub search: SearchEffort,
    /// Its data stored as JSON.
    #[serde(flatten)]
    pub kept: BuildDocuments,
}

sql_row!(BuildRow { id, machine, state, reason, material, lot, fired_by, attempts, searches; times, staged, place, measures, search, kept });

/// Times at which a build entered its states.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BuildTimes {
    /// When it was opened.
    pub opened_at: UtcTimestamp,
    /// When it fired.
    pub nesting_at: Option<UtcTimestamp>,
    /// When its file was verified.
    pub verified_at: Option<UtcTimestamp>,
    /// When its file was put into the queue.
    pub published_at: Option<UtcTimestamp>,
    /// When it entered its current state.
    pub state_at: UtcTimestamp,
}

sql_row!(BuildTimes { opened_at, nesting_at, verified_at, published_at, state_at });

/// The file of a build, the queue folder where it was staged, and the start of its publishing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StagedFile {
    /// Name of the build file in the queue folder.
    pub file_name: Option<String>,
    /// Marker of the queue folder that it was staged in.
    pub queue_id: Option<String>,
    /// BLAKE3 of the build file, 64 hex digits.
    pub file_hash: Option<String>,
    /// Size of the build file.
    pub file_bytes: Option<u64>,
    /// When publishing began: set before the first attempt to rename its file into the queue.
    pub publishing_at: Option<UtcTimestamp>,
}

sql_row!(StagedFile { file_name, queue_id, file_hash, file_bytes, publishing_at });

/// The printer of a build, what is known of the way of its file, and whether a person has released it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct PrinterPlace {
    /// The printer in whose queue folder its file is, or was; `None` = the only one of its machine, or not decided.
    pub printer: Option<String>,
    /// When its file was first seen to be gone from the queue folder.
    pub taken_at: Option<UtcTimestamp>,
    /// The printer that its published file is being moved to.
    pub move_to: Option<String>,
    /// Marker of the queue folder where all of the moved file is: from then on it may be visible there.
    #[serde(skip)]
    pub move_queue_id: Option<String>,
    /// When a person said that it may be published.
    pub released_at: Option<UtcTimestamp>,
    /// Who said so.
    pub released_by: Option<String>,
    /// Who wants its file back out of the queue: user@host, or nestd; `None` = nobody, or it is done.
    pub withdraw_by: Option<String>,
    /// When its file was taken back out of the queue, and its copies were put back.
    pub withdrawn_at: Option<UtcTimestamp>,
}

impl PrinterPlace {
    /// Whether its file is being taken back: for a word that waits for it, or for another printer.
    pub fn is_on_its_way(&self) -> bool {
        self.move_to.is_some() || self.withdraw_by.is_some()
    }
}

sql_row!(PrinterPlace {
    printer,
    taken_at,
    move_to,
    move_queue_id,
    released_at,
    released_by,
    withdraw_by,
    withdrawn_at
});

/// Measurements of a build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BuildMeasures {
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Part volume / (base area x height), 0..1.
    pub density: Option<f64>,
    /// Lower bound of the height of any build of these parts, mm.
    pub lower_bound_mm: Option<f64>,
    /// Layers to print.
    pub layers: Option<u32>,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: Option<f64>,
    /// Number of placed copies.
    pub copies: Option<u32>,
    /// Required clearance, mm.
    pub clearance_mm: Option<f64>,
    /// Smallest distance measured between the triangles of the written file, mm.
    pub clearance_proved_mm: Option<f64>,
}

sql_row!(BuildMeasures {
    height_mm,
    density,
    lower_bound_mm,
    layers,
    part_volume_mm3,
    copies,
    clearance_mm,
    clearance_proved_mm
});

/// Cost of the search for a build, and the parameters to repeat it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SearchEffort {
    /// CPU seconds of all nesting for it.
    pub cpu_secs: Option<f64>,
    /// Wall seconds of the final nesting.
    pub wall_secs: Option<f64>,
    /// Evaluations of the final nesting.
    pub evaluations: Option<u64>,
    /// Seed of the final nesting, with its bits stored as a signed number.
    pub seed: Option<i64>,
    /// Search method: nestd or paper.
    pub method: Option<String>,
    /// Version of nestd.
    pub version: Option<String>,
    /// The build whose proved layout it repeats; `None` = it was searched for.
    pub repeats: Option<BuildId>,
}

sql_row!(SearchEffort { cpu_secs, wall_secs, evaluations, seed, method, version, repeats });

/// Data of a build stored as JSON. User interfaces omit the fields that are too long to read.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildDocuments {
    /// The best layout so far while open or nesting.
    #[serde(skip)]
    pub layout: Option<String>,
    /// The profile at the time of the build.
    pub profile_snapshot: Option<String>,
    /// Height over time: see [`BuildRow::height_curve`].
    #[serde(skip)]
    curve: Option<String>,
    /// Files staged beside the build file: see [`BuildRow::sidecar_hashes`].
    #[serde(skip)]
    sidecars: Option<String>,
}

sql_row!(BuildDocuments { layout, profile_snapshot, curve, sidecars });

/// A state for people: "withdrawn" for a build that was taken back out of the queue.
pub(crate) fn state_word(state: BuildState, withdrawn_at: Option<UtcTimestamp>) -> String {
    withdrawn_at.map_or_else(|| state.to_string(), |_| "withdrawn".to_owned())
}

impl BuildRow {
    /// Its state for people, who call a build that was taken back out of the queue withdrawn, and not failed.
    pub fn state_word(&self) -> String {
        state_word(self.state, self.place.withdrawn_at)
    }

    /// Height over time: (wall seconds, build height in mm) of each improvement that the search found. Empty until the
    /// build is verified.
    pub fn height_curve(&self) -> Vec<(f64, f64)> {
        self.kept.curve.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }

    /// Name and BLAKE3 of each file staged beside the build file. Empty if unknown.
    pub fn sidecar_hashes(&self) -> Vec<(String, String)> {
        self.kept.sidecars.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }
}

/// The stored layout of an open build.
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

/// The data of a build whose file was written and verified.
#[derive(Debug, Clone, PartialEq)]
pub struct Verified {
    /// Its file.
    pub file: ProvedFile,
    /// Its measurements.
    pub measures: ProvedMeasures,
    /// Cost and parameters of its search.
    pub search: FinalSearch,
    /// JSON, the profile at the time of the build.
    pub profile_snapshot: String,
}

/// A build file that is verified and staged.
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

/// Measurements of a verified build.
#[derive(Debug, Clone, PartialEq)]
pub struct ProvedMeasures {
    /// Build height, mm.
    pub height_mm: f64,
    /// Part volume / (base area x height), 0..1.
    pub density: f64,
    /// Lower bound of the height of any build of these parts, mm.
    pub lower_bound_mm: f64,
    /// Layers to print.
    pub layers: u32,
    /// Volume of all parts in it, mm3.
    pub part_volume_mm3: f64,
    /// Number of placed copies.
    pub copies: u32,
    /// Required clearance, mm.
    pub clearance_mm: f64,
    /// Smallest distance measured between the triangles of the written file, mm; `None` = a single copy has no
    /// neighbour.
    pub clearance_proved_mm: Option<f64>,
}

/// The final search for a build.
#[derive(Debug, Clone, PartialEq)]
pub struct FinalSearch {
    /// CPU seconds; they are added to those of [`crate::Ledger::add_cpu_secs`].
    pub cpu_secs: f64,
    /// Wall seconds.
    pub wall_secs: f64,
    /// Evaluations.
    pub evaluations: u64,
    /// Seed.
    pub seed: u64,
    /// Search method: nestd or paper.
    pub method: String,
    /// Version of nestd.
    pub version: String,
    /// Height over time: (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
}

impl FinalSearch {
    /// The curve as JSON for the ledger, thinned to a few hundred points. The last point is always kept.
    pub(crate) fn curve_json(&self) -> String {
        let step = self.curve.len().div_ceil(MAX_POINTS).max(1);
        let kept = self.curve.iter().rev().step_by(step);
        let rounded = |&(secs, mm): &(f64, f64)| ((1e3 * secs).round() / 1e3, (1e4 * mm).round() / 1e4);
        let mut points: Vec<(f64, f64)> = kept.map(rounded).collect();
        points.reverse();
        serde_json::to_string(&points).unwrap_or_default()
    }
}
