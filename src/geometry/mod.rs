//! Pure solids: poses, meshes, boxes and the distance between them. Millimetres everywhere; knows nothing of flowers.

mod bounds;
mod mesh;
mod pose;

pub use bounds::Bounds;
pub use mesh::{Defects, Mesh, MeshError};
pub use pose::Pose;
