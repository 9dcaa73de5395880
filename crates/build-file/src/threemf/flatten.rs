//! Flattens objects made of components into one triangle soup each, and checks cycles, depth and counts.

use std::{borrow::Cow, collections::BTreeSet};

use glam::{DAffine3, DVec3};

use super::{
    document::{ModelDocument, ObjectKey},
    model::{ModelObject, ObjectBody, ObjectKind, ObjectReference},
};
use crate::{FileReadError, ReadLimits, common::decimal::step_of};

/// Flattens objects of one document and counts the copied elements.
pub(crate) struct ComponentFlattener<'a> {
    document: &'a ModelDocument,
    limits: &'a ReadLimits,
    instances: u64,
    triangles: u64,
    vertices: u64,
}

/// A triangle soup and properties of the objects in it.
#[derive(Debug, Default)]
pub(crate) struct FlattenedObject {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(super) sliced: bool,
    /// See [`crate::PartFileSolid::coordinate_step_mm`].
    pub(crate) coordinate_step_mm: f64,
    /// What is in it and no model volume.
    pub(crate) left_out: BTreeSet<String>,
}

impl<'a> ComponentFlattener<'a> {
    pub(crate) fn new(document: &'a ModelDocument, limits: &'a ReadLimits) -> Self {
        Self { document, limits, instances: 0, triangles: 0, vertices: 0 }
    }

    /// Collects all meshes of an object, transformed by `transform` and then scaled. Triangle orientation is kept if a
    /// transform mirrors.
    pub(crate) fn flatten_object(
        &mut self,
        key: ObjectKey,
        transform: DAffine3,
        scale: f64,
    ) -> Result<FlattenedObject, FileReadError> {
        let mut flat = FlattenedObject::default();
        let scaled = DAffine3::from_scale(DVec3::splat(scale)) * transform;
        self.collect_meshes(key, scaled, &mut Vec::new(), &mut flat)?;
        Ok(flat)
    }

    fn collect_meshes(
        &mut self,
        key: ObjectKey,
        transform: DAffine3,
        above: &mut Vec<ObjectKey>,
        flat: &mut FlattenedObject,
    ) -> Result<(), FileReadError> {
        if above.contains(&key) {
            return Err(FileReadError::invalid_threemf(format!("object {} is a component of itself", key.id())));
        }
        if above.len() as u64 > u64::from(self.limits.max_depth) {
            let what = "its components are nested too deeply".to_owned();
            return Err(FileReadError::TooLarge { what, limit: self.limits.max_depth.into(), key: "max_depth" });
        }
        self.instances += 1;
        if self.instances > self.limits.max_instances {
            let what = "it has too many component instances".to_owned();
            return Err(FileReadError::TooLarge { what, limit: self.limits.max_instances, key: "max_instances" });
        }
        let object = self.document.object(key);
        check_object(key, object, transform)?;
        flat.sliced |= object.sliced;
        match &object.body {
            ObjectBody::Mesh { vertices, triangles } => {
                let kept = self.model_triangles(key, triangles, flat)?;
                self.append_mesh(vertices, &kept, transform, flat)
            }
            ObjectBody::Components(components) => {
                above.push(key);
                for (at, component) in components.iter().enumerate() {
                    let inner = self.document.resolve_reference(component, Some(key))?;
                    if !self.is_model_volume(key, (at, component), inner, flat)? {
                        continue;
                    }
                    self.collect_meshes(inner, transform * component.transform, above, flat)?;
                }
                above.pop();
                Ok(())
            }
        }
    }

    /// The triangles of an object's mesh without those of volumes that are no model volumes.
    fn model_triangles(
        &self,
        key: ObjectKey,
        triangles: &'a [[u32; 3]],
        flat: &mut FlattenedObject,
    ) -> Result<Cow<'a, [[u32; 3]]>, FileReadError> {
        if !key.is_in_start_part() {
            return Ok(triangles.into());
        }
        let shown = self.document.shown_object(key);
        let ranges =
            self.document.project.left_out_triangles((key.id(), &shown), triangles.len(), &mut flat.left_out)?;
        if ranges.is_empty() {
            return Ok(triangles.into());
        }
        let (mut kept, mut from) = (Vec::new(), 0);
        for range in ranges {
            kept.extend_from_slice(&triangles[from..range.start.max(from)]);
            from = from.max(range.end);
        }
        kept.extend_from_slice(&triangles[from..]);
        Ok(kept.into())
    }

    /// Whether a component is printed: the slicer's project says what it is for, or else the type of its object does.
    fn is_model_volume(
        &self,
        object: ObjectKey,
        (at, component): (usize, &ObjectReference),
        inner: ObjectKey,
        flat: &mut FlattenedObject,
    ) -> Result<bool, FileReadError> {
        let project = &self.document.project;
        let volume = project.volume_of_component(object.id(), at, component.object);
        if let Some(volume) = volume.filter(|_| object.is_in_start_part()) {
            return volume.is_model(&self.document.shown_object(object), &mut flat.left_out);
        }
        let shown = || self.document.shown_object(inner);
        match self.document.object(inner).kind {
            ObjectKind::Part => Ok(true),
            ObjectKind::Support => {
                flat.left_out.insert(format!("support {}", shown()));
                Ok(false)
            }
            ObjectKind::Other => Err(FileReadError::Unsupported {
                what: format!(
                    "{} contains {}, which is of the type \"other\": it must not be printed, and may have to be cut out",
                    self.document.shown_object(object),
                    shown()
                ),
                remedy: "Export what is to be printed from the slicer or the CAD program as STL, and drop that.",
            }),
        }
    }

    fn append_mesh(
        &mut self,
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        transform: DAffine3,
        flat: &mut FlattenedObject,
    ) -> Result<(), FileReadError> {
        self.triangles += triangles.len() as u64;
        self.vertices += vertices.len() as u64;
        // Vertices count too: they are copied even if no triangle uses them.
        if self.triangles.max(self.vertices / 3) > self.limits.max_triangles {
            let what = "all its instances together have too many triangles".to_owned();
            return Err(FileReadError::TooLarge { what, limit: self.limits.max_triangles, key: "max_triangles" });
        }
        let farthest = vertices.iter().fold(DVec3::ZERO, |farthest, vertex| farthest.max(vertex.abs())).max_element();
        let [x, y, z] = [0, 1, 2].map(|axis| transform.matrix3.col(axis).length());
        flat.coordinate_step_mm = flat.coordinate_step_mm.max(step_of(farthest) * x.max(y).max(z));
        let first = flat.vertices.len() as u32;
        if transform == DAffine3::IDENTITY {
            flat.vertices.extend_from_slice(vertices);
        } else {
            flat.vertices.extend(vertices.iter().map(|&v| transform.transform_point3(v)));
        }
        let mirrored = transform.matrix3.determinant() < 0.0;
        flat.triangles.extend(triangles.iter().map(|&[a, b, c]| {
            let [b, c] = if mirrored { [c, b] } else { [b, c] };
            [first + a, first + b, first + c]
        }));
        Ok(())
    }
}

/// Refuses objects whose shape is not in their triangles, and singular transforms.
fn check_object(key: ObjectKey, object: &ModelObject, transform: DAffine3) -> Result<(), FileReadError> {
    if object.lattice {
        return Err(FileReadError::Unsupported {
            what: format!("object {} is a beam lattice: its shape is in beams, not in triangles", key.id()),
            remedy: "Turn the beams into a mesh in the CAD program, and export that.",
        });
    }
    if !transform.is_finite() || transform.matrix3.determinant().abs() < 1e-12 {
        let reason = format!("object {} has a transform that is singular, so no volume", key.id());
        return Err(FileReadError::invalid_threemf(reason));
    }
    Ok(())
}
