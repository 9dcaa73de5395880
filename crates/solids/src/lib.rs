#![doc = include_str!("../README.md")]
// Pure solids: poses, meshes, boxes and the distance between them. Millimetres everywhere; knows nothing of flowers.

#[cfg(test)]
extern crate self as solids; // for the fixtures, which know it by that name

mod clearance;
#[cfg(test)]
#[path = "../../sample-parts/src/fixtures.rs"]
mod fixtures;
mod mending;
mod mesh;
#[cfg(test)]
mod tests;
mod trees;

// Its types are in the interface.
pub use glam;

pub use clearance::clearance::ClearanceTree;
pub use clearance::contact::SurfaceContact;
pub use mending::mend::{MendError, MendMeasures, MendedMesh};
pub use mesh::bounds::Bounds;
pub use mesh::defects::MeshDefects;
pub use mesh::mesh::{Mesh, MeshError};
pub use mesh::mesh_builder::MeshBuilder;
pub use mesh::pose::{Pose, PoseError};
pub use mesh::triangle::closest_point;
pub use trees::extreme_points::ExtremePoints;
pub use trees::obb::Obb;
#[cfg(feature = "obb-tree")]
pub use trees::obb_tree::ObbTree;
