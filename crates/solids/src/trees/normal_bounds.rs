//! Bounds of the normals of the triangles below each node of a tree of boxes.

use glam::{DVec3, Vec3};

use super::node_box::TreeNodeLink;
use crate::mesh::triangle::Triangle;

/// Bounds of unit normals; single precision, grown by more than its rounding.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalBounds {
    middle: Vec3,
    half: Vec3,
}

impl NormalBounds {
    /// The least and the greatest dot product of a normal with `direction`, whose absolute values are `spread`.
    #[inline]
    pub fn dot_range(&self, direction: Vec3, spread: Vec3) -> (f32, f32) {
        let (middle, half) = (self.middle.dot(direction), self.half.dot(spread));
        (middle - half, middle + half)
    }
}

/// The bounds of the normals below every node; children are stored after their parents. `triangle` gives a triangle by its
/// place in the tree's order.
pub(super) fn normals_below(links: &[TreeNodeLink], triangle: impl Fn(usize) -> Triangle) -> Vec<NormalBounds> {
    const GROWN: f32 = 1e-6;
    // First the least and the greatest normal stand in the places of the middle and the half.
    let mut limits = vec![NormalBounds { middle: Vec3::INFINITY, half: Vec3::NEG_INFINITY }; links.len()];
    for (at, link) in links.iter().enumerate().rev() {
        let join = |a: NormalBounds, b: NormalBounds| NormalBounds {
            middle: a.middle.min(b.middle),
            half: a.half.max(b.half),
        };
        limits[at] = if link.is_leaf() {
            let own = |place: usize| match triangle(place).normal {
                // A triangle without a normal may face any direction.
                DVec3::ZERO => NormalBounds { middle: Vec3::NEG_ONE, half: Vec3::ONE },
                normal => NormalBounds { middle: normal.as_vec3(), half: normal.as_vec3() },
            };
            link.triangle_range().map(own).fold(limits[at], join)
        } else {
            join(limits[link.first_child()], limits[link.first_child() + 1])
        };
    }
    for bounds in &mut limits {
        let (min, max) = (bounds.middle, bounds.half);
        *bounds = NormalBounds { middle: (min + max) * 0.5, half: (max - min) * 0.5 + GROWN };
    }
    limits
}
