//! Oriented bounding boxes.

use glam::DVec3;

use super::Pose;

/// A box in any orientation: `pose` takes the box's own frame (centre at its origin, faces along its axes) to the frame
/// that it stands in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obb {
    /// Box frame -> surrounding frame.
    pub pose: Pose,
    /// Half the edge lengths along the box's own axes, mm.
    pub half_mm: DVec3,
}

impl Obb {
    /// Volume, mm3.
    pub fn volume_mm3(&self) -> f64 {
        8.0 * self.half_mm.element_product()
    }
}
