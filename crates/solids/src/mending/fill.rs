//! Closes a hole with triangles between the corners of its rim: the triangulation of least bending. By dynamic programming over the rim
//! (G. Barequet, M. Sharir: Filling gaps in the boundary of a polyhedron, CAGD 12, 1995), with the angles to the surface around as weight
//! (P. Liepa: Filling holes in meshes, SGP 2003): a hole across an edge of the part is closed with that edge.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::mesh::triangle::point_segment_distance_sq;

/// Less is flat, radians.
pub(super) const FLAT: f64 = 0.02;
/// What area counts beside bending: it decides where nothing bends.
const AREA_WEIGHT: f64 = 0.01;

/// What closes a hole.
#[derive(Debug)]
pub(super) struct Filling {
    /// Triangles, as places in the rim.
    pub(super) triangles: Vec<[usize; 3]>,
    /// Their area, mm2.
    pub(super) area_mm2: f64,
    /// For each edge of the rim the angle by which the surface bends there, radians.
    pub(super) bends: Vec<f64>,
    /// Whether they lie in one plane.
    pub(super) is_flat: bool,
    /// The largest distance of a point of them from the rim, mm.
    pub(super) deviation_mm: f64,
}

/// Closes a rim. `normals`: of the triangle beside each edge. `is_taken`: between these two places there is an edge already. `None` = there is no
/// way without a taken edge.
pub(super) fn fill_rim(rim: &[DVec3], normals: &[DVec3], is_taken: impl Fn(usize, usize) -> bool) -> Option<Filling> {
    let count = rim.len();
    let scale = AREA_WEIGHT / edge_lengths(rim).iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut weights = vec![0.0; count * count];
    let mut splits = vec![usize::MAX; count * count];
    // The normal of what lies beyond an edge: the surface, or the triangle that was chosen for that part of the rim.
    let beyond = |splits: &[usize], from: usize, to: usize| match to - from {
        1 => normals[from],
        _ => normal([rim[from], rim[splits[from * count + to]], rim[to]]),
    };
    for width in 2..count {
        for from in 0..count - width {
            let to = from + width;
            let is_last = width == count - 1;
            let (mut best, mut split) = (f64::INFINITY, usize::MAX);
            if is_last || !is_taken(from, to) {
                for middle in from + 1..to {
                    let so_far = weights[from * count + middle] + weights[middle * count + to];
                    if so_far >= best {
                        continue;
                    }
                    let corners = [rim[from], rim[middle], rim[to]];
                    let own = normal(corners);
                    let mut weight = so_far + scale * area(corners);
                    weight += corners[0].distance(corners[1]) * bend(own, beyond(&splits, from, middle));
                    weight += corners[1].distance(corners[2]) * bend(own, beyond(&splits, middle, to));
                    if is_last {
                        weight += corners[2].distance(corners[0]) * bend(own, normals[count - 1]);
                    }
                    if weight < best {
                        (best, split) = (weight, middle);
                    }
                }
            }
            (weights[from * count + to], splits[from * count + to]) = (best, split);
        }
    }
    weights[count - 1].is_finite().then(|| collect(rim, normals, &splits))
}

fn collect(rim: &[DVec3], normals: &[DVec3], splits: &[usize]) -> Filling {
    let count = rim.len();
    let mut filling = Filling {
        triangles: Vec::new(),
        area_mm2: 0.0,
        bends: vec![FRAC_PI_2; count],
        is_flat: true,
        deviation_mm: 0.0,
    };
    let mut plane = DVec3::ZERO;
    let mut left = vec![(0, count - 1)];
    while let Some((from, to)) = left.pop() {
        if to - from < 2 {
            continue;
        }
        let middle = splits[from * count + to];
        left.extend([(from, middle), (middle, to)]);
        filling.triangles.push([from, middle, to]);
        let corners = [rim[from], rim[middle], rim[to]];
        filling.area_mm2 += area(corners);
        let own = normal(corners);
        plane = if plane == DVec3::ZERO { own } else { plane };
        filling.is_flat &= own == DVec3::ZERO || bend(own, plane) <= FLAT;
        for (one, other) in [(from, middle), (middle, to), (to, from)] {
            if other == (one + 1) % count {
                filling.bends[one] = bend(own, normals[one]);
            }
        }
        let [a, b, c] = corners;
        for point in [(a + b + c) / 3.0, a.midpoint(b), b.midpoint(c), c.midpoint(a)] {
            filling.deviation_mm = filling.deviation_mm.max(distance_to_rim(point, rim));
        }
    }
    filling
}

/// Lengths of the edges of a rim, mm.
pub(super) fn edge_lengths(rim: &[DVec3]) -> Vec<f64> {
    (0..rim.len()).map(|at| rim[at].distance(rim[(at + 1) % rim.len()])).collect()
}

/// The unit normal of a triangle, or zero if it has no area.
pub(super) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let cross = ab.cross(ac);
    let longest2 = ab.length_squared().max(ac.length_squared()).max(b.distance_squared(c));
    if cross.length() > 1e-9 * longest2 { cross.normalize_or_zero() } else { DVec3::ZERO }
}

/// Area of a triangle, mm2.
pub(super) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// The angle between two normals; a right one where there is none.
fn bend(one: DVec3, other: DVec3) -> f64 {
    if one == DVec3::ZERO || other == DVec3::ZERO { FRAC_PI_2 } else { one.dot(other).clamp(-1.0, 1.0).acos() }
}

fn distance_to_rim(point: DVec3, rim: &[DVec3]) -> f64 {
    let to_edge = |at: usize| {
        let (from, along) = (rim[at], rim[(at + 1) % rim.len()] - rim[at]);
        point_segment_distance_sq(point, from, along, along.length_squared())
    };
    (0..rim.len()).map(to_edge).fold(f64::INFINITY, f64::min).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_hole_is_closed_flat_and_one_across_an_edge_with_that_edge() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let flat = fill_rim(&square, &[DVec3::Z; 4], |_, _| false).expect("can be closed");
        assert_eq!((flat.triangles.len(), flat.area_mm2), (2, 1.0));
        assert!(flat.bends.iter().all(|&bend| bend < 1e-6) && flat.deviation_mm <= 0.5);
        assert!(fill_rim(&square, &[DVec3::Z; 4], |_, _| true).is_none(), "both diagonals are edges of others");
        // Two triangles on both sides of an edge along x: one lies in z = 0, one in y = 0.
        let across = [DVec3::ZERO, DVec3::new(0.5, 0.0, -0.4), DVec3::X, DVec3::new(0.5, 0.4, 0.0)];
        let folded =
            fill_rim(&across, &[-DVec3::Y, -DVec3::Y, DVec3::Z, DVec3::Z], |_, _| false).expect("can be closed");
        assert!(folded.triangles.iter().all(|corners| corners.contains(&0) && corners.contains(&2)), "{folded:?}");
        assert!(folded.bends.iter().all(|&bend| bend < 1e-6));
    }
}
