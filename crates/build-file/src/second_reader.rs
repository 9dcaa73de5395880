//! A second opinion on a written build. Our writer and our reader could share a mistake, a transposed matrix say, and agree
//! with each other; `threemf2` is somebody else's reading of the specification.

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

use super::{Limits, PlacedMesh, ReadError};

/// How far two readings of a corner may differ, mm.
const SAME_MM: f64 = 1e-6;
/// Deflate cannot pack better than this.
const MAX_RATIO: u64 = 1100;

/// A placed mesh as the other reader sees it.
struct Seen {
    triangles: usize,
    bounds: Bounds,
}

/// Compares what [`read_build`](super::read_build) read from a file with what `threemf2` reads: as many placements, each with
/// as many triangles and the same bounds. Only for files in mm that `read_build` has accepted: the other reader has no guard of
/// its own but for the one here on sizes, and holds the whole XML in memory.
pub fn cross_check(file: &Path, placed: &[PlacedMesh], limits: &Limits) -> Result<(), ReadError> {
    let disagree = |reason: String| ReadError::threemf(format!("a second reader disagrees: {reason}"));
    check_sizes(file, limits)?;
    let opened = BufReader::new(File::open(file)?);
    let package = ThreemfPackage::from_reader_with_memory_optimized_deserializer(opened, false)
        .map_err(|error| disagree(error.to_string()))?;
    let mut seen = Vec::new();
    let view = View::of(&package.root);
    for item in &package.root.build.item {
        view.place(item.objectid, &[item.transform.as_ref()], &mut seen).map_err(disagree)?;
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

/// The other reader allocates what the directory claims.
fn check_sizes(file: &Path, limits: &Limits) -> Result<(), ReadError> {
    let opened = File::open(file)?;
    let possible = opened.metadata()?.len().saturating_mul(MAX_RATIO).min(limits.max_unpacked_bytes);
    let mut archive = ZipArchive::new(BufReader::new(opened)).map_err(|e| ReadError::threemf(e.to_string()))?;
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|e| ReadError::threemf(e.to_string()))?;
        if entry.size() > possible {
            return Err(ReadError::threemf(format!("the entry {:?} claims {} bytes", entry.name(), entry.size())));
        }
    }
    Ok(())
}

/// Objects by id.
struct View<'a>(HashMap<u32, &'a Object>);

impl<'a> View<'a> {
    fn of(model: &'a Model) -> Self {
        Self(model.resources.object.iter().map(|o| (o.id, o)).collect())
    }

    /// Adds every mesh under an object; `outer` holds the transforms around it, outermost first.
    fn place(&self, id: u32, outer: &[Option<&Transform>], seen: &mut Vec<Seen>) -> Result<(), String> {
        match self.0.get(&id).and_then(|object| object.kind.as_ref()) {
            Some(ObjectKind::Mesh(mesh)) => seen.push(placed(mesh, outer)),
            Some(ObjectKind::Components(components)) => {
                for component in &components.component {
                    let around: Vec<_> = outer.iter().copied().chain([component.transform.as_ref()]).collect();
                    self.place(component.objectid, &around, seen)?;
                }
            }
            _ => return Err(format!("object {id} is no mesh")),
        }
        Ok(())
    }
}

fn placed(mesh: &OtherMesh, outer: &[Option<&Transform>]) -> Seen {
    let used = mesh.triangles.triangle.iter().flat_map(|t| [t.v1, t.v2, t.v3]);
    let corners = used.map(|v| {
        let vertex = &mesh.vertices.vertex[v as usize];
        let start: [f64; 3] = [vertex.x.into(), vertex.y.into(), vertex.z.into()];
        outer.iter().rev().flatten().fold(start, |point, transform| moved(point, &transform.0))
    });
    let bounds = Bounds::around(corners.map(DVec3::from_array));
    Seen { triangles: mesh.triangles.triangle.len(), bounds }
}

/// A row vector times the 4 x 3 matrix, spelt out as the specification has it (core, 3.3).
fn moved([x, y, z]: [f64; 3], m: &[f64; 12]) -> [f64; 3] {
    [0, 1, 2].map(|column| x * m[column] + y * m[3 + column] + z * m[6 + column] + m[9 + column])
}
