//! Four triangles at a time in single precision, to tell which of them may come near another one before any exact distance
//! is worked out.

use glam::{BVec4A, DVec3, Mat3A, Mat4, Vec3A, Vec4};

use super::box_tree_build::MAX_LEAF_TRIANGLES;
use crate::{Pose, mesh::triangle::Triangle};

/// Triangles or points that are compared at a time.
pub(super) const LANES: usize = 4;
const _: () = assert!(MAX_LEAF_TRIANGLES <= LANES);
/// Coordinates of a triangle.
const COORDINATES: usize = 9;
/// Directions in which two triangles are tried; more rule out few pairs more.
const DIRECTIONS: usize = 3;
/// A direction whose squared length is less, mm2, is the rounding of equal points.
const MIN_DIRECTION_SQ: f32 = 1e-12;

/// The triangles of a tree in the order of its leaves, rounded to single precision in the frame of its boxes: the coordinates
/// of one after the other, 36 bytes a triangle, so that a leaf takes few lines of memory.
#[derive(Debug, Clone)]
pub(crate) struct TriangleLaneStore {
    triangles: Vec<[f32; COORDINATES]>,
}

impl TriangleLaneStore {
    /// Stores triangles, which `to_box` takes from the mesh's frame to the frame of the boxes.
    pub fn new(triangles: &[Triangle], to_box: &Pose) -> Self {
        let (rotation, shift) = (to_box.rotation_matrix(), to_box.translation);
        let rounded = |triangle: &Triangle| {
            let corners = triangle.corners.map(|c| (rotation * c + shift).as_vec3().to_array());
            std::array::from_fn(|k| corners.as_flattened()[k])
        };
        // So that four can be read from the last one on.
        let spare = [[0.0; COORDINATES]; LANES - 1];
        Self { triangles: triangles.iter().map(rounded).chain(spare).collect() }
    }

    /// Four triangles from a place on.
    #[inline]
    pub fn lanes_from(&self, first: usize) -> TriangleLanes {
        let four: &[[f32; COORDINATES]] = &self.triangles[first..first + LANES];
        let columns = |k: usize| {
            let rows = [0, 1, 2, 3].map(|lane| Vec4::from_slice(&four[lane][k..]));
            let turned = Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
            [turned.x_axis, turned.y_axis, turned.z_axis, turned.w_axis]
        };
        let [[x1, y1, z1, x2], [y2, z2, x3, y3]] = [columns(0), columns(4)];
        let z3 = Vec4::from_array([0, 1, 2, 3].map(|lane: usize| four[lane][COORDINATES - 1]));
        let corners = [(x1, y1, z1), (x2, y2, z2), (x3, y3, z3)].map(|(x, y, z)| LanePoints { x, y, z });
        TriangleLanes { corners }
    }
}

/// Four points side by side, as one of each of four triangles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LanePoints {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl LanePoints {
    /// Of one to four points; the last one is repeated.
    pub fn of_points(points: &[Vec3A]) -> Self {
        let lane = |axis: usize| Vec4::from_array(std::array::from_fn(|lane| points[lane.min(points.len() - 1)][axis]));
        Self { x: lane(0), y: lane(1), z: lane(2) }
    }

    #[inline]
    fn map_two(self, other: Self, each: impl Fn(Vec4, Vec4) -> Vec4) -> Self {
        Self { x: each(self.x, other.x), y: each(self.y, other.y), z: each(self.z, other.z) }
    }

    #[inline]
    fn select(mask: BVec4A, if_true: Self, if_false: Self) -> Self {
        if_true.map_two(if_false, |one, other| Vec4::select(mask, one, other))
    }

    #[inline]
    pub fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The point of one lane in all lanes.
    #[inline]
    fn splat_lane(&self, lane: usize) -> Self {
        Self { x: Vec4::splat(self.x[lane]), y: Vec4::splat(self.y[lane]), z: Vec4::splat(self.z[lane]) }
    }
}

/// Four triangles.
#[derive(Clone, Copy)]
pub(crate) struct TriangleLanes {
    corners: [LanePoints; 3],
}

impl TriangleLanes {
    /// The triangles with these corners; at most four.
    pub fn of_corners(all: impl Iterator<Item = [DVec3; 3]>) -> Self {
        let mut values = [[0.0; LANES]; COORDINATES];
        for (lane, corners) in all.enumerate() {
            for (k, value) in corners.map(|c| c.to_array()).as_flattened().iter().enumerate() {
                values[k][lane] = *value as f32;
            }
        }
        let at = |k: usize| Vec4::from_array(values[k]);
        Self { corners: [0, 3, 6].map(|k| LanePoints { x: at(k), y: at(k + 1), z: at(k + 2) }) }
    }

    /// The triangles seen from another frame.
    #[inline]
    pub fn seen_by(&self, rotation: &Mat3A, translation: Vec3A) -> Self {
        let [a, b, c] = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|axis| axis.to_array());
        let t = translation.to_array();
        let along = |p: &LanePoints, k: usize| p.x * a[k] + p.y * b[k] + p.z * c[k] + Vec4::splat(t[k]);
        Self { corners: self.corners.map(|p| LanePoints { x: along(&p, 0), y: along(&p, 1), z: along(&p, 2) }) }
    }

    /// The triangles with the boxes around them.
    #[inline]
    pub fn with_spans(self) -> SpannedLanes {
        let [a, b, c] = self.corners;
        let low = a.map_two(b, Vec4::min).map_two(c, Vec4::min);
        let high = a.map_two(b, Vec4::max).map_two(c, Vec4::max);
        let third = Vec4::splat(1.0 / 3.0);
        let sum = a.map_two(b, |p, q| p + q).map_two(c, |p, q| p + q);
        let middle = LanePoints { x: sum.x * third, y: sum.y * third, z: sum.z * third };
        SpannedLanes { corners: self.corners, low, high, middle }
    }
}

/// Four triangles with their boxes and middles.
pub(crate) struct SpannedLanes {
    corners: [LanePoints; 3],
    low: LanePoints,
    high: LanePoints,
    middle: LanePoints,
}

impl SpannedLanes {
    /// Which of these triangles may be at most `reach` from triangle `lane` of `others`, mm: a bit for each. The others are
    /// certainly farther, but for the rounding of the coordinates and of three products' sum, which `reach` must contain.
    #[inline]
    pub fn lanes_within(&self, others: &Self, lane: usize, reach: f32) -> u32 {
        let reach_sq = Vec4::splat(reach * reach);
        let (low, high) = (others.low.splat_lane(lane), others.high.splat_lane(lane));
        let before = low.map_two(self.high, |other, own| other - own);
        let behind = self.low.map_two(high, |own, other| own - other);
        let gaps = before.map_two(behind, |p, q| p.max(q).max(Vec4::ZERO));
        // What is no number, from coordinates beyond single precision, rules nothing out.
        let near = !gaps.dot(gaps).cmpgt(reach_sq).bitmask() & 0b1111;
        if near == 0 { 0 } else { near & !self.lanes_apart(others, lane, reach_sq, near) }
    }

    /// Those of these triangles that a plane keeps farther from triangle `lane` of `others` than the root of `reach_sq`.
    /// The planes' directions approach the shortest connection by the method of Frank and Wolfe: from a point of the
    /// difference of two triangles straight on to its corner that is nearest along the present direction. Any direction
    /// gives a bound, whatever its rounding.
    #[inline]
    fn lanes_apart(&self, others: &Self, lane: usize, reach_sq: Vec4, wanted: u32) -> u32 {
        let corners2 = others.corners.map(|points| points.splat_lane(lane));
        let mut way = others.middle.splat_lane(lane).map_two(self.middle, |other, own| other - own);
        let mut apart = 0;
        for _ in 0..DIRECTIONS {
            let (reach1, far1) = farthest_along(&self.corners, way, Vec4::cmpge);
            let (reach2, far2) = farthest_along(&corners2, way, Vec4::cmple);
            let (gap, way_sq) = (reach2 - reach1, way.dot(way));
            let gap_sq = gap * gap.max(Vec4::ZERO);
            let long = way_sq.cmpgt(Vec4::splat(MIN_DIRECTION_SQ));
            apart |= (gap_sq.cmpgt(reach_sq * way_sq) & long).bitmask();
            if wanted & !apart == 0 {
                break;
            }
            let onward = far2.map_two(far1, |p, q| p - q).map_two(way, |p, q| p - q);
            let share = (way_sq - gap) / onward.dot(onward).max(Vec4::splat(f32::MIN_POSITIVE));
            let share = share.max(Vec4::ZERO).min(Vec4::ONE);
            way = way.map_two(onward, |p, q| p + q * share);
        }
        apart
    }
}

/// Of three points of each lane the one that comes first along a direction by `is_before`, and where along it.
#[inline]
fn farthest_along(
    points: &[LanePoints; 3],
    way: LanePoints,
    is_before: impl Fn(Vec4, Vec4) -> BVec4A,
) -> (Vec4, LanePoints) {
    let [a, b, c] = points.map(|p| p.dot(way));
    let is_a = is_before(a, b);
    let (reach, point) = (Vec4::select(is_a, a, b), LanePoints::select(is_a, points[0], points[1]));
    let stays = is_before(reach, c);
    (Vec4::select(stays, reach, c), LanePoints::select(stays, point, points[2]))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Whole numbers make touching, parallel and flat triangles, tiny differences slivers.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![-5.0..5.0, (-3i32..=3).prop_map(f64::from), (0i32..3).prop_map(|k| f64::from(k) * 1e-7)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2048))]

        #[test]
        fn no_triangle_within_reach_is_ruled_out(
            c in proptest::collection::vec(coordinate(), 45), far in prop_oneof![Just(0.0), Just(300.0), Just(1e5)],
        ) {
            let corners: Vec<[DVec3; 3]> =
                c.chunks(9).map(|t| [0, 3, 6].map(|k| DVec3::new(t[k] + far, t[k + 1], t[k + 2]))).collect();
            let lanes = TriangleLanes::of_corners(corners[..4].iter().copied()).with_spans();
            let other = TriangleLanes::of_corners(corners[4..].iter().copied()).with_spans();
            let two = Triangle::new(corners[4]);
            let margin = 2e-6 * (far + 20.0) as f32;
            for (lane, &one) in corners[..4].iter().enumerate() {
                let exact = Triangle::new(one).distance_sq_below(&two, f64::INFINITY).sqrt();
                let reach = exact as f32 * (1.0 + 1e-6) + margin;
                prop_assert!(lanes.lanes_within(&other, 0, reach) & 1 << lane != 0, "lane {lane} at {exact}");
            }
        }
    }

    #[test]
    fn what_is_clearly_farther_is_ruled_out() {
        let flat = |z: f64| [DVec3::new(0.0, 0.0, z), DVec3::new(4.0, 0.0, z), DVec3::new(0.0, 4.0, z)];
        let lanes = TriangleLanes::of_corners([flat(1.0), flat(2.0), flat(3.0), flat(9.0)].into_iter()).with_spans();
        let other = TriangleLanes::of_corners([flat(0.0)].into_iter()).with_spans();
        assert_eq!(lanes.lanes_within(&other, 0, 2.5), 0b0011);
    }

    #[test]
    fn coordinates_beyond_single_precision_rule_nothing_out() {
        let far = [DVec3::new(1e39, 0.0, 0.0), DVec3::new(1e39, 4.0, 0.0), DVec3::new(-1e39, 0.0, 4.0)];
        let lanes = TriangleLanes::of_corners([far; 4].into_iter()).with_spans();
        let other = TriangleLanes::of_corners([far].into_iter()).with_spans();
        assert_eq!(lanes.lanes_within(&other, 0, f32::NAN), 0b1111);
    }
}
