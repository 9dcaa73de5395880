//! Finds the points where two surfaces come near each other, not only the distance as
//! [`ClearanceTree::distance_capped_mm`] does, so that a search knows the direction of separation.

use glam::DVec3;

use crate::{
    ClearanceTree, Pose,
    mesh::triangle::{Triangle, closest_point},
};

/// Two points of two surfaces that are near each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceContact {
    /// Point of the first surface, in the first mesh's frame, mm.
    pub point1: DVec3,
    /// Point of the second surface, in the first mesh's frame too, mm.
    pub point2: DVec3,
}

impl SurfaceContact {
    /// Distance of the two points, mm.
    pub fn distance_mm(&self) -> f64 {
        self.point1.distance(self.point2)
    }
}

impl ClearanceTree {
    /// Calls `each` with the places at which the surfaces are nearer than `limit_mm` without meeting: of every patch of
    /// this surface that comes so near, the nearest points. Patches are at most `patch_mm` across; where triangles are
    /// larger, patches of the other surface are taken apart instead. Where the surfaces
    /// meet, it calls nothing. `pose12` is the frame of `other` seen from this one.
    pub fn visit_contacts(
        &self,
        other: &Self,
        pose12: &Pose,
        (patch_mm, limit_mm): (f64, f64),
        each: &mut dyn FnMut(SurfaceContact),
    ) {
        let walk = self.pair_walk(other, pose12);
        walk.visit_near_patches(patch_mm as f32, limit_mm * limit_mm, &mut |one, two| each(closest_points(one, two)));
    }
}

/// The nearest points of two triangles that do not intersect: a corner of one and a point of the other, or points on
/// two edges.
fn closest_points(one: &Triangle, two: &Triangle) -> SurfaceContact {
    let mut best = SurfaceContact { point1: one.corners[0], point2: two.corners[0] };
    let mut try_pair = |point1: DVec3, point2: DVec3| {
        if point1.distance_squared(point2) < best.point1.distance_squared(best.point2) {
            best = SurfaceContact { point1, point2 };
        }
    };
    for corner in one.corners {
        try_pair(corner, closest_point(corner, &two.corners));
    }
    for corner in two.corners {
        try_pair(closest_point(corner, &one.corners), corner);
    }
    for i in 0..3 {
        for j in 0..3 {
            let (from1, to1) = (one.corners[i], one.corners[(i + 1) % 3]);
            let (from2, to2) = (two.corners[j], two.corners[(j + 1) % 3]);
            if let Some((point1, point2)) = nearest_on_segments(from1, to1 - from1, from2, to2 - from2) {
                try_pair(point1, point2);
            }
        }
    }
    best
}

/// The nearest points of two lines, if both lie within the segments; ends of segments are not considered.
fn nearest_on_segments(from1: DVec3, d1: DVec3, from2: DVec3, d2: DVec3) -> Option<(DVec3, DVec3)> {
    let r = from1 - from2;
    let (a, b, c, e, f) = (d1.length_squared(), d1.dot(d2), d1.dot(r), d2.length_squared(), d2.dot(r));
    let spread = a * e - b * b;
    if spread <= 1e-12 * a * e {
        return None;
    }
    let (s, t) = ((b * f - c * e) / spread, (a * f - b * c) / spread);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then(|| (from1 + d1 * s, from2 + d2 * t))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DQuat;
    use proptest::prelude::*;

    use super::*;
    use crate::{Mesh, fixtures};

    #[test]
    fn a_large_face_is_touched_wherever_the_other_part_stands() {
        let foot = |x: f64| fixtures::cuboid(DVec3::new(x, 20.0, 2.5), DVec3::new(x + 8.0, 28.0, 10.5));
        let (left, right) = (foot(5.0), foot(85.0));
        let vertices = [left.vertices(), right.vertices()].concat();
        let moved = right.triangles().iter().map(|t| t.map(|corner| corner + left.vertices().len() as u32));
        let triangles = left.triangles().iter().copied().chain(moved).collect();
        let feet = ClearanceTree::new(Arc::new(Mesh::new(vertices, triangles).expect("two boxes are solids")));
        let plate = ClearanceTree::new(fixtures::block(100.0, 60.0, 2.0));
        let mut places = Vec::new();
        plate.visit_contacts(&feet, &Pose::IDENTITY, (6.0, 1.0), &mut |contact| places.push(contact.point1.x));
        assert!(places.iter().any(|&x| x < 20.0) && places.iter().any(|&x| x > 80.0), "{places:?}");
    }

    #[test]
    fn a_fine_surface_gives_few_contacts_each_the_nearest_of_its_patch() {
        let ball = || ClearanceTree::new(fixtures::star(5, |_| 20.0));
        let (one, two) = (ball(), ball());
        let pose12 = Pose::new(DQuat::IDENTITY, DVec3::X * 41.0);
        let contacts = |patch_mm: f64| {
            let mut found = Vec::new();
            one.visit_contacts(&two, &pose12, (patch_mm, 2.0), &mut |contact| found.push(contact.distance_mm()));
            found
        };
        let (coarse, fine) = (contacts(8.0), contacts(0.0));
        assert!(!coarse.is_empty() && 4 * coarse.len() < fine.len(), "{} of {}", coarse.len(), fine.len());
        let least = |found: &[f64]| found.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least(&coarse) - least(&fine)).abs() < 1e-9, "{} and {}", least(&coarse), least(&fine));
    }

    proptest! {
        #[test]
        fn the_nearest_contact_has_the_exact_distance(
            turn in proptest::array::uniform3(-3.0..3.0f64), shift in proptest::array::uniform3(-30.0..30.0f64),
            patch_mm in 0.0..30.0f64,
        ) {
            let one = ClearanceTree::new(fixtures::block(20.0, 10.0, 6.0));
            let two = ClearanceTree::new(fixtures::star(2, |way| 7.0 + 2.0 * way.x * way.y));
            let pose12 = Pose::new(DQuat::from_scaled_axis(DVec3::from_array(turn)), DVec3::from_array(shift));
            let exact = one.distance_capped_mm(&two, &pose12, 8.0);
            let mut found = Vec::new();
            one.visit_contacts(&two, &pose12, (patch_mm, 8.0), &mut |contact| found.push(contact));
            prop_assert_eq!(found.is_empty(), exact == 0.0 || exact >= 8.0);
            for contact in &found {
                let off = contact.point1.max(DVec3::new(20.0, 10.0, 6.0)) - contact.point1 - contact.point1.min(DVec3::ZERO);
                prop_assert!(off.min_element() >= -1e-9, "{contact:?} leaves the first part");
                prop_assert!(pose12.inverse().transform_point(contact.point2).length() < 8.1, "{contact:?} leaves the second part");
                prop_assert!(contact.distance_mm() < 8.0 && contact.distance_mm() >= exact - 1e-9);
            }
            let least = found.iter().map(SurfaceContact::distance_mm).fold(8.0, f64::min);
            prop_assert!(exact == 0.0 || (least - exact).abs() < 1e-9, "contact {least} exact {exact}");
        }
    }
}
