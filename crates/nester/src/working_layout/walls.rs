//! Parts of a working layout that stand out of the walls or of the height limit: a part that is too long for the room at
//! its rotation. It can be shifted, but not inside; it must turn, or go elsewhere.

use glam::Vec3;

use super::{super::separation_step::CollisionProxy, MAX_WEIGHT, WEIGHT_DECAY, WorkingLayout};

/// Excess up to which a proxy counts as inside, mm: its bounds have single precision.
const EXCESS_TOLERANCE_MM: f32 = 5e-4;
/// How much further inside a part must stand after the exact test found it outside, mm.
const WALL_MARGIN_MM: f32 = 0.02;
/// Growth of the weight of an excess from round to round.
const WEIGHT_GROWTH: f32 = 2.0;

/// What is known of one part and the walls.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallRecord {
    /// Weight of the part's excess.
    weight: f32,
    /// Distance that the proxy must keep from the far walls and the height limit, mm.
    pub(super) margin_mm: f32,
}

impl WallRecord {
    /// Nothing is known.
    pub(super) const NONE: Self = Self { weight: 1.0, margin_mm: 0.0 };
}

impl WorkingLayout<'_> {
    /// How far a clamped proxy of a part stands out of the room, unweighted, in the unit of overlap.
    pub(super) fn excess_energy(&self, part: usize, proxy: &CollisionProxy) -> f32 {
        let room = self.prepared.room.with_z(self.height_limit_mm).as_vec3();
        let excess = (proxy.max - (room - self.walls[part].margin_mm)).max(Vec3::ZERO);
        let radius = proxy.shape.radius_mm as f32;
        if excess.max_element() > EXCESS_TOLERANCE_MM { excess.length() * radius * radius } else { 0.0 }
    }

    /// The same with its weight.
    pub(super) fn weighted_excess(&self, part: usize, proxy: &CollisionProxy) -> f32 {
        self.walls[part].weight * self.excess_energy(part, proxy)
    }

    /// Whether a part stands out of the room.
    pub(super) fn stands_out(&self, part: usize) -> bool {
        self.excess_energy(part, &self.proxies[part]) > 0.0
    }

    /// The unweighted excess of a part. Its weight grows if there is any, and decays otherwise.
    pub(super) fn weigh_excess(&mut self, part: usize) -> f32 {
        let energy = self.excess_energy(part, &self.proxies[part]);
        if self.prepared.components.weights {
            let factor = if energy > 0.0 { WEIGHT_GROWTH } else { WEIGHT_DECAY };
            self.walls[part].weight = (self.walls[part].weight * factor).clamp(1.0, MAX_WEIGHT);
        }
        energy
    }

    /// Makes a part that the exact test found outside come further inside, although its proxy may seem to be inside.
    pub(super) fn require_inside(&mut self, part: usize) {
        if !self.parts.fixed[part] {
            self.walls[part].margin_mm = WALL_MARGIN_MM;
        }
    }
}
