//! Triangulates an outline: holes are joined to the outer loop by bridges, then ears are clipped.

use std::cmp::Ordering;

use glam::DVec2;

use super::outline::{PlanarOutline, loop_edges};

/// Fills an outline with counter-clockwise triangles that use its corners only.
pub(super) fn triangulate_outline(outline: &PlanarOutline) -> Vec<[DVec2; 3]> {
    clip_ears(join_holes(outline))
}

/// Twice the signed area of a triangle.
fn double_signed_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Joins all holes to the outer loop by bridges, there and back.
fn join_holes(outline: &PlanarOutline) -> Vec<DVec2> {
    let rightmost = |hole: &[DVec2]| hole.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    let mut holes: Vec<&[DVec2]> = outline.holes.iter().map(Vec::as_slice).collect();
    holes.sort_by(|a, b| rightmost(b).total_cmp(&rightmost(a)));
    let mut joined = outline.outer.clone();
    for (at, hole) in holes.iter().enumerate() {
        let from = (0..hole.len()).max_by(|&a, &b| hole[a].x.total_cmp(&hole[b].x)).expect("a hole has corners");
        let to = find_bridge(&joined, &holes[at..], hole[from]);
        let back = joined[to];
        let detour = (0..=hole.len()).map(|i| hole[(from + i) % hole.len()]).chain([back]);
        let tail = joined.split_off(to + 1);
        joined.extend(detour);
        joined.extend(tail);
    }
    joined
}

/// Index of the nearest corner of `joined` from which `from` is visible past all edges.
fn find_bridge(joined: &[DVec2], holes: &[&[DVec2]], from: DVec2) -> usize {
    let mut nearest: Vec<usize> = (0..joined.len()).collect();
    nearest.sort_by(|&a, &b| joined[a].distance_squared(from).total_cmp(&joined[b].distance_squared(from)));
    let sees = |&i: &usize| {
        let n = joined.len();
        in_corner(joined[(i + n - 1) % n], joined[i], joined[(i + 1) % n], from)
            && loop_edges(joined)
                .chain(holes.iter().flat_map(|hole| loop_edges(hole)))
                .all(|(a, b)| !edge_blocks(a, b, from, joined[i]))
    };
    nearest.into_iter().find(sees).expect("a hole inside an outline sees one of its corners")
}

/// Whether `point` lies in the interior angle of the corner `before, at, after`.
fn in_corner(before: DVec2, at: DVec2, after: DVec2, point: DVec2) -> bool {
    let (left_of_in, left_of_out) =
        (double_signed_area(before, at, point) > 0.0, double_signed_area(at, after, point) > 0.0);
    if double_signed_area(before, at, after) > 0.0 { left_of_in && left_of_out } else { left_of_in || left_of_out }
}

/// Whether the edge `a b` touches the open segment `p q`; edges that start at `p` or `q` do not block.
fn edge_blocks(a: DVec2, b: DVec2, p: DVec2, q: DVec2) -> bool {
    if [a, b].iter().any(|&end| end == p || end == q) {
        return false;
    }
    double_signed_area(a, b, p) * double_signed_area(a, b, q) <= 0.0
        && double_signed_area(p, q, a) * double_signed_area(p, q, b) <= 0.0
}

/// Clips the ear with the shortest diagonal until a triangle is left.
fn clip_ears(mut points: Vec<DVec2>) -> Vec<[DVec2; 3]> {
    let mut triangles = Vec::with_capacity(points.len());
    let corner = |points: &[DVec2], i: usize| {
        let n = points.len();
        [points[(i + n - 1) % n], points[i], points[(i + 1) % n]]
    };
    let mut scores: Vec<f64> = (0..points.len()).map(|i| ear_score(&points, corner(&points, i))).collect();
    while points.len() > 3 {
        let best = (0..points.len()).min_by(|&a, &b| scores[a].total_cmp(&scores[b])).unwrap_or(0);
        debug_assert!(scores[best].is_finite(), "an outline always has an ear");
        triangles.push(corner(&points, best));
        points.remove(best);
        scores.remove(best);
        let n = points.len();
        for near in [(best + n - 1) % n, best % n] {
            scores[near] = ear_score(&points, corner(&points, near));
        }
    }
    triangles.push([points[0], points[1], points[2]]);
    triangles
}

/// Squared length of the diagonal that clips an ear, infinite where there is none.
fn ear_score(points: &[DVec2], [a, b, c]: [DVec2; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c));
    if double_signed_area(a, b, c).partial_cmp(&(1e-9 * longest)) != Some(Ordering::Greater) {
        return f64::INFINITY;
    }
    let inside = |&p: &DVec2| {
        p != a
            && p != b
            && p != c
            && double_signed_area(a, b, p) >= 0.0
            && double_signed_area(b, c, p) >= 0.0
            && double_signed_area(c, a, p) >= 0.0
    };
    if points.iter().any(inside) { f64::INFINITY } else { a.distance_squared(c) }
}

#[cfg(test)]
mod tests {
    use super::super::outline::{circle, rectangle};
    use super::*;

    #[test]
    fn the_triangles_of_a_plate_with_many_holes_fill_its_area() {
        let mut plate = PlanarOutline::new(rectangle(DVec2::ZERO, DVec2::splat(100.0)));
        for i in 0..9 {
            for j in 0..9 {
                plate =
                    plate.with_hole(circle(DVec2::new(10.0 + 10.0 * i as f64, 10.0 + 10.0 * j as f64), 4.0, 6, 0.0));
            }
        }
        let triangles = triangulate_outline(&plate);
        let area: f64 = triangles.iter().map(|&[a, b, c]| double_signed_area(a, b, c) / 2.0).sum();
        assert!((area - plate.area()).abs() < 1e-6 * area, "{area} of {}", plate.area());
        assert!(triangles.iter().all(|&[a, b, c]| double_signed_area(a, b, c) > 0.0));
        // Euler: corners + 2 x holes - 2 triangles.
        assert_eq!(triangles.len(), 4 + 81 * 6 + 2 * 81 - 2);
    }
}
