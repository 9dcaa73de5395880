//! The area of the floor that a placed part covers, for the plans of the pick map.

use glam::{DVec2, DVec3};

/// The convex hull of points seen from above, counter-clockwise, mm. Corners closer than `coarse_mm` are left out.
pub(super) fn convex_footprint(points: impl Iterator<Item = DVec3>, coarse_mm: f64) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = points.map(|p| p.truncate()).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull = lower_hull(points.iter().copied());
    hull.extend(lower_hull(points.into_iter().rev()));
    let mut thinned: Vec<DVec2> = Vec::with_capacity(hull.len());
    for corner in hull {
        if thinned.last().is_none_or(|last| last.distance(corner) >= coarse_mm) {
            thinned.push(corner);
        }
    }
    thinned
}

/// The lower half of a hull, for points from left to right, without its last corner: the other half begins with it.
fn lower_hull(points: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut side: Vec<DVec2> = Vec::new();
    for point in points {
        while let [.., a, b] = side[..]
            && (b - a).perp_dot(point - a) <= 0.0
        {
            side.pop();
        }
        side.push(point);
    }
    if side.len() > 1 {
        side.pop();
    }
    side
}

#[cfg(test)]
mod tests {
    use solids::Pose;

    use super::*;

    fn area(hull: &[DVec2]) -> f64 {
        let next = hull.iter().cycle().skip(1);
        0.5 * hull.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
    }

    #[test]
    fn the_footprint_of_a_block_is_its_base_and_all_points_lie_in_that_of_any_part() {
        let block = sample_parts::cuboid(DVec3::new(30.0, 20.0, 5.0));
        let base = convex_footprint(block.vertices().iter().copied(), 0.0);
        assert_eq!(base.len(), 4);
        assert!((area(&base) - 600.0).abs() < 1e-9);
        for sample in sample_parts::all_samples() {
            let pose = Pose::new(glam::DQuat::from_rotation_x(0.7), DVec3::new(40.0, -3.0, 9.0));
            let placed: Vec<DVec3> = sample.mesh.vertices().iter().map(|&v| pose.transform_point(v)).collect();
            let hull = convex_footprint(placed.iter().copied(), 0.0);
            assert!(hull.len() >= 3 && area(&hull) > 1.0, "{}", sample.name);
            for (a, b) in hull.iter().zip(hull.iter().cycle().skip(1)) {
                let outside = placed.iter().filter(|p| (*b - *a).perp_dot(p.truncate() - *a) < -1e-6).count();
                assert_eq!(outside, 0, "{}", sample.name);
            }
            let coarse = convex_footprint(placed.iter().copied(), 3.0);
            assert!(coarse.len() <= hull.len() && area(&coarse) > 0.7 * area(&hull), "{}", sample.name);
        }
    }

    #[test]
    fn no_point_and_one_point_have_a_footprint_too() {
        assert!(convex_footprint(std::iter::empty(), 1.0).is_empty());
        assert_eq!(convex_footprint(std::iter::once(DVec3::ONE), 1.0), [DVec2::ONE]);
    }
}
