//! Four points side by side, for vector instructions. Every coordinate comes out as it would for a single point.

use glam::{Mat3, Vec3, Vec4};

/// Whole numbers below this are exact in single precision, and the last bits of their sum with it.
pub(crate) const EXACT_INTEGERS: f32 = 8_388_608.0;

/// The greatest whole numbers that are not above four values from 0 to [`EXACT_INTEGERS`].
#[inline(always)]
pub(crate) fn floor_values(values: Vec4) -> Vec4 {
    let nearest = (values + EXACT_INTEGERS) - EXACT_INTEGERS;
    nearest - Vec4::select(nearest.cmpgt(values), Vec4::ONE, Vec4::ZERO)
}

/// Four whole numbers from 0 to [`EXACT_INTEGERS`] as indices.
#[inline(always)]
pub(crate) fn to_indices(values: Vec4) -> [usize; BLOCK_POINTS] {
    (values + EXACT_INTEGERS).to_array().map(|value| (value.to_bits() - EXACT_INTEGERS.to_bits()) as usize)
}

/// Points of a block.
pub(crate) const BLOCK_POINTS: usize = 4;

/// Four points: a vector of four for each coordinate, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointBlock {
    pub(crate) x: Vec4,
    pub(crate) y: Vec4,
    pub(crate) z: Vec4,
}

impl PointBlock {
    /// The first points of a slice; the last of them again where there are fewer than four.
    ///
    /// # Panics
    /// When there is no point.
    pub(crate) fn from_points(points: &[Vec3]) -> Self {
        let point = [0, 1, 2, 3].map(|lane: usize| points[lane.min(points.len() - 1)]);
        Self {
            x: Vec4::from_array(point.map(|p| p.x)),
            y: Vec4::from_array(point.map(|p| p.y)),
            z: Vec4::from_array(point.map(|p| p.z)),
        }
    }

    /// One of the points.
    #[inline(always)]
    pub(crate) fn point(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

/// A rigid motion of blocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockMotion {
    rotation: Mat3,
    shift: Vec3,
}

impl BlockMotion {
    /// A rotation, then a shift in mm.
    pub(crate) fn new(rotation: Mat3, shift: Vec3) -> Self {
        Self { rotation, shift }
    }

    /// Moves one point.
    #[inline(always)]
    pub(crate) fn move_point(&self, point: Vec3) -> Vec3 {
        self.rotation * point + self.shift
    }

    /// Moves a block.
    #[inline(always)]
    pub(crate) fn move_block(&self, block: &PointBlock) -> PointBlock {
        let Mat3 { x_axis, y_axis, z_axis } = self.rotation;
        let row = |x: f32, y: f32, z: f32, shift: f32| block.x * x + block.y * y + block.z * z + shift;
        PointBlock {
            x: row(x_axis.x, y_axis.x, z_axis.x, self.shift.x),
            y: row(x_axis.y, y_axis.y, z_axis.y, self.shift.y),
            z: row(x_axis.z, y_axis.z, z_axis.z, self.shift.z),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_block_moves_as_its_points_do(
            turn in proptest::array::uniform3(-3.0..3.0f32), c in proptest::array::uniform12(-90.0..90.0f32), count in 1..=4usize,
        ) {
            let points: Vec<Vec3> = c.chunks_exact(3).map(Vec3::from_slice).take(count).collect();
            let motion = BlockMotion::new(Mat3::from_quat(Quat::from_scaled_axis(turn.into())), Vec3::new(3.1, -7.7, 0.4));
            let moved = motion.move_block(&PointBlock::from_points(&points));
            for lane in 0..BLOCK_POINTS {
                prop_assert_eq!(moved.point(lane), motion.move_point(points[lane.min(count - 1)]));
            }
        }
    }
}
