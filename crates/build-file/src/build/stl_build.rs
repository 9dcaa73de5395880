//! A whole build as one binary STL: all copies in their places, one after the other in the order of the table beside it. Its title is the name
//! that the file has in the queue, so that a copy under another name is known.

use std::{
    fs::File,
    io::{BufReader, Read, Write},
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::DVec3;
use solids::{Mesh, MeshBuilder, Pose};

use super::placement_table::read_rows;
use crate::{
    BuildFile, DeliveryKind, FileReadError, FileWriteError, PlacedMesh, ReadLimits, build_file_name, build_file_stem,
    common::solid::checked_mesh,
    placement_table_name,
    stl::{
        stl_read::{STL_FACET_BYTES, STL_HEAD_BYTES, binary_len, claimed_count, facet_corners},
        stl_write::{STL_TITLE_BYTES, write_titled_stl},
    },
};

/// Writes all copies in their places.
pub(super) fn write_stl_build(build: &BuildFile, out: impl Write) -> Result<(), FileWriteError> {
    let placed = build.items.iter().map(|item| (&*build.objects[item.object].mesh, &item.pose));
    write_titled_stl(&own_name(build, DeliveryKind::Stl).unwrap_or_default(), placed, out)
}

/// The name that a build has in a queue.
fn own_name(build: &BuildFile, kind: DeliveryKind) -> Option<String> {
    let heading = &build.heading;
    Some(build_file_name(heading.created.parse().ok()?, &heading.machine, heading.build_id.parse().ok()?, kind))
}

/// The name in the title of a file, if it is one of a build as STL.
pub(super) fn titled_name(file: &Path) -> Result<Option<String>, FileReadError> {
    let mut title = [0; STL_TITLE_BYTES];
    let mut opened = File::open(file)?;
    if opened.metadata()?.len() < STL_HEAD_BYTES {
        return Ok(None);
    }
    opened.read_exact(&mut title)?;
    let name = String::from_utf8_lossy(&title).trim_end_matches('\0').to_owned();
    Ok(Some(name).filter(|name| name.ends_with(DeliveryKind::Stl.ending())))
}

/// Where the table of a whole build as STL is: beside it.
pub(super) fn table_beside(file: &Path) -> Option<PathBuf> {
    let stem = build_file_stem(file.file_name()?.to_str()?)?;
    Some(file.with_file_name(placement_table_name(stem))).filter(|table| table.is_file())
}

/// Whether a file is a binary STL, by its size.
pub(super) fn is_stl(file: &Path) -> Result<bool, FileReadError> {
    let opened = File::open(file)?;
    let len = opened.metadata()?.len();
    let mut head = Vec::new();
    opened.take(STL_HEAD_BYTES).read_to_end(&mut head)?;
    Ok(claimed_count(&head).is_some_and(|count| count > 0 && binary_len(count) == len))
}

/// Reads the copies, each with its mesh in the frame of its part.
pub(super) fn read_stl_build(
    file: &Path,
    table: Option<&Path>,
    limits: &ReadLimits,
) -> Result<Vec<PlacedMesh>, FileReadError> {
    let Some(table) = table.map(Path::to_path_buf).or_else(|| table_beside(file)) else {
        return Err(FileReadError::Unsupported {
            what: "it is one STL, and the table of places that tells its copies apart is not beside it".to_owned(),
            remedy: "Put the file that ends with .placements.csv into its folder.",
        });
    };
    let rows = read_rows(BufReader::new(File::open(table)?), limits.max_instances)?;
    let mut facets = BufReader::with_capacity(1 << 16, File::open(file)?);
    let mut head = [0; STL_HEAD_BYTES as usize];
    facets.read_exact(&mut head)?;
    let (count, told) = (claimed_count(&head).unwrap_or_default(), rows.iter().map(|row| row.triangles).sum::<u64>());
    if count != told {
        return Err(FileReadError::invalid_stl(format!(
            "it has {count} triangles and the table beside it tells {told}"
        )));
    }
    rows.into_iter()
        .map(|row| {
            let mesh = read_mesh(&mut facets, row.triangles, &row.part.0)?;
            let mesh = moved_back(&mesh, &row.pose, &row.part.0)?;
            Ok(row.into_placed(Arc::new(mesh)))
        })
        .collect()
}

/// Reads the mesh of the next facets.
pub(super) fn read_mesh(facets: &mut impl Read, count: u64, name: &str) -> Result<Mesh, FileReadError> {
    let mut builder = MeshBuilder::default();
    let mut facet = [0; STL_FACET_BYTES as usize];
    for _ in 0..count {
        facets.read_exact(&mut facet)?;
        builder.add_triangle(facet_corners(&facet));
    }
    builder.into_mesh().map_err(|source| FileReadError::NoSolid { name: format!("{name:?}"), source })
}

/// A mesh that stands at a pose, in its own frame.
pub(super) fn moved_back(mesh: &Mesh, pose: &Pose, name: &str) -> Result<Mesh, FileReadError> {
    let back = pose.inverse();
    let vertices: Vec<DVec3> = mesh.vertices().iter().map(|&corner| back.transform_point(corner)).collect();
    checked_mesh(name, vertices, mesh.triangles().to_vec())
}
