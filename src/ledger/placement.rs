//! Placements: which copy of which part is in which build, and how it stands there.

use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildState, PartId, Utc};

/// A copy with its pose in a proved build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedCopy {
    /// The part.
    pub part: PartId,
    /// Its copy, from 0.
    pub copy: u32,
    /// Rotation, unit quaternion x y z w.
    pub rotation: [f64; 4],
    /// Translation after the rotation, machine frame, mm.
    pub translation_mm: [f64; 3],
}

/// A copy that is in a build.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct PlacementRow {
    /// The part.
    pub part_id: PartId,
    /// Its copy, from 0.
    pub copy: u32,
    /// The build.
    pub build_id: BuildId,
    /// Where the build stands.
    pub build_state: BuildState,
    /// When the build came into the queue.
    pub published_at: Option<Utc>,
    /// Rotation, unit quaternion; `None` until the build is verified.
    pub qx: Option<f64>,
    /// Second part of the quaternion.
    pub qy: Option<f64>,
    /// Third part of the quaternion.
    pub qz: Option<f64>,
    /// Real part of the quaternion.
    pub qw: Option<f64>,
    /// Translation after the rotation, machine frame, mm; `None` until the build is verified.
    pub tx_mm: Option<f64>,
    /// Translation along y, mm.
    pub ty_mm: Option<f64>,
    /// Translation along z, mm.
    pub tz_mm: Option<f64>,
}
