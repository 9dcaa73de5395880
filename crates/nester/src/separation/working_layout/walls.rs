//! What is known of parts that stand out of the walls or of the height limit. Such a part is too long for the room at its
//! rotation: it can be shifted, but not inside; it must turn, or go elsewhere.

use glam::Vec3;

use super::super::{
    pair_records::{MAX_WEIGHT, WEIGHT_DECAY},
    separation_step::CollisionProxy,
};

/// Excess up to which a proxy counts as inside, mm: its bounds have single precision.
const EXCESS_TOLERANCE_MM: f32 = 5e-4;
/// How much further inside a part must stand after the exact test found it outside, mm. It is hardly more than the
/// tolerance: a part that fits between two walls with less to spare could never keep it.
const WALL_MARGIN_MM: f32 = 1e-3;
/// Growth of the weight of an excess from round to round.
const WEIGHT_GROWTH: f32 = 2.0;

/// What is known of one part and the walls.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallRecord {
    /// Weight of the part's excess.
    pub(super) weight: f32,
    /// Distance that the proxy must keep from the far walls and the height limit, mm.
    margin_mm: f32,
}

impl WallRecord {
    /// Nothing is known.
    pub(super) const NONE: Self = Self { weight: 1.0, margin_mm: 0.0 };

    /// How far a clamped proxy of the part stands out of a room (width, depth and height limit in mm) along each axis, mm.
    pub(super) fn excess_mm(&self, proxy: &CollisionProxy, room: Vec3) -> Vec3 {
        let excess = proxy.max - (room - self.margin_mm);
        Vec3::select(excess.cmpgt(Vec3::splat(EXCESS_TOLERANCE_MM)), excess, Vec3::ZERO)
    }

    /// Makes the weight grow if the part stands out, and decay otherwise.
    pub(super) fn weigh(&mut self, stands_out: bool) {
        let factor = if stands_out { WEIGHT_GROWTH } else { WEIGHT_DECAY };
        self.weight = (self.weight * factor).clamp(1.0, MAX_WEIGHT);
    }

    /// Makes the part come further inside: the exact test found it outside, although its proxy may seem to be inside.
    pub(super) fn require_inside(&mut self) {
        self.margin_mm = WALL_MARGIN_MM;
    }
}
