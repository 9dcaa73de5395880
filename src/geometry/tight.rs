//! Pairs as a tight layout has them, for tests of speed; the benches read this file, too.

use glam::{DQuat, DVec3};
use rand_chacha::{ChaCha8Rng, rand_core::Rng};

use super::{ClearanceTree, Pose};

/// Evenly in [-1, 1].
pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
}

fn direction(rng: &mut ChaCha8Rng) -> DVec3 {
    DVec3::new(unit(rng), unit(rng), unit(rng)).normalize_or(DVec3::X)
}

/// A random turn, moved along a random direction until the distance is at most 0.05 mm more than `gap_mm`.
pub fn tight(one: &ClearanceTree, two: &ClearanceTree, gap_mm: f64, rng: &mut ChaCha8Rng) -> Pose {
    let (axis, angle, way) = (direction(rng), unit(rng) * 3.0, direction(rng));
    let rotation = DQuat::from_axis_angle(axis, angle);
    let (center1, center2) = (one.mesh().bounds().center(), rotation * two.mesh().bounds().center());
    let at = |far: f64| Pose::new(rotation, center1 - center2 + way * far);
    let (mut near, mut far) = (0.0, 1000.0);
    while far - near > 0.05 {
        let middle = 0.5 * (near + far);
        if one.closer_than(two, &at(middle), gap_mm) {
            near = middle;
        } else {
            far = middle;
        }
    }
    at(far)
}
