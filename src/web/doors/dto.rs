//! Builds, parts and placements in the JSON interface. The name of a field ends in its unit. The daemon's internal
//! fields are left out.

use build_file::LengthUnit;
use farm::{BuildFact, CakeCopy, RecordedBuild};
use ledger::{
    BuildId, BuildMeasures, BuildRow, BuildState, BuildTimes, EventRow, FinishingStep, LineCopies, OutcomeRow, PartId,
    PartMending, PartRow, PartState, PlacementRow, PrintOutcome, PrinterPlace, SearchEffort, SolidOfFile, UtcTimestamp,
};
use nester::OrientationRule;
use schemars::JsonSchema;
use serde::Serialize;
use settings::MachineProfile;

use super::enum_words::{words_of, words_or_null};

/// A build with its parts, placements and outcomes.
#[derive(Serialize, JsonSchema)]
pub(crate) struct BuildResponse {
    /// The build itself.
    pub(crate) build: BuildResource,
    /// The parts that have copies in it.
    pub(crate) parts: Vec<PartResource>,
    /// The poses of their copies in it.
    pub(crate) placements: Vec<PlacementResource>,
    /// The outcomes recorded for it.
    pub(crate) outcomes: Vec<OutcomeResource>,
}

/// A part with its placements and events.
#[derive(Serialize, JsonSchema)]
pub(crate) struct PartResponse {
    /// The part itself.
    pub(crate) part: PartResource,
    /// The builds and poses of its copies.
    pub(crate) placements: Vec<PlacementResource>,
    /// What became of its copies.
    pub(crate) copies_now: LineCopies,
    /// The events of the part.
    pub(crate) events: Vec<EventResource>,
    /// Numbers of other parts with the same file content.
    pub(super) same_content: Vec<PartId>,
}

/// How the copies of a part were made.
#[derive(Serialize, JsonSchema)]
pub(crate) struct RecordResponse {
    /// The part itself.
    pub(super) part: PartResource,
    /// Its finishing steps, in their order.
    pub(super) finishing: Vec<FinishingStep>,
    /// The builds that made copies of it, in the order of their numbers.
    pub(super) builds: Vec<RecordedBuild>,
}

/// A build.
#[derive(Serialize, JsonSchema)]
pub(crate) struct BuildResource {
    /// Its number.
    build: BuildId,
    /// Machine.
    machine: String,
    /// Its state.
    state: BuildState,
    #[serde(flatten)]
    fact: BuildFact,
    /// Why it failed, or the note of its outcome.
    reason: String,
    /// What it is made of: what was loaded when it fired; "" = not known, or it has not fired.
    material: String,
    /// The lot of its powder, "" = not said.
    lot: String,
    /// Trigger that fired it: full, fill, copies, max_wait, due, at, flush.
    fired_by: String,
    /// How often its nesting was started.
    attempts: u32,
    #[serde(flatten)]
    times: BuildTimes,
    #[serde(flatten)]
    file: BuildFileFields,
    #[serde(flatten)]
    place: PrinterPlace,
    #[serde(flatten)]
    measures: BuildMeasures,
    #[serde(flatten)]
    search: SearchEffort,
    /// Build height over time in the final search; empty until the build file is proved.
    curve: Vec<CurvePoint>,
    #[serde(flatten)]
    snapshot: MachineSnapshot,
}

/// The file of a build.
#[derive(Serialize, JsonSchema)]
struct BuildFileFields {
    /// Name of the build file in the queue folder.
    file_name: Option<String>,
    /// BLAKE3 of the build file, 64 hex digits.
    file_blake3: Option<String>,
    /// Size of the build file.
    file_bytes: Option<u64>,
}

/// The settings of the machine when the build was made.
#[derive(Serialize, JsonSchema)]
struct MachineSnapshot {
    /// Volume of the machine when the build was made, mm.
    volume_mm: [f64; 3],
    /// Layer thickness of the machine when the build was made, mm.
    layer_mm: f64,
}

/// A point of the curve of build height over time.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurvePoint")]
struct CurvePoint {
    /// Wall time since the search began, seconds.
    wall_secs: f64,
    /// Build height at that time, mm.
    height_mm: f64,
}

/// A part: one solid of one dropped file.
#[derive(Serialize, JsonSchema)]
pub(crate) struct PartResource {
    /// Its number.
    part: PartId,
    /// Machine.
    machine: String,
    /// File name as dropped, escaped for display.
    name: String,
    #[serde(flatten)]
    solid: SolidOfFile,
    /// Its state.
    state: PartState,
    /// Why it was refused; "" = not refused.
    reason: String,
    /// Warnings, one sentence each.
    warnings: Vec<String>,
    /// Copies wanted: those ever wanted without the cancelled ones.
    copies: u32,
    /// Whether it is known how many copies are wanted; otherwise they are taken as 1.
    is_number_known: bool,
    #[serde(flatten)]
    terms: PartTermsFields,
    #[serde(flatten)]
    content: PartContentFields,
    #[serde(flatten)]
    mending: PartMending,
    /// When it was claimed. Its waiting time is counted from here.
    claimed_at: UtcTimestamp,
    /// When it entered its state.
    state_at: UtcTimestamp,
}

/// The requirements for a part, apart from the number of copies.
#[derive(Serialize, JsonSchema)]
struct PartTermsFields {
    /// Name of the order or kit; "" = none.
    order: String,
    /// Who it is for; "" = not said.
    customer: String,
    /// Where the customer gets e-mail; "" = not said.
    email: String,
    /// What it is to be made of; "" = anything.
    material: String,
    /// Finishing steps after the print; "" = none.
    finish: String,
    /// Whether it waits because its machine has another material loaded, or none.
    awaits_material: bool,
    /// Priority, 0 to 100.
    priority: u8,
    /// When it is due; a day is due at its last second in the time zone of the farm.
    due_at: Option<UtcTimestamp>,
    /// The due date as it was given; empty = none.
    due_text: String,
    /// Rule for its allowed orientations.
    #[schemars(with = "String", extend("enum" = words_of::<OrientationRule>()))]
    orientation: OrientationRule,
    /// Directions of its mesh that must stay within an angle of straight up: 'x,y,z:degrees', separated by ';'; empty
    /// = none.
    tilts: String,
    /// Its own clearance, mm; `None` = the clearance of the machine.
    clearance_mm: Option<f64>,
    /// Length unit given in the ticket; `None` = not given.
    #[schemars(with = "Option<String>", extend("enum" = words_or_null::<LengthUnit>()))]
    unit: Option<LengthUnit>,
    /// Free text of the ticket.
    note: String,
    /// What the customer's own system calls the line; empty = not said.
    reference: String,
}

/// The file of a part, and the measurements of its solid.
#[derive(Serialize, JsonSchema)]
struct PartContentFields {
    /// BLAKE3 of the file, 64 hex digits.
    blake3: String,
    /// Size of the file.
    file_bytes: u64,
    /// Number of triangles; `None` until the file is read.
    triangles: Option<u64>,
    /// Volume, mm3; `None` until the file is read.
    volume_mm3: Option<f64>,
    /// Width, depth and height in the orientation of the dropped file, mm; `None` until the file is read.
    size_mm: Option<[f64; 3]>,
}

/// A copy that is in a build.
#[derive(Serialize, JsonSchema)]
pub(crate) struct PlacementResource {
    /// Number of the part.
    part: PartId,
    /// Number of the copy, from 1.
    copy: u32,
    /// Number of the build.
    build: BuildId,
    /// State of the build.
    build_state: BuildState,
    /// When the build file was placed in the queue.
    published_at: Option<UtcTimestamp>,
    /// Whether it was told to be printed badly.
    bad: bool,
    /// Rotation from the mesh's frame to the machine's, a unit quaternion; `None` until the build is verified.
    rotation_xyzw: Option<[f64; 4]>,
    /// Translation after the rotation, machine frame, mm; `None` until the build is verified.
    translation_mm: Option<[f64; 3]>,
    /// Position of the copy in the proved removal order, from 1; `None` = no order is proved.
    #[serde(rename = "drawn_place")]
    removal_position: Option<u32>,
    /// Direction of the straight line along which the copy is removed: a unit vector in the machine's frame; `None` =
    /// no order is proved.
    #[serde(rename = "drawn_way")]
    removal_direction: Option<[f64; 3]>,
}

/// An outcome that a person recorded for a build.
#[derive(Serialize, JsonSchema)]
pub(crate) struct OutcomeResource {
    /// Outcome of the print.
    outcome: PrintOutcome,
    /// Note of the person, free text.
    note: String,
    /// Who recorded it, as user@host.
    told_by: String,
    /// When the outcome was recorded.
    told_at: UtcTimestamp,
}

/// Something that happened to a part.
#[derive(Serialize, JsonSchema)]
pub(crate) struct EventResource {
    /// When the event happened.
    at: UtcTimestamp,
    /// Kind of the event: the state that was entered, or another word.
    kind: String,
    /// Number of the build that the event is about.
    build: Option<BuildId>,
    /// Details of the event.
    detail: String,
    /// For a refusal, its cause as one word (format, not-closed, too-large, limit, ticket, duplicate, unreadable,
    /// failure, cancelled, other); empty otherwise.
    cause: String,
}

impl From<OutcomeRow> for OutcomeResource {
    fn from(row: OutcomeRow) -> Self {
        Self { outcome: row.outcome, note: row.note, told_by: row.told_by, told_at: row.told_at }
    }
}

impl From<EventRow> for EventResource {
    fn from(row: EventRow) -> Self {
        Self { at: row.at, kind: row.kind.to_string(), build: row.build_id, detail: row.detail, cause: row.cause }
    }
}

impl BuildResource {
    /// Creates the resource from a ledger row, what is so of the build, and its machine.
    pub(crate) fn new(row: BuildRow, fact: BuildFact, profile: &MachineProfile) -> Self {
        let curve =
            row.height_curve().into_iter().map(|(wall_secs, height_mm)| CurvePoint { wall_secs, height_mm }).collect();
        Self {
            build: row.id,
            machine: row.machine,
            state: row.state,
            fact,
            reason: row.reason,
            material: row.material,
            lot: row.lot,
            fired_by: row.fired_by,
            attempts: row.attempts,
            times: row.times,
            file: BuildFileFields {
                file_name: row.staged.file_name,
                file_blake3: row.staged.file_hash,
                file_bytes: row.staged.file_bytes,
            },
            place: row.place,
            measures: row.measures,
            search: row.search,
            curve,
            snapshot: MachineSnapshot {
                volume_mm: profile.space.volume_mm.to_array(),
                layer_mm: profile.space.layer_mm,
            },
        }
    }
}

impl From<PartRow> for PartResource {
    fn from(row: PartRow) -> Self {
        let (size_mm, is_number_known, copies) = (row.size_mm(), row.is_number_known(), row.wanted_copies());
        let (terms, measures) = (row.terms, row.measures);
        Self {
            part: row.id,
            machine: row.machine,
            name: row.name,
            solid: row.solid,
            state: row.state,
            reason: row.refused.reason,
            warnings: row.warnings.lines().map(str::to_owned).collect(),
            copies,
            is_number_known,
            terms: PartTermsFields {
                order: terms.order_name,
                customer: terms.customer,
                email: terms.email,
                material: terms.material,
                finish: terms.finish,
                awaits_material: row.owed.awaits_material,
                priority: terms.priority,
                due_at: terms.due_at,
                due_text: terms.due_text,
                orientation: terms.orientation,
                tilts: terms.tilts.to_string(),
                clearance_mm: terms.clearance_mm,
                unit: terms.unit,
                note: terms.note,
                reference: terms.reference,
            },
            mending: row.mending,
            content: PartContentFields {
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
    /// Creates the resource for a copy in the current layout of a build that is not proved yet.
    pub(super) fn from_open_layout(build: &BuildRow, part: PartId, standing: &CakeCopy) -> Self {
        Self {
            part,
            copy: standing.copy,
            build: build.id,
            build_state: build.state,
            published_at: build.times.published_at,
            bad: false,
            rotation_xyzw: Some(standing.pose.rotation.to_array()),
            translation_mm: Some(standing.pose.translation.to_array()),
            removal_position: None,
            removal_direction: None,
        }
    }
}

impl From<PlacementRow> for PlacementResource {
    fn from(row: PlacementRow) -> Self {
        let (pose, removal) = (row.pose(), row.removal_step());
        Self {
            part: row.part_id,
            copy: row.copy + 1,
            build: row.build_id,
            build_state: row.build_state,
            published_at: row.published_at,
            bad: row.is_bad,
            rotation_xyzw: pose.map(|pose| pose.rotation.to_array()),
            translation_mm: pose.map(|pose| pose.translation.to_array()),
            removal_position: removal.map(|removal| removal.position),
            removal_direction: removal.map(|removal| removal.direction),
        }
    }
}
