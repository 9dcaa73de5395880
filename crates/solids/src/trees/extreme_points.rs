//! Finds the points of a cloud that reach farthest in given directions without testing every point for every direction.

use std::ops::Range;

use glam::{DVec3, Vec3A, Vec4};

use super::triangle_lanes::{LANES, LanePoints};
use crate::Bounds;

/// Approximate number of points per cell; with fewer, boxes cost more than they save.
const PER_CELL: usize = 64;
/// Greatest number of cells along an axis.
const MAX_CELLS: usize = 24;
/// How far a dot product in single precision may be wrong where no coordinate exceeds 1: a few times the rounding of six
/// coordinates, three products and two sums.
const ROUNDING: f32 = 4e-6;

/// Points with what finds the farthest of them.
#[derive(Debug)]
pub struct ExtremePoints<'a> {
    points: &'a [DVec3],
    cells: PointCells,
}

impl<'a> ExtremePoints<'a> {
    /// Sorts finite points into cells. Time grows with their number.
    pub fn new(points: &'a [DVec3]) -> Self {
        Self { points, cells: PointCells::new(points) }
    }

    /// Index of the point that reaches farthest in a direction; of equal points the first one. 0 without points.
    pub fn farthest_point(&self, direction: DVec3) -> usize {
        self.cells.farthest_point(self.points, direction).map_or(0, |(_, index)| index as usize)
    }

    /// Indices of the points that are farthest in any of `directions`, in rising order, without duplicates.
    pub fn farthest_points(&self, directions: impl Iterator<Item = DVec3>) -> Vec<usize> {
        let mut chosen: Vec<usize> = directions.map(|direction| self.farthest_point(direction)).collect();
        chosen.sort_unstable();
        chosen.dedup();
        chosen
    }
}

/// Points sorted into cells of a regular grid, in single precision. What finds the farthest of them by these looks at the
/// points themselves only where they are about as far.
#[derive(Debug, Clone)]
pub(crate) struct PointCells {
    /// The blocks of points of each cell.
    cells: Vec<Range<u32>>,
    /// Middles and half sizes of the boxes of four cells each. Along its longest axis the cloud reaches from -1 to 1.
    boxes: Vec<[LanePoints; 2]>,
    /// Four points each, on the same scale. The last point of a cell is repeated.
    blocks: Vec<LanePoints>,
    /// The indices of the points of each block.
    indices: Vec<[u32; LANES]>,
}

impl PointCells {
    /// Sorts finite points into cells. Time grows with their number.
    pub fn new(points: &[DVec3]) -> Self {
        let bounds = Bounds::from_points(points.iter().copied());
        let (middle, half) = (bounds.center(), (0.5 * bounds.size().max_element()).max(f64::MIN_POSITIVE));
        // A surface fills about as many cells as the square of the number along an axis.
        let along = ((points.len() / PER_CELL) as f64 / 3.0).sqrt().clamp(1.0, MAX_CELLS as f64) as usize;
        let scale = DVec3::splat(along as f64) / bounds.size().max(DVec3::splat(1e-300));
        let cell_of = |p: DVec3| {
            let at = ((p - bounds.min) * scale).to_array().map(|v| (v as usize).min(along - 1));
            (at[2] * along + at[1]) * along + at[0]
        };
        let homes: Vec<u32> = points.iter().map(|&p| cell_of(p) as u32).collect();
        let mut ends = vec![0_u32; along.pow(3) + 1];
        homes.iter().for_each(|&home| ends[home as usize + 1] += 1);
        (0..along.pow(3)).for_each(|cell| ends[cell + 1] += ends[cell]);
        let mut order = vec![0_u32; points.len()];
        for (index, &home) in homes.iter().enumerate() {
            order[ends[home as usize] as usize] = index as u32;
            ends[home as usize] += 1;
        }
        let mut sorted = Self {
            cells: Vec::new(),
            boxes: Vec::new(),
            blocks: Vec::with_capacity(points.len().div_ceil(LANES)),
            indices: Vec::with_capacity(points.len().div_ceil(LANES)),
        };
        let (mut centers, mut halves) = (Vec::new(), Vec::new());
        for indices in order.chunk_by(|&one, &other| homes[one as usize] == homes[other as usize]) {
            let place = |&index: &u32| ((points[index as usize] - middle) / half).as_vec3a();
            let near: Vec<Vec3A> = indices.iter().map(place).collect();
            let min = near.iter().copied().fold(Vec3A::INFINITY, Vec3A::min);
            let max = near.iter().copied().fold(Vec3A::NEG_INFINITY, Vec3A::max);
            centers.push(0.5 * (min + max));
            halves.push(0.5 * (max - min));
            let first = sorted.blocks.len() as u32;
            sorted.blocks.extend(near.chunks(LANES).map(LanePoints::of_points));
            let lanes = |some: &[u32]| std::array::from_fn(|lane| some[lane.min(some.len() - 1)]);
            sorted.indices.extend(indices.chunks(LANES).map(lanes));
            sorted.cells.push(first..sorted.blocks.len() as u32);
        }
        let boxes = centers.chunks(LANES).zip(halves.chunks(LANES));
        sorted.boxes = boxes.map(|(centers, halves)| [centers, halves].map(LanePoints::of_points)).collect();
        sorted
    }

    /// How far the points from which the cells were made reach in a direction (the greatest dot product), and the index of
    /// the point that does; of equal points the first one. `None` without points. Exact, unless the cloud is a billion times
    /// farther off than it is large: then equal up to the rounding of the product.
    pub fn farthest_point(&self, points: &[DVec3], direction: DVec3) -> Option<(f64, u32)> {
        let way = (direction / direction.abs().max_element().max(f64::MIN_POSITIVE)).as_vec3a();
        let [along, spread] = [way, way.abs()].map(|way| LanePoints::of_points(&[way]));
        let reach = |[center, half]: &[LanePoints; 2]| center.dot(along) + half.dot(spread) + ROUNDING;
        let reaches: Vec<Vec4> = self.boxes.iter().map(reach).collect();
        let reaches = || reaches.iter().flat_map(|some| some.to_array()).zip(&self.cells);
        let range_of = |cell: &Range<u32>| cell.start as usize..cell.end as usize;
        let farthest = |cell: &Range<u32>| {
            let blocks = self.blocks[range_of(cell)].iter();
            blocks.fold(Vec4::NEG_INFINITY, |most, block| most.max(block.dot(along))).max_element()
        };
        let (_, outermost) = reaches().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut far = farthest(outermost);
        for (reach, cell) in reaches() {
            if reach > far {
                far = far.max(farthest(cell));
            }
        }
        far -= ROUNDING;
        let mut best = (f64::NEG_INFINITY, u32::MAX);
        for at in reaches().filter(|(reach, _)| *reach >= far).flat_map(|(_, cell)| range_of(cell)) {
            let mut near = self.blocks[at].dot(along).cmpge(Vec4::splat(far)).bitmask();
            while near != 0 {
                let index = self.indices[at][near.trailing_zeros() as usize];
                near &= near - 1;
                let exact = points[index as usize].dot(direction);
                if exact > best.0 || exact == best.0 && index < best.1 {
                    best = (exact, index);
                }
            }
        }
        (best.1 != u32::MAX).then_some(best)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn first_farthest(points: &[DVec3], direction: DVec3) -> usize {
        let far = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
        points.iter().map(|p| p.dot(direction)).enumerate().fold((0, f64::NEG_INFINITY), far).0
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn cells_find_what_looking_at_every_point_finds(
            points in proptest::collection::vec(proptest::array::uniform3(-9.0..9.0f64), 1..2000),
            direction in proptest::array::uniform3(-1.0..1.0f64),
            // Rounded points have equals, on which the first must win.
            step in prop_oneof![Just(1e-9), Just(1.0), Just(20.0)],
            (scale, away) in prop_oneof![Just((1.0, 0.0)), Just((1.0, 1e6)), Just((1e-200, 0.0)), Just((1e200, 0.0))],
            // Nearly flat points differ by less than single precision.
            thickness in prop_oneof![Just(1.0), Just(1e-9)],
            length in prop_oneof![Just(1.0), Just(1e-3), Just(1e3)],
        ) {
            let direction = DVec3::from_array(direction);
            let normal = direction.normalize_or(DVec3::X);
            let place = |&p: &[f64; 3]| {
                let rounded = (DVec3::from_array(p) / step).round() * step;
                (rounded - normal * normal.dot(rounded) * (1.0 - thickness)) * scale + away
            };
            let points: Vec<DVec3> = points.iter().map(place).collect();
            let cells = ExtremePoints::new(&points);
            for direction in [direction, -direction, DVec3::X, DVec3::NEG_Z, DVec3::ZERO] {
                let direction = direction * length;
                prop_assert_eq!(cells.farthest_point(direction), first_farthest(&points, direction));
            }
        }
    }

    #[test]
    fn no_points_and_no_number_give_no_point() {
        assert_eq!(ExtremePoints::new(&[]).farthest_point(DVec3::X), 0);
        assert_eq!(ExtremePoints::new(&[DVec3::ONE]).farthest_point(DVec3::NAN), 0);
    }
}
