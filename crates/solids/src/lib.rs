#![doc = include_str!("../README.md")]
// Pure solids: poses, meshes, boxes and the distance between them. Millimetres everywhere; knows nothing of flowers.

mod bounds;
mod box_tree;
mod clearance;
mod contact;
mod defects;
mod eigen;
mod equal;
mod extremes;
mod inside;
mod mesh;
mod mesh_serde;
mod obb;
#[cfg(feature = "obb-tree")]
mod obb_tree;
mod pose;
#[cfg(feature = "obb-tree")]
mod separating_axis;
mod shells;
mod slide;
mod sweep;
mod triangle;
mod walk;
mod weld;

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
pub use contact::Contact;
pub use defects::Defects;
pub use extremes::Extremes;
pub use mesh::{Mesh, MeshError};
pub use obb::Obb;
#[cfg(feature = "obb-tree")]
pub use obb_tree::ObbTree;
pub use pose::{Pose, PoseError};
pub use triangle::closest_point;
