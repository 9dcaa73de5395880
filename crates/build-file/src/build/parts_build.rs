//! A build as a ZIP of one binary STL for each part, with the table of the places of its copies, and what the build says of itself.
//!
//! It is one file and no folder: a queue makes a build visible by one rename that overwrites nothing, compares one hash, and takes it back by
//! one rename. What lies in a folder can be changed or taken piece by piece, of which none of that would tell.

use std::{
    collections::HashMap,
    io::{Seek, Write},
    sync::Arc,
};

use glam::DVec3;
use solids::{Mesh, Pose};
use zip::ZipWriter;

use super::{
    build_metadata::{from_pairs, metadata_of},
    package_entry::{entry_options, package_error},
    placement_table::{PlacementTableRow, read_rows, write_rows},
    stl_build::read_mesh,
};
use crate::{
    BuildFile, BuildFileObject, FileReadError, FileWriteError, PlacedMesh, ReadLimits,
    common::{options::MAX_PART_REACH_MM, solid::checked_mesh},
    stl::{
        stl_read::{STL_HEAD_BYTES, binary_len, claimed_count},
        stl_write::write_titled_stl,
    },
    threemf::{model::ModelMetadata, package::PackageReader},
};

/// The table of places, and what the build says of itself, in the package.
const TABLE: &str = "placements.csv";
const HEADING: &str = "build.csv";
const PICTURE: &str = "build.png";
/// Greatest lengths of the two tables, bytes.
const MAX_TABLE_BYTES: u64 = 1 << 28;
const MAX_HEADING_BYTES: u64 = 1 << 20;
/// Greatest length of the name of a part in that of its STL.
const MAX_NAME: usize = 60;

/// Writes the package.
pub(super) fn write_parts_build(build: &BuildFile, out: impl Write + Seek) -> Result<(), FileWriteError> {
    let options = entry_options(build)?;
    let mut zip = ZipWriter::new(out);
    zip.start_file(HEADING, options).map_err(package_error)?;
    let mut heading = csv::Writer::from_writer(&mut zip);
    for (name, value) in metadata_of(build) {
        heading.write_record([name, value]).map_err(super::pick_map::csv_error)?;
    }
    heading.flush()?;
    drop(heading);
    zip.start_file(TABLE, options).map_err(package_error)?;
    let row = |item: &crate::BuildFileItem| {
        let object = &build.objects[item.object];
        PlacementTableRow::of_item(item, object, stl_name(item.object, object), stl_origin_mm(&object.mesh))
    };
    write_rows(build.items.iter().map(row), &mut zip)?;
    for (number, object) in build.objects.iter().enumerate() {
        if build.items.iter().any(|item| item.object == number) {
            let is_large = binary_len(object.mesh.triangles().len() as u64) > u64::from(u32::MAX);
            zip.start_file(stl_name(number, object), options.large_file(is_large)).map_err(package_error)?;
            let to_origin = Pose { translation: -stl_origin_mm(&object.mesh), ..Pose::IDENTITY };
            write_titled_stl(&object.part_number, [(&*object.mesh, &to_origin)].into_iter(), &mut zip)?;
        }
    }
    if let Some(png) = &build.thumbnail_png {
        zip.start_file(PICTURE, options).map_err(package_error)?;
        zip.write_all(png)?;
    }
    zip.finish().map_err(package_error)?.flush()?;
    Ok(())
}

/// `001_bracket.stl`: a name that is unique in the package and that every file system takes.
fn stl_name(number: usize, object: &BuildFileObject) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' };
    let name = object.name.strip_suffix(".stl").unwrap_or(&object.name);
    let name: String = name.chars().take(MAX_NAME).map(plain).collect();
    format!("{:03}_{name}.stl", number + 1)
}

/// Where an STL has its origin, in the frame of the mesh: there, too, unless that is so far away that 32-bit numbers are coarse.
fn stl_origin_mm(mesh: &Mesh) -> DVec3 {
    let bounds = mesh.bounds();
    let reach_mm = bounds.min.abs().max(bounds.max.abs()).max_element();
    if reach_mm <= MAX_PART_REACH_MM { DVec3::ZERO } else { bounds.center().round() }
}

/// Whether a package is a build of STL files.
pub(super) fn is_parts_build(package: &PackageReader) -> bool {
    package.find_entry(&[TABLE]).is_some() && package.find_entry(&[HEADING]).is_some()
}

/// What a build says of itself.
pub(super) fn read_parts_metadata(package: &mut PackageReader) -> Result<ModelMetadata, FileReadError> {
    let mut text = Vec::new();
    package.unpack_entry(HEADING, MAX_HEADING_BYTES, &mut text)?;
    let mut csv = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_slice());
    let pairs = csv.records().filter_map(|record| {
        let record = record.ok()?;
        Some((record.get(0)?.to_owned(), record.get(1)?.to_owned()))
    });
    Ok(from_pairs(pairs))
}

/// Reads the copies; those of one part share its mesh.
pub(super) fn read_parts_build(
    package: &mut PackageReader,
    limits: &ReadLimits,
) -> Result<Vec<PlacedMesh>, FileReadError> {
    let mut table = Vec::new();
    package.unpack_entry(TABLE, MAX_TABLE_BYTES, &mut table)?;
    let rows = read_rows(table.as_slice(), limits.max_instances)?;
    let mut meshes: HashMap<String, Arc<Mesh>> = HashMap::new();
    rows.into_iter()
        .map(|row| {
            let mesh = match meshes.get(&row.file) {
                Some(mesh) => mesh.clone(),
                None => {
                    let mesh = Arc::new(read_part(package, &row, limits)?);
                    meshes.insert(row.file.clone(), mesh.clone());
                    mesh
                }
            };
            Ok(row.into_placed(mesh))
        })
        .collect()
}

/// Reads the STL of a row, in the frame of its part.
fn read_part(package: &mut PackageReader, row: &PlacementTableRow, limits: &ReadLimits) -> Result<Mesh, FileReadError> {
    let mut stl = Vec::new();
    package.unpack_entry(&row.file.to_ascii_lowercase(), limits.max_bytes, &mut stl)?;
    let count = claimed_count(&stl).filter(|&count| binary_len(count) == stl.len() as u64);
    let Some(count) = count.filter(|&count| count == row.triangles) else {
        let told = row.triangles;
        return Err(FileReadError::invalid_stl(format!(
            "{:?} does not hold the {told} triangles of the table",
            row.file
        )));
    };
    if count > limits.max_triangles {
        return Err(FileReadError::too_many_triangles(limits));
    }
    let mesh = read_mesh(&mut &stl[STL_HEAD_BYTES as usize..], count, &row.part.0)?;
    if row.origin_mm == DVec3::ZERO {
        return Ok(mesh);
    }
    let vertices = mesh.vertices().iter().map(|&corner| corner + row.origin_mm).collect();
    checked_mesh(&row.part.0, vertices, mesh.triangles().to_vec())
}
