//! Looks up four points at once in a distance grid, by vector instructions. Every distance comes out as it does for a
//! single point, to the last bit.

use glam::{BVec4A, Vec4};

use super::{
    super::point_block::{PointBlock, floor_values, to_indices},
    DistanceField,
};

/// Cells that contain the points of a block, per axis.
struct AxisCells {
    /// Least node of each cell.
    node: Vec4,
    /// Position in the cell, 0 to 1.
    part: Vec4,
    /// Distance to the grid, in cells.
    off: Vec4,
}

/// The cells of a block of points.
struct BlockCells {
    x: AxisCells,
    y: AxisCells,
    z: AxisCells,
}

impl BlockCells {
    /// Which of the points are outside the grid.
    #[inline(always)]
    fn are_outside(&self) -> BVec4A {
        self.x.off.cmpne(Vec4::ZERO) | self.y.off.cmpne(Vec4::ZERO) | self.z.off.cmpne(Vec4::ZERO)
    }
}

impl DistanceField {
    /// Signed distances of four points, mm, each as [`DistanceField::distance`] gives it. May give infinity for all of
    /// them if none is nearer than `reach`.
    #[inline(always)]
    pub(crate) fn block_distances(&self, points: &PointBlock, reach: f32) -> Vec4 {
        let cells = self.locate_cells(points);
        if self.edge_distance >= reach && cells.are_outside().all() {
            return Vec4::INFINITY;
        }
        self.distances_in(&cells)
    }

    /// Signed distances of four points, mm, each as [`DistanceField::distance`] gives it.
    #[inline(always)]
    pub(crate) fn distances(&self, points: &PointBlock) -> Vec4 {
        self.distances_in(&self.locate_cells(points))
    }

    /// Signed distances of four points, and how fast they can change at most, in mm per mm: outside the grid, both the distance
    /// to the grid and the one from there can.
    #[inline(always)]
    pub(crate) fn distances_and_rates(&self, points: &PointBlock) -> (Vec4, Vec4) {
        let cells = self.locate_cells(points);
        (self.distances_in(&cells), Vec4::select(cells.are_outside(), Vec4::splat(2.0), Vec4::ONE))
    }

    #[inline(always)]
    fn locate_cells(&self, points: &PointBlock) -> BlockCells {
        let axis = |at: Vec4, origin: f32, nodes: usize| {
            let raw = (at - origin) * self.inverse_step;
            let inner = raw.max(Vec4::ZERO).min(Vec4::splat(nodes as f32 - 1.001));
            let node = floor_values(inner);
            AxisCells { node, part: inner - node, off: raw - inner }
        };
        BlockCells {
            x: axis(points.x, self.origin.x, self.dims[0]),
            y: axis(points.y, self.origin.y, self.dims[1]),
            z: axis(points.z, self.origin.z, self.dims[2]),
        }
    }

    #[inline(always)]
    fn distances_in(&self, BlockCells { x, y, z }: &BlockCells) -> Vec4 {
        let beyond = (x.off * x.off + y.off * y.off + z.off * z.off).sqrt() * self.step;
        let at = (z.node * self.dims[1] as f32 + y.node) * self.dims[0] as f32 + x.node;
        let at = to_indices(at);
        let (row, layer) = (self.dims[0], self.dims[0] * self.dims[1]);
        let mix = |a: Vec4, b: Vec4, t: Vec4| a + (b - a) * t;
        let along_x = |offset: usize| {
            let (low, high) = self.node_pairs(at.map(|at| at + offset));
            mix(low, high, x.part)
        };
        let low = mix(along_x(0), along_x(row), y.part);
        let high = mix(along_x(layer), along_x(layer + row), y.part);
        mix(low, high, z.part) * self.scale + beyond
    }

    /// The nodes at four places, and the nodes after them.
    #[inline(always)]
    fn node_pairs(&self, at: [usize; 4]) -> (Vec4, Vec4) {
        let pairs = at.map(|at| {
            let pair = &self.nodes[at..at + 2];
            (i32::from(pair[1]) << 16) | i32::from(pair[0] as u16)
        });
        let low = pairs.map(|pair| ((pair << 16) >> 16) as f32);
        let high = pairs.map(|pair| (pair >> 16) as f32);
        (Vec4::from_array(low), Vec4::from_array(high))
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use proptest::prelude::*;

    use super::*;
    use crate::tests::testing::hollow;

    proptest! {
        #[test]
        fn four_points_have_the_distances_of_single_ones(
            c in proptest::array::uniform12(-40.0..40.0f32), middle in any::<bool>(), reach in -1.0..4.0f32,
        ) {
            let field = DistanceField::new(&hollow(30.0, 1.0), DVec3::splat(15.0), 2.0, 8_000, &|| false).unwrap();
            // Some near the surface, some outside the grid.
            let scale = if middle { 0.4 } else { 1.0 };
            let points: Vec<Vec3> = c.chunks_exact(3).map(|c| Vec3::from_slice(c) * scale).collect();
            let block = PointBlock::from_points(&points);
            let single: Vec<u32> = points.iter().map(|&p| field.distance(p).to_bits()).collect();
            prop_assert_eq!(&field.distances(&block).to_array().map(f32::to_bits)[..], &single[..]);
            let capped = field.block_distances(&block, reach).to_array();
            for (&point, capped) in points.iter().zip(capped) {
                let distance = field.distance(point);
                prop_assert!(capped == distance || (distance >= reach && capped == f32::INFINITY), "{distance} {capped}");
            }
        }
    }

    #[test]
    fn four_points_outside_the_grid_are_not_looked_up() {
        let field = DistanceField::new(&hollow(30.0, 1.0), DVec3::splat(15.0), 2.0, 8_000, &|| false).unwrap();
        let outside = PointBlock::from_points(&[Vec3::splat(30.0), Vec3::X * 40.0, Vec3::Y * -40.0, Vec3::Z * 25.0]);
        assert_eq!(field.block_distances(&outside, 2.0), Vec4::INFINITY);
        let inside = PointBlock::from_points(&[Vec3::splat(30.0), Vec3::ZERO]);
        assert!(field.block_distances(&inside, 2.0).is_finite());
    }
}
