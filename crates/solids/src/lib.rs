#![doc = include_str!("../README.md")]
// Pure solids: poses, meshes, boxes and the distance between them. Millimetres everywhere; knows nothing of flowers.

mod bounds;
mod box_tree;
mod box_tree_build;
mod clearance;
mod contact;
mod defects;
mod direction_sweep;
mod eigen;
mod equal_pieces;
mod extreme_points;
mod local_order;
mod mesh;
mod mesh_builder;
mod mesh_serde;
mod node_box;
mod normal_bounds;
mod obb;
#[cfg(feature = "obb-tree")]
mod obb_tree;
mod pose;
#[cfg(feature = "obb-tree")]
mod separating_axis;
mod shells;
mod sliding_distance;
mod tree_pair_walk;
mod triangle;
mod triangle_lanes;
mod weld;
mod winding_number;

#[cfg(test)]
mod clearance_tests;
#[cfg(any(test, feature = "fixtures"))]
pub mod fixtures;
#[cfg(test)]
mod speed_tests;
#[cfg(test)]
mod sweep_tests;

pub use bounds::Bounds;
pub use clearance::ClearanceTree;
pub use contact::SurfaceContact;
pub use defects::MeshDefects;
pub use extreme_points::ExtremePoints;
pub use mesh::{Mesh, MeshError};
pub use mesh_builder::MeshBuilder;
pub use obb::Obb;
#[cfg(feature = "obb-tree")]
pub use obb_tree::ObbTree;
pub use pose::{Pose, PoseError};
pub use triangle::closest_point;
