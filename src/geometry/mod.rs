//! Pure solids: poses, meshes, boxes and the distance between them. Millimetres everywhere; knows nothing of flowers.

mod bounds;
mod clearance;
mod mesh;
mod obb;
mod obb_tree;
mod pose;

pub use bounds::Bounds;
pub use clearance::ClearanceTree;
pub use mesh::{Defects, Mesh, MeshError};
pub use obb::Obb;
pub use obb_tree::ObbTree;
pub use pose::Pose;
