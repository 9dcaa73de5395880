//! Builds, parts and placements in the JSON interface: every field names its unit, and the daemon's internal fields are
//! left out.

use build_file::LengthUnit;
use nester::OrientationRule;
use schemars::JsonSchema;
use serde::Serialize;

use super::enum_words::{words_of, words_or_null};

use crate::{
    farm::CakeCopy,
    ledger::{
        BuildId, BuildMeasures, BuildRow, BuildState, BuildTimes, EventRow, OutcomeRow, PartId, PartRow, PartState,
        PlacementRow, PrintOutcome, SearchEffort, SolidOfFile, UtcTimestamp,
    },
    settings::MachineProfile,
};

/// A build with all that belongs to it.
#[derive(Serialize, JsonSchema)]
pub(super) struct BuildResponse {
    /// The build itself.
    pub(super) build: BuildResource,
    /// The parts that have copies in it.
    pub(super) parts: Vec<PartResource>,
    /// Where their copies are in it.
    pub(super) placements: Vec<PlacementResource>,
    /// What was told of it.
    pub(super) outcomes: Vec<OutcomeResource>,
}

/// A part with all that belongs to it.
#[derive(Serialize, JsonSchema)]
pub(super) struct PartResponse {
    /// The part itself.
    pub(super) part: PartResource,
    /// Where its copies are.
    pub(super) placements: Vec<PlacementResource>,
    /// What happened to it.
    pub(super) events: Vec<EventResource>,
    /// Numbers of parts of the same content at other times.
    pub(super) same_content: Vec<PartId>,
}

/// A build.
#[derive(Serialize, JsonSchema)]
pub(super) struct BuildResource {
    /// Its number.
    build: BuildId,
    /// Machine profile.
    profile: String,
    /// Where it stands.
    state: BuildState,
    /// Why it failed, or the outcome's note.
    reason: String,
    /// Trigger: full, fill, copies, max_wait, due, at, flush.
    fired_by: String,
    /// How often nesting was begun.
    attempts: u32,
    #[serde(flatten)]
    times: BuildTimes,
    #[serde(flatten)]
    file: ToldFile,
    #[serde(flatten)]
    measures: BuildMeasures,
    #[serde(flatten)]
    search: SearchEffort,
    /// How the height fell in the final search; empty until its file was proved.
    curve: Vec<CurvePoint>,
    #[serde(flatten)]
    machine: MachineThen,
}

/// The file of a build.
#[derive(Serialize, JsonSchema)]
struct ToldFile {
    /// Name of the build file in the queue folder.
    file_name: Option<String>,
    /// BLAKE3 of the build file, 64 hex digits.
    file_blake3: Option<String>,
    /// Size of the build file.
    file_bytes: Option<u64>,
}

/// The machine of a build as it was when the build was made.
#[derive(Serialize, JsonSchema)]
struct MachineThen {
    /// Volume of the machine as it was when the build was made, mm.
    volume_mm: [f64; 3],
    /// Its layer, mm.
    layer_mm: f64,
}

/// A point of the curve along which the height fell.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurvePoint")]
struct CurvePoint {
    /// Wall seconds since the search began.
    wall_secs: f64,
    /// Build height then, mm.
    height_mm: f64,
}

/// A part: one solid of one dropped file.
#[derive(Serialize, JsonSchema)]
pub(super) struct PartResource {
    /// Its number.
    part: PartId,
    /// Machine profile.
    profile: String,
    /// File name as dropped, escaped for display.
    name: String,
    #[serde(flatten)]
    solid: SolidOfFile,
    /// Where it stands.
    state: PartState,
    /// Why it was rejected, "" otherwise.
    reason: String,
    /// What was odd, a sentence each.
    warnings: Vec<String>,
    /// Copies in all.
    copies: u32,
    #[serde(flatten)]
    terms: ToldTerms,
    #[serde(flatten)]
    content: ToldContent,
    /// When it was claimed: its age in line.
    claimed_at: UtcTimestamp,
    /// When its state was entered.
    state_at: UtcTimestamp,
}

/// What was asked of a part, beside the copies.
#[derive(Serialize, JsonSchema)]
struct ToldTerms {
    /// Order or kit, "" = none.
    order: String,
    /// 0 to 100.
    priority: u8,
    /// When it is due.
    due_at: Option<UtcTimestamp>,
    /// How it may be turned.
    #[schemars(with = "String", extend("enum" = words_of::<OrientationRule>()))]
    orientation: OrientationRule,
    /// Directions of its mesh that must stand within an angle of straight up: 'x,y,z:degrees' with ';' between them; empty = none.
    tilts: String,
    /// Its own clearance, mm; `None` = the profile's.
    clearance_mm: Option<f64>,
    /// Unit that the ticket said.
    #[schemars(with = "Option<String>", extend("enum" = words_or_null::<LengthUnit>()))]
    unit: Option<LengthUnit>,
    /// Free text of the ticket.
    note: String,
}

/// The file of a part, and what was measured of its solid.
#[derive(Serialize, JsonSchema)]
struct ToldContent {
    /// BLAKE3 of the file, 64 hex digits.
    blake3: String,
    /// Size of the file.
    file_bytes: u64,
    /// Triangles; `None` until read.
    triangles: Option<u64>,
    /// Volume, mm3; `None` until read.
    volume_mm3: Option<f64>,
    /// Width, depth and height as dropped, mm; `None` until read.
    size_mm: Option<[f64; 3]>,
}

/// A copy that is in a build.
#[derive(Serialize, JsonSchema)]
pub(super) struct PlacementResource {
    /// The part.
    part: PartId,
    /// Its copy, from 1.
    copy: u32,
    /// The build.
    build: BuildId,
    /// Where the build stands.
    build_state: BuildState,
    /// When the build came into the queue.
    published_at: Option<UtcTimestamp>,
    /// Rotation from the mesh's frame to the machine's, a unit quaternion; `None` until the build is verified.
    rotation_xyzw: Option<[f64; 4]>,
    /// Translation after the rotation, machine frame, mm; `None` until the build is verified.
    translation_mm: Option<[f64; 3]>,
    /// As which copy it is drawn out of the cake, from 1, as it was proved; `None` = not proved.
    drawn_place: Option<u32>,
    /// The straight line that it takes: a unit vector in the machine's frame.
    drawn_way: Option<[f64; 3]>,
}

/// An outcome that a person recorded for a build.
#[derive(Serialize, JsonSchema)]
pub(super) struct OutcomeResource {
    /// What became of it.
    outcome: PrintOutcome,
    /// Free text.
    note: String,
    /// user@host.
    told_by: String,
    /// When.
    told_at: UtcTimestamp,
}

/// Something that happened to a part.
#[derive(Serialize, JsonSchema)]
pub(super) struct EventResource {
    /// When.
    at: UtcTimestamp,
    /// What: a state that was entered, or a word of its own.
    kind: String,
    /// The build that it is about.
    build: Option<BuildId>,
    /// More about it.
    detail: String,
    /// Of a refusal, its kind as one word (format, not-closed, too-large, limit, ticket, duplicate, unreadable, failure, cancelled, other); empty otherwise.
    cause: String,
}

impl From<OutcomeRow> for OutcomeResource {
    fn from(row: OutcomeRow) -> Self {
        Self { outcome: row.outcome, note: row.note, told_by: row.told_by, told_at: row.told_at }
    }
}

impl From<EventRow> for EventResource {
    fn from(row: EventRow) -> Self {
        Self { at: row.at, kind: row.kind, build: row.build_id, detail: row.detail, cause: row.cause }
    }
}

impl BuildResource {
    /// A build with the machine that it was made for.
    pub(super) fn new(row: BuildRow, profile: &MachineProfile) -> Self {
        let curve =
            row.height_curve().into_iter().map(|(wall_secs, height_mm)| CurvePoint { wall_secs, height_mm }).collect();
        Self {
            build: row.id,
            profile: row.profile,
            state: row.state,
            reason: row.reason,
            fired_by: row.fired_by,
            attempts: row.attempts,
            times: row.times,
            file: ToldFile {
                file_name: row.staged.file_name,
                file_blake3: row.staged.file_hash,
                file_bytes: row.staged.file_bytes,
            },
            measures: row.measures,
            search: row.search,
            curve,
            machine: MachineThen { volume_mm: profile.space.volume_mm.to_array(), layer_mm: profile.space.layer_mm },
        }
    }
}

impl From<PartRow> for PartResource {
    fn from(row: PartRow) -> Self {
        let size_mm = row.size_mm();
        let (terms, measures) = (row.terms, row.measures);
        Self {
            part: row.id,
            profile: row.profile,
            name: row.name,
            solid: row.solid,
            state: row.state,
            reason: row.reason,
            warnings: row.warnings.lines().map(str::to_owned).collect(),
            copies: row.copies,
            terms: ToldTerms {
                order: terms.order_name,
                priority: terms.priority,
                due_at: terms.due_at,
                orientation: terms.orientation,
                tilts: terms.tilts.to_string(),
                clearance_mm: terms.clearance_mm,
                unit: terms.unit,
                note: terms.note,
            },
            content: ToldContent {
                blake3: row.file.content_hash,
                file_bytes: row.file.bytes,
                triangles: measures.triangles,
                volume_mm3: measures.volume_mm3,
                size_mm,
            },
            claimed_at: row.times.claimed_at,
            state_at: row.times.state_at,
        }
    }
}

impl PlacementResource {
    /// A copy in the current layout of a build that is not proved yet.
    pub(super) fn from_open_layout(build: &BuildRow, part: PartId, standing: &CakeCopy) -> Self {
        Self {
            part,
            copy: standing.copy,
            build: build.id,
            build_state: build.state,
            published_at: build.times.published_at,
            rotation_xyzw: Some(standing.pose.rotation.to_array()),
            translation_mm: Some(standing.pose.translation.to_array()),
            drawn_place: None,
            drawn_way: None,
        }
    }
}

impl From<PlacementRow> for PlacementResource {
    fn from(row: PlacementRow) -> Self {
        let (pose, drawn) = (row.pose(), row.removal_step());
        Self {
            part: row.part_id,
            copy: row.copy + 1,
            build: row.build_id,
            build_state: row.build_state,
            published_at: row.published_at,
            rotation_xyzw: pose.map(|pose| pose.rotation.to_array()),
            translation_mm: pose.map(|pose| pose.translation.to_array()),
            drawn_place: drawn.map(|drawn| drawn.position),
            drawn_way: drawn.map(|drawn| drawn.direction),
        }
    }
}
