//! The distance between two triangles, exact up to rounding, also if they cross, touch, lie in one plane or have no
//! area.

use glam::{DMat3, DVec3};

/// A triangle whose height is below this share of its longest edge has no reliable normal; only its edges are used.
const SLIVER: f64 = 1e-7;

/// Least and greatest corner of the box around a triangle.
pub(crate) type CornerSpan = (DVec3, DVec3);

/// A triangle with its unit normal, which is zero for a sliver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    /// Corners, mm, counter-clockwise seen from outside.
    pub corners: [DVec3; 3],
    /// Unit normal, or zero for a sliver.
    pub normal: DVec3,
}

impl Triangle {
    /// A triangle from its corners.
    pub fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let longest_sq = ab.length_squared().max(bc.length_squared()).max(ca.length_squared());
        // The two shortest edges lose the least precision.
        let cross = if bc.length_squared() >= longest_sq {
            ab.cross(-ca)
        } else if ca.length_squared() >= longest_sq {
            bc.cross(-ab)
        } else {
            ca.cross(-bc)
        };
        let length = cross.length();
        let normal = if length > SLIVER * longest_sq { cross * length.recip() } else { DVec3::ZERO };
        Self { corners, normal }
    }

    /// The triangle seen from another frame.
    pub fn transformed_by(&self, rotation: &DMat3, translation: DVec3) -> Self {
        Self { corners: self.corners.map(|c| *rotation * c + translation), normal: *rotation * self.normal }
    }

    /// Whether the normal is reliable.
    fn has_normal(&self) -> bool {
        self.normal != DVec3::ZERO
    }

    /// Signed heights of points over this plane, mm; all zero for a sliver, which has no plane.
    fn heights(&self, points: &[DVec3; 3]) -> [f64; 3] {
        points.map(|p| (p - self.corners[0]).dot(self.normal))
    }

    /// Whether the projection of `point` on the plane lies in the triangle, borders included.
    pub fn covers_point(&self, point: DVec3) -> bool {
        let [a, b, c] = self.corners;
        let left = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(self.normal) >= 0.0;
        left(a, b) && left(b, c) && left(c, a)
    }

    /// Least and greatest corner of the triangle's box.
    pub fn corner_span(&self) -> CornerSpan {
        let [a, b, c] = self.corners;
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// The squared distance to `other`, mm2, or `cap_sq` when it is not less.
    pub fn distance_sq_below(&self, other: &Self, cap_sq: f64) -> f64 {
        let (span1, span2) = (self.corner_span(), other.corner_span());
        if (span2.0 - span1.1).max(span1.0 - span2.1).max(DVec3::ZERO).length_squared() >= cap_sq {
            return cap_sq;
        }
        self.near_distance_sq(other, cap_sq, (span1, span2))
    }

    /// The same for triangles whose spans, as [`Triangle::corner_span`] gives them, are nearer than the cap.
    pub fn near_distance_sq(&self, other: &Self, cap_sq: f64, (span1, span2): (CornerSpan, CornerSpan)) -> f64 {
        let cap = cap_sq.sqrt();
        let heights2 = self.heights(&other.corners);
        let heights1 = other.heights(&self.corners);
        if one_sided_height(&heights2) >= cap || one_sided_height(&heights1) >= cap {
            return cap_sq;
        }
        if one_sided_height(&heights1) <= 0.0
            && one_sided_height(&heights2) <= 0.0
            && (self.is_pierced(&other.corners, &heights2) || other.is_pierced(&self.corners, &heights1))
        {
            return 0.0;
        }
        let best_sq = self.corners_to_face_sq(&other.corners, &heights2, cap_sq);
        let best_sq = other.corners_to_face_sq(&self.corners, &heights1, best_sq);
        let near1 = near_edges(&self.corners, &heights1, span2, best_sq);
        let near2 = near_edges(&other.corners, &heights2, span1, best_sq);
        edges_distance_sq(&self.corners, near1, &other.corners, near2, best_sq)
    }

    /// Whether an edge of the triangle `corners` passes through this face.
    fn is_pierced(&self, corners: &[DVec3; 3], heights: &[f64; 3]) -> bool {
        self.has_normal()
            && EDGES.iter().any(|&(i, j)| {
                let (from, to) = (heights[i], heights[j]);
                from * to <= 0.0 && from != to && self.covers_point(corners[i].lerp(corners[j], from / (from - to)))
            })
    }

    /// The least squared distance of `corners` to the inside of this face, where it is below `best_sq`.
    fn corners_to_face_sq(&self, corners: &[DVec3; 3], heights: &[f64; 3], mut best_sq: f64) -> f64 {
        if self.has_normal() {
            for (corner, height) in corners.iter().zip(heights) {
                let height_sq = height * height;
                if height_sq < best_sq && self.covers_point(*corner) {
                    best_sq = height_sq;
                }
            }
        }
        best_sq
    }
}

/// Corner numbers of the three edges.
const EDGES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// Distance of all three heights from a plane if they are on one side of it; 0 or less when they are on both sides.
fn one_sided_height(heights: &[f64; 3]) -> f64 {
    let [a, b, c] = *heights;
    a.min(b).min(c).max(-a.max(b).max(c))
}

/// The edges of a triangle that can come nearer than `cap_sq` to the other one, by the heights of its corners over the
/// other's plane and by the box around the other.
fn near_edges(corners: &[DVec3; 3], heights: &[f64; 3], (min, max): (DVec3, DVec3), cap_sq: f64) -> [bool; 3] {
    EDGES.map(|(i, j)| {
        let height = heights[i].min(heights[j]).max(-heights[i].max(heights[j]));
        if height > 0.0 && height * height >= cap_sq {
            return false;
        }
        let (low, high) = (corners[i].min(corners[j]), corners[i].max(corners[j]));
        (min - high).max(low - max).max(DVec3::ZERO).length_squared() < cap_sq
    })
}

/// The least squared distance between those edges of two triangles that are near, where it is below `best_sq`.
fn edges_distance_sq(
    corners1: &[DVec3; 3],
    near1: [bool; 3],
    corners2: &[DVec3; 3],
    near2: [bool; 3],
    mut best_sq: f64,
) -> f64 {
    for (&(i, j), _) in EDGES.iter().zip(near1).filter(|e| e.1) {
        for (&(k, l), _) in EDGES.iter().zip(near2).filter(|e| e.1) {
            best_sq = segments_distance_sq(corners1[i], corners1[j], corners2[k], corners2[l]).min(best_sq);
        }
    }
    best_sq
}

/// The squared distance between the segments `from1 to1` and `from2 to2`, mm2 (Ericson, Real-Time Collision Detection,
/// 5.1.9). The result is always the distance of two points on the segments.
fn segments_distance_sq(from1: DVec3, to1: DVec3, from2: DVec3, to2: DVec3) -> f64 {
    let (d1, d2, r) = (to1 - from1, to2 - from2, from1 - from2);
    let (a, e) = (d1.length_squared(), d2.length_squared());
    if a <= 0.0 || e <= 0.0 {
        return if a > 0.0 {
            point_segment_distance_sq(from2, from1, d1, a)
        } else {
            point_segment_distance_sq(from1, from2, d2, e)
        };
    }
    let (b, c, f) = (d1.dot(d2), d1.dot(r), d2.dot(r));
    let spread = a * e - b * b;
    let mut s = if spread > 0.0 { ((b * f - c * e) / spread).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (b * s + f) / e;
    if t < 0.0 {
        t = 0.0;
        s = (-c / a).clamp(0.0, 1.0);
    } else if t > 1.0 {
        t = 1.0;
        s = ((b - c) / a).clamp(0.0, 1.0);
    }
    let apart_sq = (r + d1 * s - d2 * t).length_squared();
    // Below this the two directions are so nearly parallel that `s` is noise: the segment ends decide.
    if spread > 1e-12 * a * e {
        return apart_sq;
    }
    apart_sq
        .min(point_segment_distance_sq(from1, from2, d2, e))
        .min(point_segment_distance_sq(to1, from2, d2, e))
        .min(point_segment_distance_sq(from2, from1, d1, a))
        .min(point_segment_distance_sq(to2, from1, d1, a))
}

/// The squared distance of a point to the segment from `from` along `d`, whose squared length is `d_sq`.
pub(crate) fn point_segment_distance_sq(point: DVec3, from: DVec3, d: DVec3, d_sq: f64) -> f64 {
    let r = point - from;
    let share = if d_sq > 0.0 { (r.dot(d) / d_sq).clamp(0.0, 1.0) } else { 0.0 };
    (r - d * share).length_squared()
}

/// The point of a triangle that is closest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub fn closest_point(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let total = va + vb + vc;
    if total <= 0.0 { a } else { a + ab * (vb / total) + ac * (vc / total) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        Triangle::new(corners.map(DVec3::from_array))
    }

    fn distance(one: &Triangle, two: &Triangle) -> f64 {
        one.distance_sq_below(two, f64::INFINITY).sqrt()
    }

    /// Distance by dense sampling of both triangles: never less than the truth, near it for a fine grid.
    fn sampled(one: &Triangle, two: &Triangle, steps: usize) -> f64 {
        let points = |t: &Triangle| -> Vec<DVec3> {
            let [a, b, c] = t.corners;
            (0..=steps)
                .flat_map(|i| (0..=steps - i).map(move |j| (i as f64 / steps as f64, j as f64 / steps as f64)))
                .map(|(u, v)| a + (b - a) * u + (c - a) * v)
                .collect()
        };
        let (points1, points2) = (points(one), points(two));
        let pairs = points1.iter().flat_map(|p| points2.iter().map(move |q| p.distance_squared(*q)));
        pairs.fold(f64::INFINITY, f64::min).sqrt()
    }

    const FLAT: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    #[test]
    fn known_places_have_known_distances() {
        let flat = triangle(FLAT);
        let over = triangle([[0.5, 0.5, 3.0], [1.5, 0.5, 3.0], [0.5, 1.5, 3.0]]);
        assert_eq!(distance(&flat, &over), 3.0, "face over face");
        let tip = triangle([[1.0, 1.0, 2.0], [1.0, 1.0, 9.0], [2.0, 1.0, 9.0]]);
        assert_eq!(distance(&flat, &tip), 2.0, "corner over face");
        let through = triangle([[1.0, 1.0, -2.0], [1.0, 1.0, 9.0], [2.0, 1.0, 9.0]]);
        assert_eq!(distance(&flat, &through), 0.0, "edge through face");
        let next_to = triangle([[7.0, 0.0, 0.0], [8.0, 0.0, 0.0], [7.0, 1.0, 0.0]]);
        assert_eq!(distance(&flat, &next_to), 3.0, "in one plane");
        let within = triangle([[0.5, 0.5, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0]]);
        assert_eq!(distance(&flat, &within), 0.0, "in one plane, one inside the other");
        assert_eq!(distance(&flat, &flat), 0.0, "itself");
    }

    #[test]
    fn a_sliver_counts_by_its_edges() {
        let line = triangle([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [3.0, 0.0, 1.0]]);
        assert_eq!(line.normal, DVec3::ZERO);
        assert_eq!(distance(&line, &triangle([[1.0, -1.0, -4.0], [1.0, 1.0, -4.0], [1.0, 0.0, 0.5]])), 0.5);
        let flat = triangle(FLAT);
        assert_eq!(distance(&line, &flat), 1.0);
        let upright = triangle([[1.0, 1.0, -1.0], [1.0, 1.0, 2.0], [1.0, 1.0, 1.0]]);
        assert_eq!(distance(&upright, &flat), 0.0, "a sliver through a face");
    }

    #[test]
    fn a_cap_is_returned_when_it_is_nearer() {
        let over = triangle([[0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [0.0, 4.0, 3.0]]);
        assert_eq!(triangle(FLAT).distance_sq_below(&over, 4.0), 4.0);
        assert_eq!(triangle(FLAT).distance_sq_below(&over, 9.5), 9.0);
    }

    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![-5.0..5.0, (-3i32..=3).prop_map(f64::from), (0i32..3).prop_map(|k| f64::from(k) * 1e-9)]
    }

    proptest! {
        #[test]
        fn the_distance_is_what_sampling_approaches(c in proptest::array::uniform18(coordinate())) {
            let corner = |i: usize| [c[3 * i], c[3 * i + 1], c[3 * i + 2]];
            let one = triangle([corner(0), corner(1), corner(2)]);
            let two = triangle([corner(3), corner(4), corner(5)]);
            let exact = distance(&one, &two);
            let near = sampled(&one, &two, 16);
            prop_assert!(exact <= near + 1e-6, "exact {exact} sampled {near}");
            // No point of a grid cell is further from a grid point than the cell's edges.
            let cell = |t: &Triangle| (t.corners[1] - t.corners[0]).length() + (t.corners[2] - t.corners[0]).length();
            let reach = (cell(&one) + cell(&two)) / 16.0;
            prop_assert!(exact >= near - reach, "exact {exact} sampled {near} reach {reach}");
            prop_assert!((distance(&two, &one) - exact).abs() < 1e-9);
        }
    }
}
