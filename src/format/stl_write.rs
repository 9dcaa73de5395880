//! The whole build as one binary STL, the source paper's output.

use std::io::Write;

use super::WriteError;
use crate::geometry::{Mesh, Pose};

/// Writes placed meshes as one binary STL in mm.
pub fn write_stl<'a>(placed: impl Iterator<Item = (&'a Mesh, &'a Pose)>, out: impl Write) -> Result<(), WriteError> {
    let _ = (placed.count(), out);
    Err(WriteError::Build("empty".to_owned()))
}
