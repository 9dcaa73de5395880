//! Reads build files of every kind into meshes and poses, to prove the written file.

use std::{collections::HashMap, path::Path, sync::Arc};

use glam::{DAffine3, DMat3, DQuat};
use solids::{Mesh, Pose};

use super::{
    build_metadata::{build_metadata, heading_metadata, parse_pose},
    parts_build::{is_parts_build, read_parts_build, read_parts_metadata},
    stl_build::{is_stl, moved_back, read_stl_build, titled_name},
};

use crate::{
    BuildMetadata, DeliveryKind, FileReadError, HeadingMetadata, OrderWords, PlacedMesh, ReadLimits, build_file_name,
    common::solid::checked_mesh,
    threemf::{
        document::{ModelDocument, ObjectKey, read_leading_metadata},
        flatten::ComponentFlattener,
        model::{ModelItem, ModelMetadata, ObjectBody, ObjectReference},
        package::PackageReader,
    },
};

/// Greatest deviation of a written rotation matrix from a true rotation: files print 6 digits and more.
const RIGID_TOLERANCE: f64 = 1e-5;

/// Reads every placed copy of a build file of any kind. Copies of one object share the mesh. Files of other packers are read too:
/// items with components are flattened. A transform that is not rigid is an error that names the item. Of a whole build as STL, the table
/// of places is read that lies beside it.
pub fn read_build(file: &Path, limits: &ReadLimits) -> Result<Vec<PlacedMesh>, FileReadError> {
    Ok(read_build_and_metadata(file, limits)?.1)
}

/// Like [`read_build`], with the metadata of the file.
pub fn read_build_and_metadata(
    file: &Path,
    limits: &ReadLimits,
) -> Result<(BuildMetadata, Vec<PlacedMesh>), FileReadError> {
    read_build_with_table(file, None, limits)
}

/// Like [`read_build_and_metadata`], with the table of places of a whole build as STL where that has another name than the file.
pub fn read_build_with_table(
    file: &Path,
    table: Option<&Path>,
    limits: &ReadLimits,
) -> Result<(BuildMetadata, Vec<PlacedMesh>), FileReadError> {
    let (metadata, placed) = match find_kind(file, limits)? {
        FileKind::Model => {
            let document = ModelDocument::read_package(file, limits)?;
            (build_metadata(&document.start_part().metadata), read_model(&document, limits)?)
        }
        FileKind::Parts(mut package) => {
            let metadata = build_metadata(&read_parts_metadata(&mut package)?);
            (metadata, read_parts_build(&mut package, limits)?)
        }
        FileKind::Stl => (BuildMetadata::default(), read_stl_build(file, table, limits)?),
    };
    if placed.is_empty() {
        return Err(FileReadError::invalid_threemf("it contains no placements"));
    }
    Ok((metadata, placed))
}

/// Reads only the heading of a build file: the parts that follow it may be damaged.
pub fn read_build_heading(file: &Path, limits: &ReadLimits) -> Result<HeadingMetadata, FileReadError> {
    Ok(heading_metadata(&match find_kind(file, limits)? {
        FileKind::Model => read_leading_metadata(file, limits)?,
        FileKind::Parts(mut package) => read_parts_metadata(&mut package)?,
        FileKind::Stl => return Ok(HeadingMetadata::default()),
    }))
}

/// The name that a build file had when it was written for a queue, as it says itself, whatever its name is now. Reads the beginning of the
/// file; `None` = it does not say one.
pub fn read_own_name(file: &Path, limits: &ReadLimits) -> Result<Option<String>, FileReadError> {
    let kind = match find_kind(file, limits)? {
        FileKind::Stl => return titled_name(file),
        FileKind::Parts(_) => DeliveryKind::Parts,
        FileKind::Model => DeliveryKind::Shared,
    };
    let HeadingMetadata { created, machine, build_id, .. } = read_build_heading(file, limits)?;
    let name = || Some(build_file_name(created?.parse().ok()?, &machine?, build_id?.parse().ok()?, kind));
    Ok(name())
}

/// Whether a file is a 3MF as far as its beginning and its entries tell.
pub fn is_model_package(file: &Path, limits: &ReadLimits) -> bool {
    matches!(find_kind(file, limits), Ok(FileKind::Model))
}

/// What a file is, whatever its name is.
enum FileKind {
    /// A 3MF, or nothing that is read.
    Model,
    /// A package of STL files.
    Parts(Box<PackageReader>),
    /// A binary STL.
    Stl,
}

fn find_kind(file: &Path, limits: &ReadLimits) -> Result<FileKind, FileReadError> {
    if is_stl(file)? {
        return Ok(FileKind::Stl);
    }
    Ok(match PackageReader::open(file, limits) {
        Ok(package) if is_parts_build(&package) => FileKind::Parts(Box::new(package)),
        // What is wrong with it is told by who reads it.
        _ => FileKind::Model,
    })
}

fn read_model(document: &ModelDocument, limits: &ReadLimits) -> Result<Vec<PlacedMesh>, FileReadError> {
    let locked = document.start_part().metadata.nestd_value("arrangement").is_some_and(|a| a == "locked");
    let mut reader = BuildFileReader {
        document,
        flattener: ComponentFlattener::new(document, limits),
        scale: document.start_part().unit.mm_per_unit(),
        meshes: HashMap::new(),
        limit: limits.max_instances,
        placed: Vec::new(),
    };
    for (number, item) in (1..).zip(&document.start_part().items) {
        if item.printable {
            reader.read_item(number, item, locked)?;
        }
    }
    Ok(reader.placed)
}

struct BuildFileReader<'a> {
    document: &'a ModelDocument,
    flattener: ComponentFlattener<'a>,
    scale: f64,
    meshes: HashMap<ObjectKey, Arc<Mesh>>,
    limit: u64,
    placed: Vec<PlacedMesh>,
}

impl BuildFileReader<'_> {
    fn read_item(&mut self, number: usize, item: &ModelItem, locked: bool) -> Result<(), FileReadError> {
        let document = self.document;
        let key = document.resolve_reference(&item.reference, None)?;
        let object = document.object(key);
        let what = format!("build item {number} ({})", object.name.as_deref().unwrap_or("without a name"));
        match &object.body {
            ObjectBody::Components(components) if locked => {
                for component in components {
                    self.locked_placement(&what, item.reference.transform, component, key)?;
                }
                Ok(())
            }
            _ => self.add_placement(&what, key, item.reference.transform, &item.metadata, item.part_number.clone()),
        }
    }

    /// Reads a component of our own locked object: an object that holds the placement's metadata and refers to the mesh
    /// that copies share.
    fn locked_placement(
        &mut self,
        what: &str,
        outer: DAffine3,
        component: &ObjectReference,
        locked: ObjectKey,
    ) -> Result<(), FileReadError> {
        let document = self.document;
        let wrapper = document.resolve_reference(component, Some(locked))?;
        let transform = outer * component.transform;
        let object = document.object(wrapper);
        match &object.body {
            ObjectBody::Components(inner) if inner.len() == 1 => {
                let mesh = document.resolve_reference(&inner[0], Some(wrapper))?;
                let part_number = object.part_number.clone();
                self.add_placement(what, mesh, transform * inner[0].transform, &object.metadata, part_number)
            }
            _ => self.add_placement(what, wrapper, transform, &object.metadata, object.part_number.clone()),
        }
    }

    fn add_placement(
        &mut self,
        what: &str,
        key: ObjectKey,
        transform: DAffine3,
        metadata: &ModelMetadata,
        part_number: Option<String>,
    ) -> Result<(), FileReadError> {
        if self.placed.len() as u64 >= self.limit {
            return Err(FileReadError::TooLarge {
                what: "it has too many placements".to_owned(),
                limit: self.limit,
                key: "max_instances",
            });
        }
        let pose = rigid_pose(transform, self.scale).ok_or_else(|| {
            FileReadError::invalid_threemf(format!("the transform of {what} is not a rotation and a translation"))
        })?;
        let object = self.document.object(key);
        let name = object.name.clone().unwrap_or_else(|| format!("object {}", key.id()));
        let mut mesh = self.object_mesh(key, &name)?;
        // A copy that is written in its place says how its part was turned and moved there.
        let pose = match metadata.nestd_value("pose").as_deref().map(parse_pose) {
            None => pose,
            Some(Some(own)) => {
                mesh = Arc::new(moved_back(&mesh, &own, &name)?);
                pose.compose_with(&own)
            }
            Some(None) => return Err(FileReadError::invalid_threemf(format!("the pose of {what} is none"))),
        };
        self.placed.push(PlacedMesh {
            name,
            mesh,
            pose,
            part_number: part_number.or_else(|| object.part_number.clone()),
            copy: metadata.nestd_value("copy").and_then(|text| text.parse().ok()),
            words: OrderWords {
                order: metadata.nestd_value("order"),
                due: metadata.nestd_value("due"),
                note: metadata.nestd_value("note"),
                reference: metadata.nestd_value("reference"),
                material: metadata.nestd_value("material"),
            },
            source_name: metadata.nestd_value("source"),
            source_hash: metadata.nestd_value("source_hash"),
            clearance_mm: metadata.nestd_value("clearance_mm").and_then(|text| text.parse().ok()),
            orientation: metadata.nestd_value("orientation"),
            tilts: metadata.nestd_value("tilts"),
        });
        Ok(())
    }

    /// The mesh of an object in its own frame, created once.
    fn object_mesh(&mut self, key: ObjectKey, name: &str) -> Result<Arc<Mesh>, FileReadError> {
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let flat = self.flattener.flatten_object(key, DAffine3::IDENTITY, self.scale)?;
        let mesh = Arc::new(checked_mesh(name, flat.vertices, flat.triangles)?);
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }
}

/// Converts a transform to a pose; `None` if it scales, shears or mirrors. `scale` is millimetres per unit.
fn rigid_pose(transform: DAffine3, scale: f64) -> Option<Pose> {
    let matrix = transform.matrix3;
    let off = matrix.transpose() * matrix - DMat3::IDENTITY;
    let farthest = off.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
    let is_rotation = farthest <= RIGID_TOLERANCE && matrix.determinant() > 0.0;
    is_rotation.then(|| Pose::new(DQuat::from_mat3(&matrix), transform.translation * scale))
}
