//! `.build.3mf` -> meshes and poses, for the proof of what was written.

use std::path::Path;

use super::{BuildInfo, Limits, PlacedMesh, ReadError};

/// Every placed copy of a build file; items of one object share the mesh. Reads the files of other packers too: items with
/// components are flattened. A transform that is not rigid is an error that names the item.
pub fn read_build(file: &Path, limits: &Limits) -> Result<Vec<PlacedMesh>, ReadError> {
    Ok(read_build_and_info(file, limits)?.1)
}

/// As [`read_build`], with what the file says about itself.
pub fn read_build_and_info(file: &Path, limits: &Limits) -> Result<(BuildInfo, Vec<PlacedMesh>), ReadError> {
    let _ = limits;
    Err(ReadError::Unknown(file.display().to_string()))
}
