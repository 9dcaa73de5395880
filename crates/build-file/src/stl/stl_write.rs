//! Writes placed meshes as one binary STL, like the source paper.

use std::io::{BufWriter, Write};

use glam::DVec3;
use solids::{Mesh, Pose};

use super::stl_read::STL_FACET_BYTES;
use crate::FileWriteError;

/// Bytes of the text before the count of facets.
pub(crate) const STL_TITLE_BYTES: usize = 80;

/// Writes placed meshes as one binary STL in mm.
pub fn write_stl<'a>(
    placed: impl Iterator<Item = (&'a Mesh, &'a Pose)>,
    out: impl Write,
) -> Result<(), FileWriteError> {
    write_titled_stl("", placed, out)
}

/// The same, with a title, of which the first 80 bytes are written. It must not begin with `solid`, as text STL does.
pub(crate) fn write_titled_stl<'a>(
    title: &str,
    placed: impl Iterator<Item = (&'a Mesh, &'a Pose)>,
    out: impl Write,
) -> Result<(), FileWriteError> {
    let placed: Vec<(&Mesh, &Pose)> = placed.collect();
    let triangles: usize = placed.iter().map(|(mesh, _)| mesh.triangles().len()).sum();
    if triangles == 0 {
        return Err(FileWriteError::Build("it contains no placements".to_owned()));
    }
    let Ok(count) = u32::try_from(triangles) else {
        return Err(FileWriteError::Build(format!("{triangles} triangles are more than an STL file can count")));
    };
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let mut head = [0; STL_TITLE_BYTES];
    head.iter_mut().zip(title.bytes()).for_each(|(to, from)| *to = from);
    out.write_all(&head)?;
    out.write_all(&count.to_le_bytes())?;
    for (mesh, pose) in placed {
        for triangle in 0..mesh.triangles().len() {
            out.write_all(&facet(mesh.corners(triangle).map(|corner| pose.transform_point(corner))))?;
        }
    }
    out.flush()?;
    Ok(())
}

/// The bytes of a facet: its normal, its corners, and no attributes.
fn facet([a, b, c]: [DVec3; 3]) -> [u8; STL_FACET_BYTES as usize] {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let numbers = [normal, a, b, c].into_iter().flat_map(|v| v.as_vec3().to_array());
    let mut bytes = [0; STL_FACET_BYTES as usize];
    bytes.chunks_exact_mut(4).zip(numbers).for_each(|(to, number)| to.copy_from_slice(&number.to_le_bytes()));
    bytes
}
