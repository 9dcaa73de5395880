//! Where does an item stand lowest? Every lattice position of every rotation is asked, but none twice in vain: places only
//! fill up, so what was found once stays a lower bound.

use super::{
    recipe::Recipe,
    voxels::{Occupancy, Raster},
};

/// The lowest layer known to be worth asking, for every position of every raster of one item.
#[derive(Debug, Clone, Default)]
pub(crate) struct Floors(Vec<Floor>);

/// Of one raster, position by position in rows along y.
#[derive(Debug, Clone)]
struct Floor {
    layers: Vec<u16>,
    /// The least of every row.
    rows: Vec<u16>,
    count: usize,
    end: usize,
}

impl Floors {
    /// Nothing is known but the positions inside the walls.
    pub(crate) fn new(occupancy: &Occupancy, rasters: &[Raster]) -> Self {
        let floor = |raster: &Raster| {
            let [rows, count, end] = occupancy.positions(raster).unwrap_or([0; 3]);
            Floor { layers: vec![0; rows * count], rows: vec![0; rows], count, end }
        };
        Self(rasters.iter().map(floor).collect())
    }

    /// Bytes in memory, about.
    pub(crate) fn bytes(&self) -> usize {
        self.0.iter().map(|floor| 2 * floor.layers.len()).sum()
    }

    /// A position at which the triangles are in the way after all.
    pub(crate) fn forbid(&mut self, at: usize, [x, y, z]: [usize; 3]) {
        let floor = &mut self.0[at];
        floor.layers[x * floor.count + y] = z as u16 + 1;
        floor.settle(x);
    }

    /// A part would be locked here, and so near, whatever its rotation.
    pub(crate) fn forbid_around(&mut self, [x, y, z]: [usize; 3], reach: usize) {
        let low = z.saturating_sub(reach);
        for floor in self.0.iter_mut().filter(|floor| !floor.layers.is_empty()) {
            for x in x.saturating_sub(reach)..(x + reach + 1).min(floor.rows.len()) {
                for y in y.saturating_sub(reach)..(y + reach + 1).min(floor.count) {
                    let layer = &mut floor.layers[x * floor.count + y];
                    if usize::from(*layer) >= low {
                        *layer = (*layer).max((z + reach + 1) as u16);
                    }
                }
                floor.settle(x);
            }
        }
    }

    /// Layers from `layer` up to `by` above it are full for a raster, at all positions.
    pub(crate) fn raise(&mut self, at: usize, layer: usize, by: usize) {
        let floor = &mut self.0[at];
        let (full, free) = (layer as u16, (layer + by).min(floor.end) as u16);
        floor.layers.iter_mut().filter(|floor| (full..free).contains(*floor)).for_each(|floor| *floor = free);
        (0..floor.rows.len()).for_each(|x| floor.settle(x));
    }

    /// The raster and lattice position with the least score.
    pub(crate) fn lowest_score(
        &mut self,
        recipe: &Recipe,
        occupancy: &Occupancy,
        rasters: &[Raster],
        tests: &mut u64,
    ) -> Option<(usize, [usize; 3])> {
        let scores: Vec<f64> = rasters.iter().map(|r| recipe.top_share * r.size.z / occupancy.pitch).collect();
        let bound = |floor: &Floor, at: usize, x: usize| {
            f64::from(floor.rows[x]) + scores[at] + 0.01 * recipe.pull_x * x as f64
        };
        let rows = self.0.iter().enumerate().flat_map(|(at, floor)| {
            let open = (0..floor.rows.len()).filter(|&x| usize::from(floor.rows[x]) < floor.end);
            open.map(move |x| (at, x)).collect::<Vec<_>>()
        });
        // The most promising row comes first: what it gives spares most of the others.
        let mut rows: Vec<(f64, usize, usize)> = rows.map(|(at, x)| (bound(&self.0[at], at, x), at, x)).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut best: Option<(f64, usize, [usize; 3])> = None;
        for (promise, at, x) in rows {
            if best.is_some_and(|(least, ..)| promise >= least) {
                break;
            }
            let floor = &mut self.0[at];
            for y in 0..floor.count {
                let pull = 0.01 * (recipe.pull_x * x as f64 + (1.0 - recipe.pull_x) * y as f64);
                let least = best.map_or(f64::INFINITY, |(score, ..)| score);
                let end =
                    if least.is_finite() { (least - scores[at] - pull).ceil().max(0.0) as usize } else { floor.end };
                let end = end.min(floor.end);
                let layer = &mut floor.layers[x * floor.count + y];
                if usize::from(*layer) >= end {
                    continue;
                }
                *tests += 1;
                let found = occupancy.lowest(&rasters[at], [x, y], usize::from(*layer), end);
                *layer = found.unwrap_or(end) as u16;
                if let Some(z) = found {
                    let score = z as f64 + scores[at] + pull;
                    if score < least {
                        best = Some((score, at, [x, y, z]));
                    }
                }
            }
            floor.settle(x);
        }
        best.map(|(_, at, node)| (at, node))
    }
}

impl Floor {
    fn settle(&mut self, x: usize) {
        let row = &self.layers[x * self.count..(x + 1) * self.count];
        self.rows[x] = row.iter().copied().min().unwrap_or(u16::MAX);
    }
}
