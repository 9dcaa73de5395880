//! Zones in which nothing may stand, as the paper's method meets them: obstacles that were there before the first part.

use solids::{Bounds, ClearanceTree, Pose};

use crate::Instance;

/// What is kept from a zone, mm, so that rounding in a written file never brings a part into it.
const SPARE_MM: f64 = 1e-4;

/// All zones of an instance.
pub(super) struct Zones(Vec<(Bounds, ClearanceTree)>);

impl Zones {
    /// Those of an instance.
    pub fn new(instance: &Instance) -> Self {
        let zones = instance.reserved().zones.iter();
        Self(zones.map(|zone| (zone.bounds, ClearanceTree::new(zone.mesh.clone()))).collect())
    }

    /// Top of the highest zone, mm.
    pub fn top_mm(&self) -> f64 {
        self.0.iter().map(|(bounds, _)| bounds.max.z).fold(0.0, f64::max)
    }

    /// Whether a part stands in a zone. Exact.
    pub fn meet(&self, surface: &ClearanceTree, pose: &Pose, bounds: &Bounds) -> bool {
        self.0.iter().any(|(zone, solid)| {
            zone.distance(bounds) < SPARE_MM
                && (solid.closer_than(surface, pose, SPARE_MM)
                    || solid.holds_part(surface, pose)
                    || surface.holds_part(solid, &pose.inverse()))
        })
    }
}
