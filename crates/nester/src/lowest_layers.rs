//! Finds the lowest position of an item over all lattice positions of all rotations. Voxels only fill up, so the layer
//! found once for a position stays a lower bound and is not searched again.

use super::{
    recipe::PlacementRecipe,
    voxels::{OccupancyGrid, PartRaster},
};

/// For every position of every raster of one item, the lowest layer that may still be free.
#[derive(Debug, Clone, Default)]
pub(crate) struct LowestLayers(Vec<RasterLowestLayers>);

/// The lowest layers of one raster, in rows along y.
#[derive(Debug, Clone)]
struct RasterLowestLayers {
    layers: Vec<u16>,
    /// The least value of every row.
    row_minima: Vec<u16>,
    count: usize,
    end: usize,
}

impl LowestLayers {
    /// Nothing is known yet except the positions inside the walls.
    pub(crate) fn new(occupancy: &OccupancyGrid, rasters: &[PartRaster]) -> Self {
        let floor = |raster: &PartRaster| {
            let [rows, count, end] = occupancy.lattice_positions(raster).unwrap_or([0; 3]);
            RasterLowestLayers { layers: vec![0; rows * count], row_minima: vec![0; rows], count, end }
        };
        Self(rasters.iter().map(floor).collect())
    }

    /// Approximate memory, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.0.iter().map(|floor| 2 * floor.layers.len()).sum()
    }

    /// Excludes a position that failed the exact test.
    pub(crate) fn forbid_position(&mut self, at: usize, [x, y, z]: [usize; 3]) {
        let floor = &mut self.0[at];
        floor.layers[x * floor.count + y] = z as u16 + 1;
        floor.update_row_minimum(x);
    }

    /// Excludes a position at which the part would be locked, and the positions near it, for every rotation.
    pub(crate) fn forbid_positions_around(&mut self, [x, y, z]: [usize; 3], reach: usize) {
        let low = z.saturating_sub(reach);
        for floor in self.0.iter_mut().filter(|floor| !floor.layers.is_empty()) {
            for x in x.saturating_sub(reach)..(x + reach + 1).min(floor.row_minima.len()) {
                for y in y.saturating_sub(reach)..(y + reach + 1).min(floor.count) {
                    let layer = &mut floor.layers[x * floor.count + y];
                    if usize::from(*layer) >= low {
                        *layer = (*layer).max((z + reach + 1) as u16);
                    }
                }
                floor.update_row_minimum(x);
            }
        }
    }

    /// Marks the layers from `layer` up to `by` above it as full for a raster, at all positions.
    pub(crate) fn raise_full_layers(&mut self, at: usize, layer: usize, by: usize) {
        let floor = &mut self.0[at];
        let (full, free) = (layer as u16, (layer + by).min(floor.end) as u16);
        floor.layers.iter_mut().filter(|floor| (full..free).contains(*floor)).for_each(|floor| *floor = free);
        (0..floor.row_minima.len()).for_each(|x| floor.update_row_minimum(x));
    }

    /// The raster and lattice position with the least score. Adds the columns compared to `steps`.
    pub(crate) fn lowest_scored_position(
        &mut self,
        recipe: &PlacementRecipe,
        occupancy: &OccupancyGrid,
        rasters: &[PartRaster],
        steps: &mut u64,
    ) -> Option<(usize, [usize; 3])> {
        let scores: Vec<f64> = rasters.iter().map(|r| recipe.top_share * r.size.z / occupancy.pitch).collect();
        let bound = |floor: &RasterLowestLayers, at: usize, x: usize| {
            f64::from(floor.row_minima[x]) + scores[at] + 0.01 * recipe.pull_x * x as f64
        };
        let rows = self.0.iter().enumerate().flat_map(|(at, floor)| {
            let open = (0..floor.row_minima.len()).filter(|&x| usize::from(floor.row_minima[x]) < floor.end);
            open.map(move |x| (at, x)).collect::<Vec<_>>()
        });
        // Start with the most promising row: its result excludes most of the others.
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
                let found = occupancy.lowest_free_layer(&rasters[at], [x, y], usize::from(*layer)..end, steps);
                *layer = found.unwrap_or(end) as u16;
                if let Some(z) = found {
                    let score = z as f64 + scores[at] + pull;
                    if score < least {
                        best = Some((score, at, [x, y, z]));
                    }
                }
            }
            floor.update_row_minimum(x);
        }
        best.map(|(_, at, node)| (at, node))
    }
}

impl RasterLowestLayers {
    fn update_row_minimum(&mut self, x: usize) {
        let row = &self.layers[x * self.count..(x + 1) * self.count];
        self.row_minima[x] = row.iter().copied().min().unwrap_or(u16::MAX);
    }
}
