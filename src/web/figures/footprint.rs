//! The area of the floor that a placed part covers, for the plans of the pick map.

use glam::{DVec2, DVec3};

/// How far a corner that is left out may lie from the line in its place, as a share of the extent.
const LEFT_OUT_SHARE: f64 = 0.02;
/// The same at least and at most, mm.
const LEFT_OUT_MM: (f64, f64) = (0.1, 0.4);

/// The convex hull of points seen from above, counter-clockwise, mm, without corners that nobody sees.
pub(super) fn convex_footprint(points: impl Iterator<Item = DVec3>) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = points.map(|p| p.truncate()).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull = lower_hull(points.iter().copied());
    hull.extend(lower_hull(points.into_iter().rev()));
    hull.dedup();
    let (low, high) = hull.iter().fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
    thinned(&hull, (LEFT_OUT_SHARE * (high - low).max_element()).clamp(LEFT_OUT_MM.0, LEFT_OUT_MM.1))
}

/// The corners of a convex hull without those that lie at most so far from the line between their kept neighbours, mm.
fn thinned(hull: &[DVec2], left_out_mm: f64) -> Vec<DVec2> {
    let mut kept: Vec<DVec2> = Vec::new();
    let mut skipped = 0;
    for (at, corner) in hull.iter().enumerate() {
        // From the corner that was kept last to the next: may this one, and those before it, be left out?
        let next = hull[(at + 1) % hull.len()];
        let is_flat = kept.last().is_some_and(|&from| {
            from != next && {
                let line = (next - from).normalize_or_zero();
                hull[at - skipped..=at].iter().all(|p| line.perp_dot(*p - from).abs() <= left_out_mm)
            }
        });
        if is_flat && hull.len() > 3 {
            skipped += 1;
        } else {
            kept.push(*corner);
            skipped = 0;
        }
    }
    kept
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
        let base = convex_footprint(block.vertices().iter().copied());
        assert_eq!(base.len(), 4);
        assert!((area(&base) - 600.0).abs() < 1e-9);
        for sample in sample_parts::all_samples() {
            let pose = Pose::new(glam::DQuat::from_rotation_x(0.7), DVec3::new(40.0, -3.0, 9.0));
            let placed: Vec<DVec3> = sample.mesh.vertices().iter().map(|&v| pose.transform_point(v)).collect();
            let hull = convex_footprint(placed.iter().copied());
            assert!(hull.len() >= 3 && area(&hull) > 1.0, "{}", sample.name);
            for (a, b) in hull.iter().zip(hull.iter().cycle().skip(1)) {
                let outside =
                    |p: &&DVec3| (*b - *a).perp_dot(p.truncate() - *a) < -(LEFT_OUT_MM.1 + 1e-6) * a.distance(*b);
                assert_eq!(placed.iter().filter(outside).count(), 0, "{}", sample.name);
            }
        }
    }

    #[test]
    fn no_point_and_one_point_have_a_footprint_too() {
        assert!(convex_footprint(std::iter::empty()).is_empty());
        assert_eq!(convex_footprint(std::iter::once(DVec3::ONE)), [DVec2::ONE]);
    }
}
