//! A node of the tree of spheres around the points of a part.

use glam::Vec3;

/// A sphere around some of the points. Nodes are stored in depth-first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BoundingSphere {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    /// The next node to visit when this subtree is skipped.
    pub(crate) next_sibling: u32,
    /// The first of its own points, and their number; 0 if they are in smaller spheres.
    pub(crate) first: u32,
    pub(crate) count: u32,
}
