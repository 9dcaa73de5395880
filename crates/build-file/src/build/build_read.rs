//! Reads `.build.3mf` files into meshes and poses, to prove the written file.

use std::{collections::HashMap, path::Path, sync::Arc};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use solids::{Bounds, Mesh, Pose};

use crate::{
    BuildMetadata, FileReadError, HeadingMetadata, OrderWords, PlacedMesh, ReadLimits, RulesMetadata,
    common::solid::checked_mesh,
    threemf::{
        document::{ModelDocument, ObjectKey, read_leading_metadata},
        flatten::ComponentFlattener,
        model::{ModelItem, ModelMetadata, ObjectBody, ObjectReference},
    },
};

/// Greatest deviation of a written rotation matrix from a true rotation: files print 6 digits and more.
const RIGID_TOLERANCE: f64 = 1e-5;

/// Reads every placed copy of a build file. Items of one object share the mesh. Files of other packers are read too:
/// items with components are flattened. A transform that is not rigid is an error that names the item.
pub fn read_build(file: &Path, limits: &ReadLimits) -> Result<Vec<PlacedMesh>, FileReadError> {
    Ok(read_build_and_metadata(file, limits)?.1)
}

/// Like [`read_build`], with the metadata of the file.
pub fn read_build_and_metadata(
    file: &Path,
    limits: &ReadLimits,
) -> Result<(BuildMetadata, Vec<PlacedMesh>), FileReadError> {
    let document = ModelDocument::read_package(file, limits)?;
    let metadata = &document.start_part().metadata;
    let locked = metadata.nestd_value("arrangement").is_some_and(|a| a == "locked");
    let mut reader = BuildFileReader {
        document: &document,
        flattener: ComponentFlattener::new(&document, limits),
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
    let placed = reader.placed;
    if placed.is_empty() {
        return Err(FileReadError::invalid_threemf("it contains no placements"));
    }
    Ok((build_metadata(metadata), placed))
}

/// Reads only the heading of a build file: the parts that follow it may be damaged.
pub fn read_build_heading(file: &Path, limits: &ReadLimits) -> Result<HeadingMetadata, FileReadError> {
    Ok(heading_metadata(&read_leading_metadata(file, limits)?))
}

fn heading_metadata(metadata: &ModelMetadata) -> HeadingMetadata {
    HeadingMetadata {
        title: metadata.standard_value("Title"),
        application: metadata.standard_value("Application"),
        created: metadata.standard_value("CreationDate"),
        // Earlier versions called a machine by its profile.
        machine: metadata.nestd_value("machine").or_else(|| metadata.nestd_value("profile")),
        build_id: metadata.nestd_value("build"),
        seed: metadata.nestd_value("seed").and_then(|text| text.parse().ok()),
    }
}

fn build_metadata(metadata: &ModelMetadata) -> BuildMetadata {
    let number = |name: &str| metadata.nestd_value(name).and_then(|text| text.parse().ok());
    BuildMetadata {
        heading: heading_metadata(metadata),
        rules: RulesMetadata {
            volume_mm: metadata.nestd_value("volume_mm").and_then(|text| parse_vector(&text)),
            keep_out: metadata.nestd_value("keep_out_mm").map(|text| parse_boxes(&text)).unwrap_or_default(),
            margins_mm: metadata.nestd_value("margins_mm").and_then(|text| parse_vector(&text)),
            clearance_mm: number("clearance_mm"),
            clearance_z_extra_mm: number("clearance_z_extra_mm"),
            layer_mm: number("layer_mm"),
            layer_area_cap_mm2: number("layer_area_cap_mm2"),
            interlock: metadata.nestd_value("interlock"),
        },
        height_mm: number("height_mm"),
        density: number("density"),
    }
}

fn parse_vector(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
    <[f64; 3]>::try_from(numbers).ok().map(DVec3::from_array)
}

/// Parses boxes of six numbers each. A box that cannot be parsed covers everything, so that it is never taken for
/// respected.
fn parse_boxes(text: &str) -> Vec<Bounds> {
    let everywhere = Bounds { min: DVec3::splat(-1e6), max: DVec3::splat(1e6) };
    let corners = |text: &str| -> Option<Bounds> {
        let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
        let [a, b, c, d, e, f] = <[f64; 6]>::try_from(numbers).ok()?;
        Some(Bounds { min: DVec3::new(a, b, c), max: DVec3::new(d, e, f) })
    };
    text.split(';').map(|text| corners(text).unwrap_or(everywhere)).collect()
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
        let mesh = self.object_mesh(key, &name)?;
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
