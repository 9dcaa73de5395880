//! A voxel volume in bit columns: finds the lowest free position of a grown part, for all positions on a lattice.

use std::ops::Range;

use glam::{DMat3, DQuat, DVec3};
use solids::{Bounds, Pose};

use super::shape::PreparedShape;

/// Work of one lookup in a distance field, in columns compared.
const LOOKUP_STEPS: u64 = 3;

/// A part at one rotation, grown by half its clearance, as columns of bits.
#[derive(Debug, Clone)]
pub(crate) struct PartRaster {
    /// The rotation.
    pub(crate) rotation: DQuat,
    /// From the least corner of its bounds to its center, mm.
    pub(crate) corner_to_center: DVec3,
    /// Extents, mm.
    pub(crate) size: DVec3,
    /// Height in voxels, growth included.
    pub(crate) layers: usize,
    columns: Vec<BitColumn>,
    words: Vec<u64>,
}

#[derive(Debug, Clone, Copy)]
struct BitColumn {
    x: u32,
    y: u32,
    /// First layer with a voxel.
    low: u32,
    first: u32,
    count: u32,
}

impl PartRaster {
    /// Sets every voxel whose centre is nearer to the solid than half the clearance plus `grow` voxels. Adds the work to
    /// `steps`.
    pub(crate) fn new(
        shape: &PreparedShape,
        turn: DQuat,
        clearance_mm: f64,
        (pitch, grow): (f64, f64),
        steps: &mut u64,
    ) -> Self {
        let bounds = shape.tree.bounds_at(&Pose::new(turn, DVec3::ZERO));
        let corner_to_center = turn * shape.center - bounds.min;
        let cells = ((bounds.size() + clearance_mm) / pitch).ceil().as_ivec3().max(glam::IVec3::ONE);
        let reach = (0.5 * clearance_mm + grow * pitch) as f32;
        let back = DMat3::from_quat(turn).transpose();
        let first = back * (DVec3::splat(0.5 * pitch - 0.5 * clearance_mm) - corner_to_center);
        let (along_x, along_y, along_z) = (back.x_axis * pitch, back.y_axis * pitch, back.z_axis * pitch);
        let mut raster = Self {
            rotation: turn,
            corner_to_center,
            size: bounds.size(),
            layers: cells.z as usize,
            columns: vec![],
            words: vec![],
        };
        let mut bits = vec![0_u64; (cells.z as usize).div_ceil(64)];
        for x in 0..cells.x {
            for y in 0..cells.y {
                bits.fill(0);
                let line = first + along_x * f64::from(x) + along_y * f64::from(y);
                let mut z = 0;
                while z < cells.z {
                    *steps += LOOKUP_STEPS;
                    let distance = shape.distance_field.distance((line + along_z * f64::from(z)).as_vec3());
                    if distance < reach {
                        bits[z as usize / 64] |= 1 << (z % 64);
                        z += 1;
                    } else {
                        // Nothing is nearer than the distance: skip the voxels that cannot be reached, less one as a
                        // margin.
                        z += (((distance - reach) / pitch as f32) as i32 - 1).max(1);
                    }
                }
                raster.push_column(x as u32, y as u32, &bits);
            }
        }
        // Long columns collide first, so test them first.
        let weight = |c: &BitColumn| {
            let words = &raster.words[c.first as usize..(c.first + c.count) as usize];
            std::cmp::Reverse(words.iter().map(|w| w.count_ones()).sum::<u32>())
        };
        let mut columns = raster.columns.clone();
        columns.sort_by_cached_key(weight);
        // A selection spread over the longest columns collides sooner than neighbouring columns do.
        let step = (columns.len() / 7).max(1);
        raster.columns = (0..step).flat_map(|k| columns.iter().skip(k).step_by(step).copied()).collect();
        raster
    }

    /// Returns the raster with every column extended upwards by `lift` voxels.
    pub(crate) fn extended_upwards(mut self, lift: usize) -> Self {
        if lift == 0 {
            return self;
        }
        let columns = std::mem::take(&mut self.columns);
        let words = std::mem::take(&mut self.words);
        self.layers += lift;
        for part in columns {
            let own = &words[part.first as usize..(part.first + part.count) as usize];
            let mut bits = vec![0_u64; self.layers.div_ceil(64) + 1];
            for layer in (0..own.len() * 64).filter(|at| own[at / 64] >> (at % 64) & 1 == 1) {
                set_bits(&mut bits, part.low as usize + layer, lift);
            }
            self.push_column(part.x, part.y, &bits);
        }
        self
    }

    fn push_column(&mut self, x: u32, y: u32, bits: &[u64]) {
        let Some(low) = bits.iter().position(|&w| w != 0) else { return };
        let low = low * 64 + bits[low].trailing_zeros() as usize;
        let last = bits.iter().rposition(|&w| w != 0).unwrap_or(0);
        let first = self.words.len() as u32;
        let (word, shift) = (low / 64, low % 64);
        for at in word..=last {
            let next = bits.get(at + 1).copied().unwrap_or(0);
            self.words.push(if shift == 0 { bits[at] } else { bits[at] >> shift | next << (64 - shift) });
        }
        while self.words.len() as u32 > first + 1 && self.words.last() == Some(&0) {
            self.words.pop();
        }
        self.columns.push(BitColumn { x, y, low: low as u32, first, count: self.words.len() as u32 - first });
    }
}

/// Sets a bit and the `lift` bits above it that exist.
fn set_bits(bits: &mut [u64], layer: usize, lift: usize) {
    for at in layer..=layer + lift {
        if let Some(word) = bits.get_mut(at / 64) {
            *word |= 1 << (at % 64);
        }
    }
}

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
        let free = self.room - raster.size - 2.0 * super::fit_check::WALL_SPARE_MM;
        free.cmpge(DVec3::ZERO).all().then(|| (free / self.pitch).to_array().map(|n| n as usize + 1))
    }

    /// Position of a raster's center at a lattice position, mm.
    pub(crate) fn center_at(&self, raster: &PartRaster, [x, y, z]: [usize; 3]) -> DVec3 {
        let corner = DVec3::new(x as f64, y as f64, z as f64) * self.pitch + super::fit_check::WALL_SPARE_MM;
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

    /// The lowest of `layers` at which the raster is free at (x, y). Adds the columns compared to `steps`.
    pub(crate) fn lowest_free_layer(
        &self,
        raster: &PartRaster,
        [x, y]: [usize; 2],
        layers: Range<usize>,
        steps: &mut u64,
    ) -> Option<usize> {
        let mut layer = layers.start;
        let (mut clear, mut at) = (0, 0);
        *steps += 1;
        while layer < layers.end {
            *steps += 1;
            if clear == raster.columns.len() || layer >= self.top {
                return Some(layer);
            }
            let part = &raster.columns[at];
            let column = ((x + part.x as usize) * self.cells_y + y + part.y as usize) * self.words;
            let words = &raster.words[part.first as usize..(part.first + part.count) as usize];
            let mut hits = words.iter().enumerate().map(|(k, &word)| {
                let low = layer + part.low as usize + 64 * k;
                (word, word & self.bits_at(column, low))
            });
            match hits.find(|&(_, hit)| hit != 0) {
                None => {
                    clear += 1;
                    at = if at + 1 == raster.columns.len() { 0 } else { at + 1 };
                }
                // The run of voxels that meets an occupied voxel collides until it is above it as a whole.
                Some((word, hit)) => {
                    clear = 0;
                    layer += (word << hit.leading_zeros()).leading_ones() as usize;
                }
            }
        }
        None
    }

    /// Fills the raster's voxels at a lattice position.
    pub(crate) fn fill_raster(&mut self, raster: &PartRaster, [x, y, z]: [usize; 3]) {
        for part in &raster.columns {
            let column = ((x + part.x as usize) * self.cells_y + y + part.y as usize) * self.words;
            let words = &raster.words[part.first as usize..(part.first + part.count) as usize];
            for (k, &word) in words.iter().enumerate() {
                let low = z + part.low as usize + 64 * k;
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
        let back = pose.inverse();
        let least = ((bounds.min - reach_mm + half_mm) / self.pitch).floor().max(DVec3::ZERO).as_usizevec3();
        let most = ((bounds.max + reach_mm + half_mm) / self.pitch).ceil().max(DVec3::ZERO).as_usizevec3();
        let cells_x = self.bits.len() / (self.cells_y * self.words);
        for x in least.x..most.x.min(cells_x) {
            for y in least.y..most.y.min(self.cells_y) {
                for z in least.z..most.z.min(self.words * 64) {
                    let middle = DVec3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * self.pitch - half_mm;
                    if f64::from(shape.distance_field.distance((back.transform_point(middle) - shape.center).as_vec3()))
                        < reach_mm
                    {
                        let column = (x * self.cells_y + y) * self.words;
                        set_bits(&mut self.bits[column..column + self.words], z, self.lift);
                        self.top = self.top.max(z + 1 + self.lift);
                    }
                }
            }
        }
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
        ) {
            let mut grid = OccupancyGrid::new(DVec3::new(4.0, 1.0, 400.0), 0.0, 1.0, 0);
            for (x, layer, lift) in occupied {
                let column = x * grid.cells_y * grid.words;
                set_bits(&mut grid.bits[column..column + grid.words], layer, lift);
                grid.top = grid.top.max(layer + lift + 1);
            }
            // Dense columns have short gaps, sparse ones single voxels.
            let columns: Vec<[u128; 2]> = columns.into_iter().map(|c| [c[0] & thin[0], c[1] | thin[1]]).collect();
            let mut raster = PartRaster {
                rotation: DQuat::IDENTITY,
                corner_to_center: DVec3::ZERO,
                size: DVec3::ONE,
                layers: 256,
                columns: Vec::new(),
                words: Vec::new(),
            };
            for (x, column) in columns.iter().enumerate() {
                let words = column.map(|half| [half as u64, (half >> 64) as u64]).concat();
                raster.push_column(x as u32, 0, &words);
            }
            for end in [120, 400] {
                prop_assert_eq!(
                    grid.lowest_free_layer(&raster, [0, 0], 0..end, &mut 0),
                    lowest_layer_by_testing_all(&grid, &columns, [0, 0], end)
                );
            }
        }
    }
}
