//! Finds the points of a cloud that reach farthest in given directions without testing every point for every direction.

use glam::DVec3;

use super::Bounds;

/// Approximate number of points per cell; with fewer, boxes cost more than they save.
const PER_CELL: usize = 48;
/// Greatest number of cells along an axis.
const MAX_CELLS: usize = 24;

/// Points sorted into cells of a regular grid, each with its bounds.
#[derive(Debug)]
pub struct ExtremePoints<'a> {
    points: &'a [DVec3],
    /// Indices of points, cell by cell.
    order: Vec<u32>,
    cells: Vec<PointCell>,
}

#[derive(Debug)]
struct PointCell {
    center: DVec3,
    half: DVec3,
    first: u32,
    end: u32,
}

impl<'a> ExtremePoints<'a> {
    /// Sorts finite points into cells. Time grows with their number.
    pub fn new(points: &'a [DVec3]) -> Self {
        let bounds = Bounds::from_points(points.iter().copied());
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
        let mut first = 0;
        let cells = (ends[..along.pow(3)].iter())
            .filter_map(|&end| {
                let range = first..end;
                first = end;
                (!range.is_empty()).then_some(range)
            })
            .map(|range| {
                let indices = &order[range.start as usize..range.end as usize];
                let bounds = Bounds::from_points(indices.iter().map(|&i| points[i as usize]));
                PointCell { center: bounds.center(), half: 0.5 * bounds.size(), first: range.start, end: range.end }
            })
            .collect();
        Self { points, order, cells }
    }

    /// Index of the point that reaches farthest in a direction; of equal points the first one. 0 without points.
    pub fn farthest_point(&self, direction: DVec3) -> usize {
        let spread = direction.abs();
        let reach = |cell: &PointCell| cell.center.dot(direction) + cell.half.dot(spread);
        let mut best = (f64::NEG_INFINITY, u32::MAX);
        let mut look = |cell: &PointCell| {
            for &index in &self.order[cell.first as usize..cell.end as usize] {
                let along = self.points[index as usize].dot(direction);
                if along > best.0 || along == best.0 && index < best.1 {
                    best = (along, index);
                }
            }
            best.0
        };
        let outermost = self.cells.iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
        let mut least = outermost.map_or(0.0, &mut look);
        let slack = 1e-12 * (least.abs() + outermost.map_or(0.0, |cell| cell.half.dot(spread)));
        for cell in &self.cells {
            if reach(cell) >= least - slack {
                least = look(cell);
            }
        }
        if best.1 == u32::MAX { 0 } else { best.1 as usize }
    }

    /// Indices of the points that are farthest in any of `directions`, in rising order, without duplicates.
    pub fn farthest_points(&self, directions: impl Iterator<Item = DVec3>) -> Vec<usize> {
        let mut chosen: Vec<usize> = directions.map(|direction| self.farthest_point(direction)).collect();
        chosen.sort_unstable();
        chosen.dedup();
        chosen
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
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn cells_find_what_looking_at_every_point_finds(
            points in proptest::collection::vec(proptest::array::uniform3(-9.0..9.0f64), 1..2000),
            direction in proptest::array::uniform3(-1.0..1.0f64),
            // Rounded points have equals, on which the first must win.
            step in prop_oneof![Just(1e-9), Just(1.0), Just(20.0)],
        ) {
            let points: Vec<DVec3> = points.iter().map(|&p| (DVec3::from_array(p) / step).round() * step).collect();
            let cells = ExtremePoints::new(&points);
            for direction in [DVec3::from_array(direction), DVec3::X, DVec3::NEG_Z] {
                prop_assert_eq!(cells.farthest_point(direction), first_farthest(&points, direction));
            }
        }
    }
}
