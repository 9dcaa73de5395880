//! Meshes and poses -> `.build.3mf`.

use std::io::{Seek, Write};

use super::{BuildFile, WriteError};

/// Writes a build as a 3MF package; the same build gives the same bytes.
pub fn write_build(build: &BuildFile, out: impl Write + Seek) -> Result<(), WriteError> {
    let _ = out;
    Err(WriteError::Build(build.title.clone()))
}
