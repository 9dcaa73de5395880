//! The build volume as voxels in bit columns: finds the lowest free position of a part, and fills the voxels of solids.

use std::ops::Range;

use glam::DVec3;
use solids::{Bounds, Pose};

use crate::shapes::{
    part_raster::{PartRaster, VoxelColumns, VoxelLattice, set_bits},
    shape::PreparedShape,
};

/// The build volume as bit columns. Its lattice starts half a clearance outside the walls.
#[derive(Debug, Clone)]
pub(crate) struct OccupancyGrid {
    room: DVec3,
    /// Edge of a voxel, mm.
    pub(crate) pitch: f64,
    cells_y: usize,
    words: usize,
    bits: Vec<u64>,
    /// Voxels by which solids are extended upwards.
    lift: usize,
    /// All voxels at and above this layer are free.
    pub(crate) top: usize,
}

impl OccupancyGrid {
    /// Creates an empty volume; `clearance_mm` is the greatest clearance of any item.
    pub(crate) fn new(room: DVec3, clearance_mm: f64, pitch: f64, lift: usize) -> Self {
        let cells = ((room + clearance_mm) / pitch).ceil().as_ivec3() + 2;
        let words = (cells.z as usize).div_ceil(64) + 1;
        let bits = vec![0; cells.x as usize * cells.y as usize * words];
        Self { room, pitch, cells_y: cells.y as usize, words, bits, lift, top: 0 }
    }

    /// Number of lattice positions along each axis at which a raster is inside the walls.
    pub(crate) fn lattice_positions(&self, raster: &PartRaster) -> Option<[usize; 3]> {
        let free = self.room - raster.size - 2.0 * crate::problem::fit_check::WALL_SPARE_MM;
        free.cmpge(DVec3::ZERO).all().then(|| (free / self.pitch).to_array().map(|n| n as usize + 1))
    }

    /// Position of a raster's center at a lattice position, mm.
    pub(crate) fn center_at(&self, raster: &PartRaster, [x, y, z]: [usize; 3]) -> DVec3 {
        let corner = DVec3::new(x as f64, y as f64, z as f64) * self.pitch + crate::problem::fit_check::WALL_SPARE_MM;
        corner + raster.corner_to_center
    }

    #[inline]
    fn bits_at(&self, column: usize, layer: usize) -> u64 {
        let (word, shift) = (layer / 64, layer % 64);
        if word + 1 >= self.words {
            return if word < self.words { self.bits[column + word] >> shift } else { 0 };
        }
        let (low, high) = (self.bits[column + word], self.bits[column + word + 1]);
        if shift == 0 { low } else { low >> shift | high << (64 - shift) }
    }

    /// The lowest of `layers` at which the columns are free at (x, y). The test begins with the column `first`; sets it to
    /// the last one that collided, which is likely to collide at the next position too. Adds the columns compared to
    /// `steps`.
    pub(crate) fn lowest_free_layer(
        &self,
        part: &VoxelColumns,
        [x, y]: [usize; 2],
        layers: Range<usize>,
        first: &mut usize,
        steps: &mut u64,
    ) -> Option<usize> {
        let mut layer = layers.start;
        let (mut clear, mut at) = (0, *first);
        *steps += 1;
        while layer < layers.end {
            *steps += 1;
            if clear == part.len() || layer >= self.top {
                return Some(layer);
            }
            let ([part_x, part_y], low, words) = part.column(at);
            let column = ((x + part_x) * self.cells_y + y + part_y) * self.words;
            let mut hits = words.iter().enumerate().map(|(k, &word)| {
                let low = layer + low + 64 * k;
                (word, word & self.bits_at(column, low))
            });
            match hits.find(|&(_, hit)| hit != 0) {
                None => {
                    clear += 1;
                    at = if at + 1 == part.len() { 0 } else { at + 1 };
                }
                // The run of voxels that meets an occupied voxel collides until it is above it as a whole.
                Some((word, hit)) => {
                    clear = 0;
                    *first = at;
                    layer += (word << hit.leading_zeros()).leading_ones() as usize;
                }
            }
        }
        None
    }

    /// Fills the raster's voxels at a lattice position.
    pub(crate) fn fill_raster(&mut self, raster: &PartRaster, [x, y, z]: [usize; 3]) {
        let part = &raster.levels[0];
        for at in 0..part.len() {
            let ([part_x, part_y], low, words) = part.column(at);
            let column = ((x + part_x) * self.cells_y + y + part_y) * self.words;
            for (k, &word) in words.iter().enumerate() {
                let low = z + low + 64 * k;
                let (at, shift) = (low / 64, low % 64);
                if at < self.words {
                    self.bits[column + at] |= word << shift;
                }
                if shift > 0 && at + 1 < self.words {
                    self.bits[column + at + 1] |= word >> (64 - shift);
                }
            }
        }
        self.top = self.top.max(z + raster.layers);
    }

    /// Fills every voxel nearer than `reach_mm` to a solid (in the build frame). The lattice starts `half_mm` outside
    /// the walls.
    pub(crate) fn fill_solid(
        &mut self,
        shape: &PreparedShape,
        pose: &Pose,
        bounds: &Bounds,
        reach_mm: f64,
        half_mm: f64,
    ) {
        let least = ((bounds.min - reach_mm + half_mm) / self.pitch).floor().max(DVec3::ZERO).as_usizevec3();
        let most = ((bounds.max + reach_mm + half_mm) / self.pitch).ceil().max(DVec3::ZERO).as_usizevec3();
        let cells_x = self.bits.len() / (self.cells_y * self.words);
        let cells =
            [least.x..most.x.min(cells_x), least.y..most.y.min(self.cells_y), least.z..most.z.min(self.words * 64)];
        let lattice = VoxelLattice::new(shape, pose, DVec3::splat(0.5 * self.pitch - half_mm), self.pitch);
        let Self { bits, top, lift, cells_y, words, .. } = self;
        lattice.visit_solid_voxels(&shape.distance_field, cells, reach_mm, |[x, y], layers| {
            let column = (x * *cells_y + y) * *words;
            let end = layers.end + *lift;
            set_bits(&mut bits[column..column + *words], layers.start..end);
            *top = end.max(*top);
        });
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Free layers of the columns of a part, by testing every layer and voxel.
    fn lowest_layer_by_testing_all(
        grid: &OccupancyGrid,
        columns: &[[u128; 2]],
        [x, y]: [usize; 2],
        end: usize,
    ) -> Option<usize> {
        let is_set = |bits: &[u128; 2], at: usize| bits[at / 128] >> (at % 128) & 1 == 1;
        let is_free = |layer: &usize| {
            (0..columns.len()).all(|at| {
                let column = ((x + at) * grid.cells_y + y) * grid.words;
                let occupied = |low: usize| grid.bits_at(column, layer + low) & 1 == 1;
                (0..256).all(|low| !is_set(&columns[at], low) || !occupied(low))
            })
        };
        (0..end).find(is_free)
    }

    proptest! {
        #[test]
        fn the_lowest_free_layer_is_the_one_that_testing_all_of_them_finds(
            columns in prop::collection::vec([any::<u128>(), any::<u128>()], 1..4),
            thin in [any::<u128>(), any::<u128>()],
            occupied in prop::collection::vec((0_usize..4, 0_usize..300, 1_usize..40), 0..12),
            first in 0_usize..3,
        ) {
            let mut grid = OccupancyGrid::new(DVec3::new(4.0, 1.0, 400.0), 0.0, 1.0, 0);
            for (x, layer, lift) in occupied {
                let column = x * grid.cells_y * grid.words;
                set_bits(&mut grid.bits[column..column + grid.words], layer..layer + lift + 1);
                grid.top = grid.top.max(layer + lift + 1);
            }
            // Dense columns have short gaps, sparse ones single voxels.
            let columns: Vec<[u128; 2]> = columns.into_iter().map(|c| [c[0] & thin[0], c[1] | thin[1]]).collect();
            let places = (0..columns.len()).map(|x| [x, 0]);
            let part = VoxelColumns::of_bits(places.zip(&columns).map(|(at, column)| {
                (at, column.map(|half| [half as u64, (half >> 64) as u64]).concat())
            }));
            for end in [120, 400] {
                prop_assert_eq!(
                    grid.lowest_free_layer(&part, [0, 0], 0..end, &mut (first % columns.len()), &mut 0),
                    lowest_layer_by_testing_all(&grid, &columns, [0, 0], end)
                );
            }
        }
    }
}
