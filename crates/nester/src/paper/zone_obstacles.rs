//! Keep-out zones in the paper's method: obstacles that exist before the first part.

use solids::{Bounds, ClearanceTree, Pose};

use crate::NestingInstance;

/// Distance kept from a zone, mm, so that rounding in a written file never brings a part into it.
const SPARE_MM: f64 = 1e-4;

/// All zones of an instance.
pub(super) struct ZoneObstacles(Vec<(Bounds, ClearanceTree)>);

impl ZoneObstacles {
    /// Creates the zones of an instance.
    pub fn new(instance: &NestingInstance) -> Self {
        let zones = instance.reserved_space().zones.iter();
        Self(zones.map(|zone| (zone.bounds, ClearanceTree::new(zone.mesh.clone()))).collect())
    }

    /// Top of the highest zone, mm.
    pub fn top_mm(&self) -> f64 {
        self.0.iter().map(|(bounds, _)| bounds.max.z).fold(0.0, f64::max)
    }

    /// Whether a part reaches into a zone. Exact.
    pub fn intersect_part(&self, surface: &ClearanceTree, pose: &Pose, bounds: &Bounds) -> bool {
        self.0.iter().any(|(zone, solid)| {
            zone.distance(bounds) < SPARE_MM
                && (solid.is_closer_than(surface, pose, SPARE_MM)
                    || solid.contains_part(surface, pose)
                    || surface.contains_part(solid, &pose.inverse()))
        })
    }
}
