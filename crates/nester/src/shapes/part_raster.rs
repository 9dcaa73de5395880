//! A part at one rotation as voxels: bit columns along z, for positions one by one and for blocks of positions at once.

use std::ops::Range;

use glam::{DMat3, DQuat, DVec3, Vec4};
use solids::{Bounds, Pose};

use super::{
    distance_field::DistanceField,
    point_block::{BLOCK_POINTS, PointBlock},
    shape::PreparedShape,
};

/// Work of a lookup of four points in a distance field, in columns compared.
const LOOKUP_STEPS: u64 = 4;
/// Number of levels of a raster: single positions, and blocks of 2 x 2 and 4 x 4 positions.
pub(crate) const RASTER_LEVELS: usize = 3;

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
    /// At level 0 the voxels of the part; at level n the voxels that it covers at every position of a block of 2^n x 2^n
    /// positions. If these collide, the part collides at all positions of the block. A level without voxels, and all
    /// after it, are left out.
    pub(crate) levels: Vec<VoxelColumns>,
}

/// Voxels as columns along z. Columns without voxels are left out.
#[derive(Debug, Clone, Default)]
pub(crate) struct VoxelColumns {
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

/// The lattice of voxel centres, in the frame of a distance field.
pub(crate) struct VoxelLattice {
    /// The centre of the first voxel, mm.
    first: DVec3,
    /// From one centre to the next one along x, y and z, mm.
    along: DMat3,
}

/// All voxels of a box, as bit columns along z.
struct VoxelBox {
    /// Number of columns along x and y.
    extent: [usize; 2],
    /// Words of a column.
    words: usize,
    bits: Vec<u64>,
}

impl VoxelLattice {
    /// The lattice with this edge of a voxel whose first voxel centre is at `first`, both in mm in the build's frame;
    /// the shape stands at `pose`.
    pub(crate) fn new(shape: &PreparedShape, pose: &Pose, first: DVec3, pitch: f64) -> Self {
        let back = pose.inverse();
        Self { first: back.transform_point(first) - shape.center, along: back.rotation_matrix() * pitch }
    }

    /// Passes to `visit` all voxels with indices in `cells` whose centre is nearer to the solid than `reach_mm`: the
    /// column, and a range of layers. Returns the number of lookups of four points.
    pub(crate) fn visit_solid_voxels(
        &self,
        field: &DistanceField,
        cells: [Range<usize>; 3],
        reach_mm: f64,
        mut visit: impl FnMut([usize; 2], Range<usize>),
    ) -> u64 {
        let DMat3 { x_axis, y_axis, z_axis } = self.along;
        let (reach, pitch, mut lookups) = (reach_mm as f32, z_axis.length() as f32, 0);
        let up = z_axis.as_vec3();
        let [xs, ys, zs] = cells;
        for x in xs {
            for y in ys.clone().step_by(BLOCK_POINTS) {
                let lines: [_; BLOCK_POINTS] =
                    std::array::from_fn(|lane| (self.first + x_axis * x as f64 + y_axis * (y + lane) as f64).as_vec3());
                let lines = PointBlock::from_points(&lines);
                let mut z = zs.start;
                while z < zs.end {
                    let at = z as f32;
                    let points = PointBlock { x: lines.x + up.x * at, y: lines.y + up.y * at, z: lines.z + up.z * at };
                    let (distances, rates) = field.distances_and_rates(&points);
                    let beyond: Vec4 = distances - reach;
                    lookups += 1;
                    // The next voxels are on the same side of the surface, less one as a margin.
                    let spare = (beyond.abs() / rates).min_element();
                    let same = ((spare / pitch) as usize).saturating_sub(1).max(1);
                    let layers = z..(z + same).min(zs.end);
                    for lane in (0..BLOCK_POINTS.min(ys.end - y)).filter(|&lane| beyond[lane] < 0.0) {
                        visit([x, y + lane], layers.clone());
                    }
                    z = layers.end;
                }
            }
        }
        lookups
    }
}

impl PartRaster {
    /// Sets every voxel whose centre is nearer to the solid than half the clearance plus `grow` voxels, and the `lift`
    /// voxels above it. Adds the work to `steps`.
    pub(crate) fn new(
        shape: &PreparedShape,
        rotation: DQuat,
        clearance_mm: f64,
        (pitch, grow, lift): (f64, f64, usize),
        steps: &mut u64,
    ) -> Self {
        let bounds: Bounds = shape.tree.bounds_at(&Pose::new(rotation, DVec3::ZERO));
        let cells = ((bounds.size() + clearance_mm) / pitch).ceil().max(DVec3::ONE).as_usizevec3();
        let first = bounds.min + 0.5 * pitch - 0.5 * clearance_mm;
        let lattice = VoxelLattice::new(shape, &Pose::new(rotation, DVec3::ZERO), first, pitch);
        let layers = cells.z + lift;
        let mut voxels = VoxelBox::new([cells.x, cells.y], layers);
        let reach_mm = 0.5 * clearance_mm + grow * pitch;
        let ranges = [0..cells.x, 0..cells.y, 0..cells.z];
        *steps += LOOKUP_STEPS
            * lattice.visit_solid_voxels(&shape.distance_field, ranges, reach_mm, |[x, y], layers| {
                set_bits(voxels.column_mut([x, y]), layers.start..layers.end + lift);
            });
        let mut levels = vec![voxels.to_columns()];
        while levels.len() < RASTER_LEVELS {
            voxels = voxels.eroded(1 << (levels.len() - 1));
            let columns = voxels.to_columns();
            if columns.columns.is_empty() {
                break;
            }
            levels.push(columns);
        }
        let corner_to_center = rotation * shape.center - bounds.min;
        Self { rotation, corner_to_center, size: bounds.size(), layers, levels }
    }
}

impl VoxelBox {
    /// A box without voxels.
    fn new(extent: [usize; 2], layers: usize) -> Self {
        let words = layers.div_ceil(64);
        Self { extent, words, bits: vec![0; extent[0] * extent[1] * words] }
    }

    fn column_range(&self, [x, y]: [usize; 2]) -> Range<usize> {
        let first = (x * self.extent[1] + y) * self.words;
        first..first + self.words
    }

    fn column_mut(&mut self, at: [usize; 2]) -> &mut [u64] {
        let range = self.column_range(at);
        &mut self.bits[range]
    }

    /// The voxels that remain if the box is laid over itself, shifted by 0 and `shift` columns along x and y.
    fn eroded(&self, shift: usize) -> Self {
        let mut eroded = Self { bits: vec![0; self.bits.len()], ..*self };
        for x in shift..self.extent[0] {
            for y in shift..self.extent[1] {
                let laid = [[x, y], [x - shift, y], [x, y - shift], [x - shift, y - shift]];
                let laid = laid.map(|at| &self.bits[self.column_range(at)]);
                for (word, bits) in eroded.column_mut([x, y]).iter_mut().enumerate() {
                    *bits = laid.iter().fold(u64::MAX, |all, column| all & column[word]);
                }
            }
        }
        eroded
    }

    /// The columns in the order in which to test them.
    fn to_columns(&self) -> VoxelColumns {
        let mut found = VoxelColumns::default();
        for x in 0..self.extent[0] {
            for y in 0..self.extent[1] {
                found.push_column([x, y], &self.bits[self.column_range([x, y])]);
            }
        }
        // Long columns collide first, so test them first.
        let length = |c: &BitColumn| std::cmp::Reverse(found.words_of(c).iter().map(|w| w.count_ones()).sum::<u32>());
        let mut columns = found.columns.clone();
        columns.sort_by_cached_key(length);
        // A selection spread over the longest columns collides sooner than neighbouring columns do.
        let step = (columns.len() / 7).max(1);
        found.columns = (0..step).flat_map(|k| columns.iter().skip(k).step_by(step).copied()).collect();
        found
    }
}

impl VoxelColumns {
    /// Columns with these bits, for tests.
    #[cfg(test)]
    pub(crate) fn of_bits(columns: impl Iterator<Item = ([usize; 2], Vec<u64>)>) -> Self {
        let mut made = Self::default();
        columns.for_each(|(at, bits)| made.push_column(at, &bits));
        made
    }

    fn push_column(&mut self, [x, y]: [usize; 2], bits: &[u64]) {
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
        let count = self.words.len() as u32 - first;
        self.columns.push(BitColumn { x: x as u32, y: y as u32, low: low as u32, first, count });
    }

    fn words_of(&self, column: &BitColumn) -> &[u64] {
        &self.words[column.first as usize..(column.first + column.count) as usize]
    }

    /// Number of columns.
    pub(crate) fn len(&self) -> usize {
        self.columns.len()
    }

    /// One of the columns: its place, its first layer, and its voxels from there on; the last word is not 0.
    #[inline]
    pub(crate) fn column(&self, at: usize) -> ([usize; 2], usize, &[u64]) {
        let column = &self.columns[at];
        ([column.x as usize, column.y as usize], column.low as usize, self.words_of(column))
    }
}

/// Sets the bits in a range that exist.
pub(crate) fn set_bits(bits: &mut [u64], range: Range<usize>) {
    let end = range.end.min(bits.len() * 64);
    let mut at = range.start;
    while at < end {
        let last = end.min((at / 64 + 1) * 64);
        let count = last - at;
        bits[at / 64] |= (u64::MAX >> (64 - count)) << (at % 64);
        at = last;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{
        OrientationRule,
        tests::{
            nester_tests::{asked, item},
            testing::{cells, coarsely_prepared, range},
        },
    };

    fn is_set(columns: &VoxelColumns, [x, y]: [usize; 2], layer: usize) -> bool {
        (0..columns.len()).map(|at| columns.column(at)).any(|(place, low, words)| {
            let bit = layer.wrapping_sub(low);
            place == [x, y] && layer >= low && words.get(bit / 64).is_some_and(|word| word >> (bit % 64) & 1 == 1)
        })
    }

    proptest! {
        #[test]
        fn a_range_of_bits_is_set_and_no_other(start in 0..150_usize, count in 0..150_usize) {
            let mut bits = [0_u64; 3];
            set_bits(&mut bits, start..start + count);
            for at in 0..192 {
                prop_assert_eq!(bits[at / 64] >> (at % 64) & 1 == 1, (start..start + count).contains(&at));
            }
        }

        #[test]
        fn a_voxel_of_a_level_is_covered_from_every_position_of_its_block(
            bits in prop::collection::vec(any::<u64>(), 7 * 6 * 2), more in prop::collection::vec(any::<u64>(), 7 * 6 * 2),
        ) {
            let bits = bits.iter().zip(&more).map(|(one, other)| one | other).collect();
            let whole = VoxelBox { extent: [7, 6], words: 2, bits };
            let twice = whole.eroded(1);
            let four = twice.eroded(2);
            let single = whole.to_columns();
            for (eroded, block) in [(&twice, 2), (&four, 4)] {
                let columns = eroded.to_columns();
                for (x, y, layer) in (0..7).flat_map(|x| (0..6).map(move |y| (x, y, (x * 31 + y * 17) % 128))) {
                    let covered = |dx: usize, dy: usize| x >= dx && y >= dy && is_set(&single, [x - dx, y - dy], layer);
                    let all = (0..block).all(|dx| (0..block).all(|dy| covered(dx, dy)));
                    prop_assert_eq!(is_set(&columns, [x, y], layer), all);
                }
            }
        }
    }

    #[test]
    fn a_raster_has_every_voxel_near_the_solid_and_the_lift_above_it() {
        // Far from the corner of an L, the distance to the grid and the one from there differ most.
        let long = range([0; 3], [20, 2, 2]).chain(range([0; 3], [2, 20, 2])).chain(range([0; 3], [2, 2, 20]));
        let instance = asked(DVec3::splat(200.0), 1.0, vec![item(cells(5.0, long), 1, OrientationRule::Free)]);
        let prepared = coarsely_prepared(&instance);
        let shape = &prepared.prepared_item(0).shape;
        let (pitch, grow, clearance_mm) = (1.2, 0.45, 1.0);
        for (turn, lift) in (0..20).map(|at| (DVec3::new(0.37, 0.83, 1.7) * f64::from(at), at as usize % 3)) {
            let rotation = DQuat::from_euler(glam::EulerRot::XYZ, turn.x, turn.y, turn.z);
            let raster = PartRaster::new(shape, rotation, clearance_mm, (pitch, grow, lift), &mut 0);
            let corner = rotation * shape.center - raster.corner_to_center;
            let is_near = |cell: [usize; 3]| {
                let voxel = DVec3::from_array(cell.map(|at| at as f64)) + 0.5;
                let point = rotation.conjugate() * (corner + voxel * pitch - 0.5 * clearance_mm);
                f64::from(shape.distance_field.distance((point - shape.center).as_vec3()))
                    < 0.5 * clearance_mm + grow * pitch
            };
            let [nx, ny] = [raster.size.x, raster.size.y].map(|size| ((size + clearance_mm) / pitch).ceil() as usize);
            let (mut differ, mut count) = (0, 0);
            for (x, y) in (0..nx).flat_map(|x| (0..ny).map(move |y| (x, y))) {
                let near: Vec<bool> = (0..raster.layers - lift).map(|z| is_near([x, y, z])).collect();
                let column = (0..raster.levels[0].len()).find(|&at| raster.levels[0].column(at).0 == [x, y]);
                for z in 0..raster.layers {
                    let wanted = (z.saturating_sub(lift)..=z).any(|z| near.get(z) == Some(&true));
                    let is_set = column.is_some_and(|at| {
                        let (_, low, words) = raster.levels[0].column(at);
                        z >= low && words.get((z - low) / 64).is_some_and(|word| word >> ((z - low) % 64) & 1 == 1)
                    });
                    differ += usize::from(wanted != is_set);
                    count += usize::from(wanted);
                }
            }
            // Single precision may round a distance to the other side.
            assert!(count > 2000 && differ <= 2, "{differ} of {count}");
        }
    }
}
