//! Bytes <-> meshes: STL and 3MF in, build files, thumbnails and pick maps out. Knows meshes and poses, no solutions.

mod picture;
mod raster;
mod unit;

pub use picture::picture;
pub use unit::Unit;

mod limits;
mod options;

pub use limits::Limits;
pub use options::{Arrangement, Instances};
