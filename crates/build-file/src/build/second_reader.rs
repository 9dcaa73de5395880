//! A second reader for written builds. Our writer and our reader could share a mistake, for example a transposed
//! matrix, and agree with each other; `threemf2` is an independent implementation of the specification.

use std::{collections::HashMap, fs::File, io::BufReader, path::Path};

use glam::DVec3;
use solids::Bounds;
use threemf2::{
    model::domain::{
        mesh::Mesh as OtherMesh,
        model::Model,
        object::{Object, ObjectKind},
        transform::Transform,
    },
    package::ThreemfPackage,
};
use zip::ZipArchive;

use crate::{FileReadError, PlacedMesh, ReadLimits};

/// Greatest difference of a corner between the two readers, mm.
const SAME_MM: f64 = 1e-6;
/// Greatest compression ratio of Deflate.
const MAX_RATIO: u64 = 1100;

/// A placed mesh as read by the second reader.
struct SecondReading {
    triangles: usize,
    bounds: Bounds,
}

/// Compares the placements that [`read_build`](crate::read_build) read from a file with those that `threemf2` reads:
/// the same number of placements, each with the same number of triangles and the same bounds. Only for files in mm that
/// `read_build` has accepted: the second reader has no limits except the size check here, and holds the whole XML in
/// memory.
pub fn cross_check(file: &Path, placed: &[PlacedMesh], limits: &ReadLimits) -> Result<(), FileReadError> {
    let disagree = |reason: String| FileReadError::invalid_threemf(format!("a second reader disagrees: {reason}"));
    check_sizes(file, limits)?;
    let opened = BufReader::new(File::open(file)?);
    let package = ThreemfPackage::from_reader_with_memory_optimized_deserializer(opened, false)
        .map_err(|error| disagree(error.to_string()))?;
    let mut seen = Vec::new();
    let view = ObjectIndex::from_model(&package.root);
    for item in &package.root.build.item {
        view.collect_meshes(item.objectid, &[item.transform.as_ref()], &mut seen).map_err(disagree)?;
    }
    if seen.len() != placed.len() {
        return Err(disagree(format!("{} meshes instead of {}", seen.len(), placed.len())));
    }
    for (number, (other, own)) in (1..).zip(seen.iter().zip(placed)) {
        let bounds = own.mesh.bounds_at(&own.pose);
        let off = (other.bounds.min - bounds.min).abs().max((other.bounds.max - bounds.max).abs()).max_element();
        if other.triangles != own.mesh.triangles().len() || off.is_nan() || off > SAME_MM {
            return Err(disagree(format!("placement {number} ({}) is {off} mm off", own.name)));
        }
    }
    Ok(())
}

/// The second reader allocates the sizes that the ZIP directory declares.
fn check_sizes(file: &Path, limits: &ReadLimits) -> Result<(), FileReadError> {
    let opened = File::open(file)?;
    let possible = opened.metadata()?.len().saturating_mul(MAX_RATIO).min(limits.max_unpacked_bytes);
    let mut archive =
        ZipArchive::new(BufReader::new(opened)).map_err(|e| FileReadError::invalid_threemf(e.to_string()))?;
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|e| FileReadError::invalid_threemf(e.to_string()))?;
        if entry.size() > possible {
            return Err(FileReadError::invalid_threemf(format!(
                "the entry {:?} claims {} bytes",
                entry.name(),
                entry.size()
            )));
        }
    }
    Ok(())
}

/// Objects by id.
struct ObjectIndex<'a>(HashMap<u32, &'a Object>);

impl<'a> ObjectIndex<'a> {
    fn from_model(model: &'a Model) -> Self {
        Self(model.resources.object.iter().map(|o| (o.id, o)).collect())
    }

    /// Adds every mesh below an object; `outer` holds the transforms around it, outermost first.
    fn collect_meshes(
        &self,
        id: u32,
        outer: &[Option<&Transform>],
        seen: &mut Vec<SecondReading>,
    ) -> Result<(), String> {
        match self.0.get(&id).and_then(|object| object.kind.as_ref()) {
            Some(ObjectKind::Mesh(mesh)) => seen.push(read_mesh(mesh, outer)),
            Some(ObjectKind::Components(components)) => {
                for component in &components.component {
                    let around: Vec<_> = outer.iter().copied().chain([component.transform.as_ref()]).collect();
                    self.collect_meshes(component.objectid, &around, seen)?;
                }
            }
            _ => return Err(format!("object {id} is no mesh")),
        }
        Ok(())
    }
}

fn read_mesh(mesh: &OtherMesh, outer: &[Option<&Transform>]) -> SecondReading {
    let vertices = &mesh.vertices.vertex;
    let mut is_used = vec![false; vertices.len()];
    mesh.triangles.triangle.iter().flat_map(|t| [t.v1, t.v2, t.v3]).for_each(|v| is_used[v as usize] = true);
    let used = vertices.iter().zip(is_used).filter(|(_, is_used)| *is_used);
    let corners = used.map(|(vertex, _)| {
        let start: [f64; 3] = [vertex.x.into(), vertex.y.into(), vertex.z.into()];
        outer.iter().rev().flatten().fold(start, |point, transform| transform_row_vector(point, &transform.0))
    });
    let bounds = Bounds::from_points(corners.map(DVec3::from_array));
    SecondReading { triangles: mesh.triangles.triangle.len(), bounds }
}

/// Multiplies a row vector by the 4 x 3 matrix, as in the specification (core, 3.3).
fn transform_row_vector([x, y, z]: [f64; 3], m: &[f64; 12]) -> [f64; 3] {
    [0, 1, 2].map(|column| x * m[column] + y * m[3 + column] + z * m[6 + column] + m[9 + column])
}
