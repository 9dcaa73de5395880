//! A second reader for written builds. Our writer and our reader could share a mistake, for example a transposed
//! matrix, and agree with each other; `threemf2` is an independent implementation of the specification.

use std::{collections::HashMap, fs::File, io::BufReader, path::Path, sync::Arc};

use glam::DVec3;
use solids::{Bounds, Mesh};
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

use super::mesh_lists::{ListedMesh, ShortPackage};
use crate::{FileReadError, PlacedMesh, ReadLimits};

/// Greatest difference of a corner between the two readers, mm.
const SAME_MM: f64 = 1e-6;
/// Greatest compression ratio of Deflate.
const MAX_RATIO: u64 = 1100;

/// A placed mesh as read by the second reader: the number of its lists, and the transforms around it, outermost first.
struct SecondReading<'a> {
    lists: usize,
    transforms: Vec<&'a Transform>,
}

/// Compares the placements that [`read_build`](crate::read_build) read from a file with those that a second reader reads: the same number of
/// placements, each with the same triangles in the same place. Of a mesh that `read_build` had to weld, it compares the number of triangles
/// and the bounds. `threemf2` reads the package; the lists of vertices and triangles are read by a scanner of their own where
/// they are in the form in which builds are written. Only for files in mm that `read_build` has accepted: the second reader has no limits
/// except the size check here.
pub fn cross_check(file: &Path, placed: &[PlacedMesh], limits: &ReadLimits) -> Result<(), FileReadError> {
    check_sizes(file, limits)?;
    let (package, mut lists) = open_package(file)?;
    let index = ObjectIndex::from_model(&package.root, &mut lists);
    let mut seen = Vec::new();
    for item in &package.root.build.item {
        index.collect_meshes(item.objectid, &item.transform.iter().collect::<Vec<_>>(), &mut seen).map_err(disagree)?;
    }
    if seen.len() != placed.len() {
        return Err(disagree(format!("{} meshes instead of {}", seen.len(), placed.len())));
    }
    let mut comparison = MeshComparison { lists: &lists, known: HashMap::new() };
    for (number, (other, own)) in (1..).zip(seen.iter().zip(placed)) {
        let off_mm = comparison.distance_mm(other, own);
        if off_mm.is_nan() || off_mm > SAME_MM {
            return Err(disagree(format!("placement {number} ({}) is {off_mm} mm off", own.name)));
        }
    }
    Ok(())
}

fn disagree(reason: String) -> FileReadError {
    FileReadError::invalid_threemf(format!("a second reader disagrees: {reason}"))
}

/// Reads a package with `threemf2`, and its long lists on their own if they are in the plain form.
fn open_package(file: &Path) -> Result<(ThreemfPackage, Vec<ListedMesh>), FileReadError> {
    let short = ShortPackage::read(file).map_err(|error| disagree(error.to_string()))?;
    let read = match short {
        Some(ShortPackage { package, meshes }) => {
            ThreemfPackage::from_reader_with_memory_optimized_deserializer(package, false).map(|read| (read, meshes))
        }
        None => {
            let opened = BufReader::new(File::open(file)?);
            ThreemfPackage::from_reader_with_memory_optimized_deserializer(opened, false).map(|read| (read, Vec::new()))
        }
    };
    read.map_err(|error| disagree(error.to_string()))
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

/// Objects by id, and the numbers of the lists of those that are meshes.
struct ObjectIndex<'a>(HashMap<u32, (&'a Object, Option<usize>)>);

impl<'a> ObjectIndex<'a> {
    /// `lists` are those that were read on their own; the meshes that `threemf2` has read are added.
    fn from_model(model: &'a Model, lists: &mut Vec<ListedMesh>) -> Self {
        let cut = lists.len();
        let mut numbered = |object: &Object| match &object.kind {
            Some(ObjectKind::Mesh(mesh)) => Some(number_of_lists(mesh, cut).unwrap_or_else(|| {
                lists.push(listed(mesh));
                lists.len() - 1
            })),
            _ => None,
        };
        Self(model.resources.object.iter().map(|object| (object.id, (object, numbered(object)))).collect())
    }

    /// Adds every mesh below an object; `outer` holds the transforms around it, outermost first.
    fn collect_meshes(
        &self,
        id: u32,
        outer: &[&'a Transform],
        seen: &mut Vec<SecondReading<'a>>,
    ) -> Result<(), String> {
        match self.0.get(&id) {
            Some(&(_, Some(lists))) => seen.push(SecondReading { lists, transforms: outer.to_vec() }),
            Some((Object { kind: Some(ObjectKind::Components(components)), .. }, _)) => {
                for component in &components.component {
                    let around: Vec<_> = outer.iter().copied().chain(&component.transform).collect();
                    self.collect_meshes(component.objectid, &around, seen)?;
                }
            }
            _ => return Err(format!("object {id} is no mesh")),
        }
        Ok(())
    }
}

/// The number that stands in place of the lists of a mesh, if it is one of the first `cut`.
fn number_of_lists(mesh: &OtherMesh, cut: usize) -> Option<usize> {
    let [vertex] = mesh.vertices.vertex.as_slice() else { return None };
    let number = f64::from(vertex.x) as usize;
    (mesh.triangles.triangle.is_empty() && number < cut).then_some(number)
}

/// A mesh that `threemf2` has read with its lists.
fn listed(mesh: &OtherMesh) -> ListedMesh {
    ListedMesh {
        corners: mesh.vertices.vertex.iter().map(|v| [v.x.into(), v.y.into(), v.z.into()]).collect(),
        triangles: mesh.triangles.triangle.iter().map(|t| [t.v1, t.v2, t.v3]).collect(),
    }
}

/// Compares meshes of the two readers.
struct MeshComparison<'a> {
    lists: &'a [ListedMesh],
    /// Whether the lists with a number have the triangles of a mesh, by the address of the mesh.
    known: HashMap<(usize, *const Mesh), bool>,
}

impl MeshComparison<'_> {
    /// How far a placement is from where the other reader sees it, mm; infinite for another mesh.
    fn distance_mm(&mut self, other: &SecondReading<'_>, own: &PlacedMesh) -> f64 {
        let lists = &self.lists[other.lists];
        let place = |start: DVec3| {
            let moved = other.transforms.iter().rev().fold(start.to_array(), |p, t| transform_row_vector(p, &t.0));
            DVec3::from_array(moved)
        };
        let key = (other.lists, Arc::as_ptr(&own.mesh));
        if *self.known.entry(key).or_insert_with(|| is_same_mesh(lists, &own.mesh)) {
            // Two affine maps differ most at a corner of a box.
            let Bounds { min, max } = own.mesh.bounds();
            let corner = |at: u32| DVec3::select(glam::BVec3::new(at & 1 > 0, at & 2 > 0, at & 4 > 0), max, min);
            let off = |corner: DVec3| (place(corner) - own.pose.transform_point(corner)).abs().max_element();
            return (0..8).map(corner).map(off).fold(0.0, greater_or_nan);
        }
        match own.mesh.defects().welded_vertices {
            0 => distance_of_corners_mm(lists, place, own),
            // Its corners have moved by more than a reader's rounding.
            _ => distance_of_bounds_mm(lists, place, own),
        }
    }
}

fn greater_or_nan(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// Whether the triangles of both have the same corners, to the last bit, in the same order.
fn is_same_mesh(lists: &ListedMesh, own: &Mesh) -> bool {
    let is_same = |(corners, own_corners): (&[u32; 3], &[u32; 3])| {
        corners.iter().zip(own_corners).all(|(&corner, &own_corner)| {
            let own_corner = own.vertices()[own_corner as usize];
            lists.corners.get(corner as usize).is_some_and(|&corner| DVec3::from_array(corner) == own_corner)
        })
    };
    lists.triangles.len() == own.triangles().len() && lists.triangles.iter().zip(own.triangles()).all(is_same)
}

/// How far corners of the same triangle are apart, mm.
fn distance_of_corners_mm(lists: &ListedMesh, place: impl Fn(DVec3) -> DVec3, own: &PlacedMesh) -> f64 {
    if lists.triangles.len() != own.mesh.triangles().len() {
        return f64::INFINITY;
    }
    let is_turned = own.mesh.defects().inverted;
    let off = |(&[a, b, c], own_corners): (&[u32; 3], &[u32; 3])| {
        let corners = if is_turned { [a, c, b] } else { [a, b, c] };
        let off = corners.iter().zip(own_corners).map(|(&corner, &own_corner)| {
            let own_place = own.pose.transform_point(own.mesh.vertices()[own_corner as usize]);
            let corner = lists.corners.get(corner as usize);
            corner.map_or(f64::INFINITY, |&corner| (place(corner.into()) - own_place).abs().max_element())
        });
        off.fold(0.0, greater_or_nan)
    };
    lists.triangles.iter().zip(own.mesh.triangles()).map(off).fold(0.0, greater_or_nan)
}

/// How far the bounds are apart, mm, if there are as many triangles.
fn distance_of_bounds_mm(lists: &ListedMesh, place: impl Fn(DVec3) -> DVec3, own: &PlacedMesh) -> f64 {
    let mut is_used = vec![false; lists.corners.len()];
    let used =
        lists.triangles.iter().flatten().map(|&corner| is_used.get_mut(corner as usize).map(|used| *used = true));
    if used.collect::<Option<()>>().is_none() || lists.triangles.len() != own.mesh.triangles().len() {
        return f64::INFINITY;
    }
    let used = lists.corners.iter().zip(is_used).filter(|(_, is_used)| *is_used);
    let other = Bounds::from_points(used.map(|(&corner, _)| place(corner.into())));
    let own = own.mesh.bounds_at(&own.pose);
    let off = (other.min - own.min).abs().max((other.max - own.max).abs());
    off.to_array().into_iter().fold(0.0, greater_or_nan)
}

/// Multiplies a row vector by the 4 x 3 matrix, as in the specification (core, 3.3).
fn transform_row_vector([x, y, z]: [f64; 3], m: &[f64; 12]) -> [f64; 3] {
    [0, 1, 2].map(|column| x * m[column] + y * m[3 + column] + z * m[6 + column] + m[9 + column])
}
