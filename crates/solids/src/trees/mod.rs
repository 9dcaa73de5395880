//! Trees of boxes over a mesh: the oriented boxes of the paper with its separating-axis test, and boxes along the axes for exact answers.
//!
//! A tree is built once for a mesh and never changes.

pub(super) mod box_tree;
pub(super) mod box_tree_build;
pub(super) mod extreme_points;
pub(super) mod node_box;
pub(super) mod normal_bounds;
pub(super) mod obb;
#[cfg(feature = "obb-tree")]
pub(super) mod obb_tree;
#[cfg(feature = "obb-tree")]
pub(super) mod separating_axis;
pub(super) mod tree_pair_walk;
pub(super) mod triangle_lanes;
pub(super) mod winding_number;
