//! Builds, parts and placements as the JSON interface tells them: every field with its unit, and nothing that is the
//! daemon's own affair.

use build_file::Unit;
use nester::OrientationRule;
use serde::Serialize;

use crate::{
    farm::Standing,
    ledger::{
        BuildId, BuildRow, BuildState, EventRow, Outcome, OutcomeRow, PartId, PartRow, PartState, PlacementRow, Utc,
    },
    settings::Profile,
};

/// A build with all that belongs to it.
#[derive(Serialize)]
pub(super) struct BuildSheet {
    pub(super) build: Build,
    pub(super) parts: Vec<Part>,
    pub(super) placements: Vec<Placement>,
    pub(super) outcomes: Vec<ToldOutcome>,
}

/// A part with all that belongs to it.
#[derive(Serialize)]
pub(super) struct PartSheet {
    pub(super) part: Part,
    pub(super) placements: Vec<Placement>,
    pub(super) events: Vec<Event>,
    /// Parts of the same content at other times.
    pub(super) same_content: Vec<PartId>,
}

#[derive(Serialize)]
pub(super) struct Build {
    build: BuildId,
    profile: String,
    state: BuildState,
    reason: String,
    fired_by: String,
    attempts: u32,
    opened_at: Utc,
    nesting_at: Option<Utc>,
    verified_at: Option<Utc>,
    published_at: Option<Utc>,
    state_at: Utc,
    file_name: Option<String>,
    file_blake3: Option<String>,
    file_bytes: Option<u64>,
    height_mm: Option<f64>,
    lower_bound_mm: Option<f64>,
    density: Option<f64>,
    layers: Option<u32>,
    part_volume_mm3: Option<f64>,
    copies: Option<u32>,
    clearance_mm: Option<f64>,
    clearance_proved_mm: Option<f64>,
    cpu_secs: Option<f64>,
    wall_secs: Option<f64>,
    evaluations: Option<u64>,
    seed: Option<i64>,
    method: Option<String>,
    version: Option<String>,
    curve: Vec<Point>,
    /// The machine's as it was when the build was made.
    volume_mm: [f64; 3],
    layer_mm: f64,
}

/// A point of the curve along which the height fell.
#[derive(Serialize)]
struct Point {
    wall_secs: f64,
    height_mm: f64,
}

#[derive(Serialize)]
pub(super) struct Part {
    part: PartId,
    profile: String,
    name: String,
    object_name: String,
    object_index: u32,
    order: String,
    state: PartState,
    reason: String,
    warnings: Vec<String>,
    copies: u32,
    priority: u8,
    due_at: Option<Utc>,
    orientation: OrientationRule,
    tilts: String,
    clearance_mm: Option<f64>,
    unit: Option<Unit>,
    note: String,
    blake3: String,
    file_bytes: u64,
    triangles: Option<u64>,
    volume_mm3: Option<f64>,
    size_mm: Option<[f64; 3]>,
    claimed_at: Utc,
    state_at: Utc,
}

#[derive(Serialize)]
pub(super) struct Placement {
    part: PartId,
    /// From 1.
    copy: u32,
    build: BuildId,
    build_state: BuildState,
    published_at: Option<Utc>,
    /// Unit quaternion x y z w: mesh frame -> machine frame.
    rotation_xyzw: Option<[f64; 4]>,
    translation_mm: Option<[f64; 3]>,
    /// As which copy it is drawn out of the cake, from 1.
    drawn_place: Option<u32>,
    drawn_way: Option<[f64; 3]>,
}

/// What somebody told of a build.
#[derive(Serialize)]
pub(super) struct ToldOutcome {
    outcome: Outcome,
    note: String,
    told_by: String,
    told_at: Utc,
}

/// Something that happened to a part.
#[derive(Serialize)]
pub(super) struct Event {
    at: Utc,
    kind: String,
    build: Option<BuildId>,
    detail: String,
    cause: String,
}

impl From<OutcomeRow> for ToldOutcome {
    fn from(row: OutcomeRow) -> Self {
        Self { outcome: row.outcome, note: row.note, told_by: row.told_by, told_at: row.told_at }
    }
}

impl From<EventRow> for Event {
    fn from(row: EventRow) -> Self {
        Self { at: row.at, kind: row.kind, build: row.build_id, detail: row.detail, cause: row.cause }
    }
}

impl Build {
    /// A build with the machine that it was made for.
    pub(super) fn new(row: BuildRow, profile: &Profile) -> Self {
        let curve = row.curve().into_iter().map(|(wall_secs, height_mm)| Point { wall_secs, height_mm }).collect();
        Self {
            build: row.id,
            profile: row.profile,
            state: row.state,
            reason: row.reason,
            fired_by: row.fired_by,
            attempts: row.attempts,
            opened_at: row.opened_at,
            nesting_at: row.nesting_at,
            verified_at: row.verified_at,
            published_at: row.published_at,
            state_at: row.state_at,
            file_name: row.file_name,
            file_blake3: row.file_hash,
            file_bytes: row.file_bytes,
            height_mm: row.height_mm,
            lower_bound_mm: row.lower_bound_mm,
            density: row.density,
            layers: row.layers,
            part_volume_mm3: row.part_volume_mm3,
            copies: row.copies,
            clearance_mm: row.clearance_mm,
            clearance_proved_mm: row.clearance_proved_mm,
            cpu_secs: row.cpu_secs,
            wall_secs: row.wall_secs,
            evaluations: row.evaluations,
            seed: row.seed,
            method: row.method,
            version: row.version,
            curve,
            volume_mm: profile.volume_mm.to_array(),
            layer_mm: profile.layer_mm,
        }
    }
}

impl From<PartRow> for Part {
    fn from(row: PartRow) -> Self {
        let (size_mm, tilts) = (row.size_mm(), row.tilts.to_string());
        Self {
            part: row.id,
            profile: row.profile,
            name: row.name,
            object_name: row.object_name,
            object_index: row.object_index,
            order: row.order_name,
            state: row.state,
            reason: row.reason,
            warnings: row.warnings.lines().map(str::to_owned).collect(),
            copies: row.copies,
            priority: row.priority,
            due_at: row.due_at,
            orientation: row.orientation,
            tilts,
            clearance_mm: row.clearance_mm,
            unit: row.unit,
            note: row.note,
            blake3: row.content_hash,
            file_bytes: row.bytes,
            triangles: row.triangles,
            volume_mm3: row.volume_mm3,
            size_mm,
            claimed_at: row.claimed_at,
            state_at: row.state_at,
        }
    }
}

impl Placement {
    /// A copy in the layout that a build has so far.
    pub(super) fn so_far(build: &BuildRow, part: PartId, standing: &Standing) -> Self {
        Self {
            part,
            copy: standing.copy,
            build: build.id,
            build_state: build.state,
            published_at: build.published_at,
            rotation_xyzw: Some(standing.pose.rotation.to_array()),
            translation_mm: Some(standing.pose.translation.to_array()),
            drawn_place: None,
            drawn_way: None,
        }
    }
}

impl From<PlacementRow> for Placement {
    fn from(row: PlacementRow) -> Self {
        let (pose, drawn) = (row.pose(), row.drawn());
        Self {
            part: row.part_id,
            copy: row.copy + 1,
            build: row.build_id,
            build_state: row.build_state,
            published_at: row.published_at,
            rotation_xyzw: pose.map(|pose| pose.rotation.to_array()),
            translation_mm: pose.map(|pose| pose.translation.to_array()),
            drawn_place: drawn.map(|drawn| drawn.place),
            drawn_way: drawn.map(|drawn| drawn.way),
        }
    }
}
