//! The node of a tree of boxes: the box in single precision, grown by its rounding, and what is below it.

use glam::Vec3A;

/// Bits of a link that hold the number of a leaf's triangles.
const COUNT_BITS: u32 = 3;

/// A box; single precision, so that a test of two of them takes a few vector instructions. It is never smaller than what
/// is in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TreeNodeBox {
    /// Middle of the box, mm.
    pub center: Vec3A,
    /// Half the edge lengths, mm.
    pub half: Vec3A,
}

impl TreeNodeBox {
    /// The box between two corners.
    pub fn between_corners(min: Vec3A, max: Vec3A) -> Self {
        let center = (min + max) * 0.5;
        let half = (max - center).max(center - min);
        // Above the rounding of the two subtractions.
        Self { center, half: half + half * 1.2e-7 + f32::MIN_POSITIVE }
    }
}

/// What is below a node: the triangles of a leaf, or two children, which are stored next to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TreeNodeLink(u32);

impl TreeNodeLink {
    /// Greatest number of triangles of a leaf.
    pub const MAX_COUNT: usize = (1 << COUNT_BITS) - 1;
    /// Nodes and triangles of a tree must be fewer than this.
    pub const MAX_FIRST: usize = 1 << (32 - COUNT_BITS);

    /// The `count` triangles from `first` on in the tree's order.
    pub fn to_triangles(first: usize, count: usize) -> Self {
        debug_assert!(first < Self::MAX_FIRST && (1..=Self::MAX_COUNT).contains(&count));
        Self((first as u32) << COUNT_BITS | count as u32)
    }

    /// Two children, of which `first` is the first.
    pub fn to_children(first: usize) -> Self {
        debug_assert!(first < Self::MAX_FIRST);
        Self((first as u32) << COUNT_BITS)
    }

    /// The same link in a list in which nodes come `nodes` later.
    pub fn shifted_by(self, nodes: usize) -> Self {
        if self.is_leaf() { self } else { Self::to_children(self.first_child() + nodes) }
    }

    /// Whether the node has triangles instead of children.
    #[inline]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::MAX_COUNT as u32 != 0
    }

    /// The first child of an inner node.
    #[inline]
    pub fn first_child(self) -> usize {
        (self.0 >> COUNT_BITS) as usize
    }

    /// The triangles of a leaf, in the tree's order.
    #[inline]
    pub fn triangle_range(self) -> std::ops::Range<usize> {
        let first = (self.0 >> COUNT_BITS) as usize;
        first..first + (self.0 as usize & Self::MAX_COUNT)
    }
}
