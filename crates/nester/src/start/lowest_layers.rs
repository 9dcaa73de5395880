//! Finds the lowest position of an item over all lattice positions of all rotations. Voxels only fill up, so the layer
//! found once for a position, or for a block of positions, stays a lower bound and is not searched again.

use super::{occupancy_grid::OccupancyGrid, recipe::PlacementRecipe};
use crate::shapes::part_raster::{PartRaster, RASTER_LEVELS};

/// For every position of every raster of one item, the lowest layer that may still be free.
#[derive(Debug, Clone, Default)]
pub(crate) struct LowestLayers(Vec<RasterLowestLayers>);

/// The lowest layers of one raster.
#[derive(Debug, Clone)]
struct RasterLowestLayers {
    /// Number of positions along x and y.
    extent: [usize; 2],
    /// The layer after the last one inside the walls.
    end: usize,
    /// For every level of the raster, a layer for every block of positions, in rows along y. At all positions of a block
    /// and at all layers below it, the part collides or is not wanted.
    levels: Vec<Vec<u16>>,
    /// The least value of every row of the greatest blocks.
    row_minima: Vec<u16>,
}

/// The search for the position with the least score.
struct PositionSearch<'a> {
    recipe: &'a PlacementRecipe,
    occupancy: &'a OccupancyGrid,
    steps: &'a mut u64,
    /// The least score so far, infinite at first,
    least: f64,
    /// and the raster and lattice position that have it.
    best: Option<(usize, [usize; 3])>,
}

/// One of the rasters in a search.
struct SearchedRaster<'a> {
    number: usize,
    raster: &'a PartRaster,
    /// For every level, the column that collided last.
    last_hits: [usize; RASTER_LEVELS],
}

impl LowestLayers {
    /// Nothing is known yet except the positions inside the walls.
    pub(crate) fn new(occupancy: &OccupancyGrid, rasters: &[PartRaster]) -> Self {
        Self(rasters.iter().map(|raster| RasterLowestLayers::new(occupancy, raster)).collect())
    }

    /// Approximate memory, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.0.iter().flat_map(|floor| &floor.levels).map(|layers| 2 * layers.len()).sum()
    }

    /// Excludes a position that failed the exact test.
    pub(crate) fn forbid_position(&mut self, at: usize, [x, y, z]: [usize; 3]) {
        let floor = &mut self.0[at];
        let index = floor.index(0, [x, y]);
        floor.levels[0][index] = z as u16 + 1;
    }

    /// Excludes a position at which the part would be locked, and the positions near it, for every rotation.
    pub(crate) fn forbid_positions_around(&mut self, [x, y, z]: [usize; 3], reach: usize) {
        let low = z.saturating_sub(reach);
        for floor in &mut self.0 {
            for x in x.saturating_sub(reach)..(x + reach + 1).min(floor.extent[0]) {
                for y in y.saturating_sub(reach)..(y + reach + 1).min(floor.extent[1]) {
                    let layer = floor.lowest_layer([x, y]);
                    if usize::from(layer) >= low {
                        let index = floor.index(0, [x, y]);
                        floor.levels[0][index] = layer.max((z + reach + 1) as u16);
                    }
                }
            }
        }
    }

    /// Marks the layers from `layer` up to `by` above it as full for a raster, at all positions.
    pub(crate) fn raise_full_layers(&mut self, at: usize, layer: usize, by: usize) {
        let floor = &mut self.0[at];
        let (full, free) = (layer as u16, (layer + by).min(floor.end) as u16);
        let layers = floor.levels.iter_mut().flatten();
        layers.filter(|layer| (full..free).contains(*layer)).for_each(|layer| *layer = free);
        (0..floor.row_minima.len()).for_each(|row| floor.update_row_minimum(row));
    }

    /// The raster and lattice position with the least score. Adds the columns compared to `steps`.
    pub(crate) fn lowest_scored_position(
        &mut self,
        recipe: &PlacementRecipe,
        occupancy: &OccupancyGrid,
        rasters: &[PartRaster],
        steps: &mut u64,
    ) -> Option<(usize, [usize; 3])> {
        let mut search = PositionSearch { recipe, occupancy, steps, least: f64::INFINITY, best: None };
        let mut searched: Vec<SearchedRaster<'_>> = (rasters.iter().enumerate())
            .map(|(number, raster)| SearchedRaster { number, raster, last_hits: [0; RASTER_LEVELS] })
            .collect();
        let mut rows: Vec<(f64, usize, usize)> = Vec::new();
        for (floor, raster) in self.0.iter().zip(&searched) {
            for (row, &layer) in floor.row_minima.iter().enumerate().filter(|&(_, &low)| usize::from(low) < floor.end) {
                let first = [row << floor.top_level(), 0, layer.into()];
                rows.push((search.score(raster.raster, first), raster.number, row));
            }
        }
        // Start with the most promising row: its result excludes most of the others.
        rows.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (promise, number, row) in rows {
            if promise >= search.least {
                break;
            }
            let floor = &mut self.0[number];
            let level = floor.top_level();
            for y in (0..floor.extent[1]).step_by(1 << level) {
                search.visit_block(floor, &mut searched[number], level, [row << level, y]);
            }
            floor.update_row_minimum(row);
        }
        search.best
    }
}

impl RasterLowestLayers {
    fn new(occupancy: &OccupancyGrid, raster: &PartRaster) -> Self {
        let [rows, count, end] = occupancy.lattice_positions(raster).unwrap_or([0; 3]);
        let blocks = |level: usize| rows.div_ceil(1 << level) * count.div_ceil(1 << level);
        let levels: Vec<Vec<u16>> = (0..raster.levels.len()).map(|level| vec![0; blocks(level)]).collect();
        let row_minima = vec![0; rows.div_ceil(1 << (levels.len() - 1))];
        Self { extent: [rows, count], end, levels, row_minima }
    }

    /// The level of the greatest blocks.
    fn top_level(&self) -> usize {
        self.levels.len() - 1
    }

    /// Index of the block of a level that contains a position.
    fn index(&self, level: usize, [x, y]: [usize; 2]) -> usize {
        (x >> level) * self.extent[1].div_ceil(1 << level) + (y >> level)
    }

    /// The layer below which all levels together exclude a position.
    fn lowest_layer(&self, at: [usize; 2]) -> u16 {
        let of_levels = self.levels.iter().enumerate().map(|(level, layers)| layers[self.index(level, at)]);
        of_levels.max().unwrap_or(0)
    }

    fn update_row_minimum(&mut self, row: usize) {
        let level = self.top_level();
        let count = self.extent[1].div_ceil(1 << level);
        let layers = &self.levels[level][row * count..(row + 1) * count];
        self.row_minima[row] = layers.iter().copied().min().unwrap_or(u16::MAX);
    }
}

impl PositionSearch<'_> {
    /// The score of a position of a raster; less is better.
    fn score(&self, raster: &PartRaster, [x, y, z]: [usize; 3]) -> f64 {
        let pull = self.recipe.pull_x * x as f64 + (1.0 - self.recipe.pull_x) * y as f64;
        z as f64 + self.recipe.top_share * raster.size.z / self.occupancy.pitch + 0.01 * pull
    }

    /// Searches a block of positions for a lower score, and remembers what layers are excluded. Of all positions of the
    /// block, (x, y) has the least score at a layer.
    fn visit_block(
        &mut self,
        floor: &mut RasterLowestLayers,
        searched: &mut SearchedRaster<'_>,
        level: usize,
        [x, y]: [usize; 2],
    ) {
        let at_bottom = self.score(searched.raster, [x, y, 0]);
        let end = (self.least - at_bottom).ceil().clamp(0.0, floor.end as f64) as usize;
        let index = floor.index(level, [x, y]);
        let known = usize::from(floor.levels[level][index]);
        if known >= end {
            return;
        }
        let (columns, last_hit) = (&searched.raster.levels[level], &mut searched.last_hits[level]);
        let found = self.occupancy.lowest_free_layer(columns, [x, y], known..end, last_hit, self.steps);
        floor.levels[level][index] = found.unwrap_or(end) as u16;
        let Some(layer) = found else { return };
        if level == 0 {
            let score = self.score(searched.raster, [x, y, layer]);
            if score < self.least {
                (self.least, self.best) = (score, Some((searched.number, [x, y, layer])));
            }
            return;
        }
        let (below, half) = (level - 1, 1 << (level - 1));
        let mut lowest = u16::MAX;
        for at in [[x, y], [x, y + half], [x + half, y], [x + half, y + half]] {
            if at[0] < floor.extent[0] && at[1] < floor.extent[1] {
                let part = floor.index(below, at);
                floor.levels[below][part] = floor.levels[below][part].max(layer as u16);
                self.visit_block(floor, searched, below, at);
                lowest = lowest.min(floor.levels[below][part]);
            }
        }
        floor.levels[level][index] = lowest;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DQuat, DVec3};
    use proptest::prelude::*;
    use solids::{Bounds, Pose};

    use super::*;
    use crate::{
        OrientationRule,
        tests::{
            nester_tests::{asked, item},
            testing::{block, coarsely_prepared},
        },
    };

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn no_position_has_a_lower_score_than_the_one_found(
            top_share in 0.0..1.0, pull_x in 0.0..1.0, order in prop::collection::vec(any::<u32>(), 14), lift in 0..2_usize,
        ) {
            let clip = Arc::new(sample_parts::clip(22.0, 2.4, 9.0));
            let instance = asked(DVec3::new(41.0, 37.0, 90.0), 1.0, vec![item(clip, 1, OrientationRule::Free)]);
            let prepared = coarsely_prepared(&instance);
            let shape = &prepared.prepared_item(0).shape;
            let turns = [DQuat::IDENTITY, DQuat::from_rotation_x(1.5), DQuat::from_rotation_y(0.6)];
            let rasters = turns.map(|turn| PartRaster::new(shape, turn, 1.0, (1.1, 0.45, lift), &mut 0));
            let mut occupancy = OccupancyGrid::new(prepared.room, 1.0, 1.1, lift);
            let recipe = PlacementRecipe { order: 0, top_share, pull_x, shuffle: 0.0 };
            let mut floors = LowestLayers::new(&occupancy, &rasters);
            let mut forbidden: Vec<(usize, [usize; 3])> = Vec::new();
            for (count, choice) in order.into_iter().enumerate() {
                let mut search =
                    PositionSearch { recipe: &recipe, occupancy: &occupancy, steps: &mut 0, least: f64::INFINITY, best: None };
                for (number, raster) in rasters.iter().enumerate() {
                    let [xs, ys, zs] = occupancy.lattice_positions(raster).unwrap_or([0; 3]);
                    for (x, y) in (0..xs).flat_map(|x| (0..ys).map(move |y| (x, y))) {
                        let above = forbidden.iter().filter(|(at, [fx, fy, _])| (*at, *fx, *fy) == (number, x, y));
                        let from = above.map(|(_, [.., z])| z + 1).max().unwrap_or(0);
                        let columns = &raster.levels[0];
                        if let Some(z) = occupancy.lowest_free_layer(columns, [x, y], from..zs, &mut 0, &mut 0) {
                            search.least = search.least.min(search.score(raster, [x, y, z]));
                        }
                    }
                }
                let found = floors.lowest_scored_position(&recipe, &occupancy, &rasters, &mut 0);
                let score = found.map_or(f64::INFINITY, |(number, node)| search.score(&rasters[number], node));
                prop_assert!(score == search.least || (score - search.least).abs() < 1e-9, "{score} {}", search.least);
                let Some((number, node)) = found else { break };
                if choice % 4 == 0 {
                    floors.forbid_position(number, node);
                    forbidden.push((number, node));
                } else if count % 2 == 0 {
                    occupancy.fill_raster(&rasters[number], node);
                } else {
                    let rotation = rasters[number].rotation;
                    let center = occupancy.center_at(&rasters[number], node);
                    let pose = Pose::new(rotation, center - rotation * shape.center);
                    occupancy.fill_solid(shape, &pose, &shape.tree.bounds_at(&pose), 0.9, 0.5);
                }
            }
        }
    }

    #[test]
    fn a_position_that_locks_a_part_is_forbidden_with_those_around_it_in_ruled_out_blocks_too() {
        let items = vec![item(block(DVec3::new(9.0, 9.0, 5.0)), 1, OrientationRule::Free)];
        let prepared = coarsely_prepared(&asked(DVec3::new(60.0, 60.0, 60.0), 1.0, items));
        let shape = &prepared.prepared_item(0).shape;
        let rasters = [PartRaster::new(shape, DQuat::IDENTITY, 1.0, (1.0, 0.45, 0), &mut 0)];
        let mut occupancy = OccupancyGrid::new(prepared.room, 1.0, 1.0, 0);
        let recipe = PlacementRecipe::FIRST[0];
        let full = Bounds { min: DVec3::ZERO, max: DVec3::new(60.0, 60.0, 20.0) };
        let floor = block(full.size());
        let solid = coarsely_prepared(&asked(DVec3::splat(80.0), 1.0, vec![item(floor, 1, OrientationRule::Free)]));
        occupancy.fill_solid(&solid.prepared_item(0).shape, &Pose::IDENTITY, &full, 0.9, 0.5);
        let mut floors = LowestLayers::new(&occupancy, &rasters);
        let mut found: Vec<[usize; 3]> = Vec::new();
        while found.len() < 6 {
            let (_, at) = floors.lowest_scored_position(&recipe, &occupancy, &rasters, &mut 0).expect("there is room");
            let is_near = |[x, y, _]: &[usize; 3]| x.abs_diff(at[0]) <= 5 && y.abs_diff(at[1]) <= 5;
            assert!(at[2] > 15 && !found.iter().any(is_near), "{at:?} is near one of {found:?}");
            floors.forbid_positions_around(at, 5);
            found.push(at);
        }
    }
}
