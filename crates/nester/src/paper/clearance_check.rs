//! Whether placements keep their clearance, on the triangles.

use solids::{Bounds, Pose};

use super::shape::PaperShape;
use crate::{ItemPlacement, NestingInstance, prepare::prepared_instance::raised_bounds};

/// Whether two placements keep their clearance on the triangles and neither is inside the other.
pub(super) fn keeps_clearance(
    instance: &NestingInstance,
    shapes: &[PaperShape],
    (one, bounds1): (&ItemPlacement, &Bounds),
    (two, bounds2): (&ItemPlacement, &Bounds),
) -> bool {
    let (surface1, surface2) = (&shapes[one.item].surface, &shapes[two.item].surface);
    let pose12 = one.pose.relative_pose_of(&two.pose);
    surfaces_keep_clearance(instance, shapes, (one.item, &one.pose, bounds1), (two.item, &two.pose, bounds2))
        && !surface1.contains_part(surface2, &pose12)
        && !surface2.contains_part(surface1, &pose12.inverse())
}

/// Whether the surfaces of two placements keep their clearance, also when either is raised by the allowed extra height.
pub(super) fn surfaces_keep_clearance(
    instance: &NestingInstance,
    shapes: &[PaperShape],
    (item1, pose1, bounds1): (usize, &Pose, &Bounds),
    (item2, pose2, bounds2): (usize, &Pose, &Bounds),
) -> bool {
    let (clearance_mm, extra_mm) = (instance.clearance_between_mm(item1, item2), instance.clearance_z_extra_mm());
    let gap_mm = raised_bounds(bounds1, extra_mm).distance(&raised_bounds(bounds2, extra_mm));
    if gap_mm > 0.0 && gap_mm >= clearance_mm {
        return true;
    }
    let (surface1, surface2, pose12) = (&shapes[item1].surface, &shapes[item2].surface, pose1.relative_pose_of(pose2));
    if extra_mm <= 0.0 {
        return !surface1.is_closer_than(surface2, &pose12, clearance_mm - 1e-7);
    }
    let slide1 = pose1.inverse().transform_direction(glam::DVec3::Z * extra_mm);
    let found_mm = surface1.distance_sliding_mm(surface2, &pose12, slide1, clearance_mm.max(1e-6));
    found_mm > 0.0 && found_mm >= clearance_mm - 1e-7
}
