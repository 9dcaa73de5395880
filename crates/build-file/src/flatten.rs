//! Flattens objects made of components into one triangle soup each, and checks cycles, depth and counts.

use glam::{DAffine3, DVec3};

use super::{
    FileReadError, ReadLimits,
    document::{ModelDocument, ObjectKey},
    model::{ModelObject, ObjectBody},
};

/// Flattens objects of one document and counts the copied elements.
pub(super) struct ComponentFlattener<'a> {
    document: &'a ModelDocument,
    limits: &'a ReadLimits,
    instances: u64,
    triangles: u64,
    vertices: u64,
}

/// A triangle soup and properties of the objects in it.
#[derive(Debug, Default)]
pub(super) struct FlattenedObject {
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) sliced: bool,
}

impl<'a> ComponentFlattener<'a> {
    pub(super) fn new(document: &'a ModelDocument, limits: &'a ReadLimits) -> Self {
        Self { document, limits, instances: 0, triangles: 0, vertices: 0 }
    }

    /// Collects all meshes of an object, transformed by `transform` and then scaled. Triangle orientation is kept if a
    /// transform mirrors.
    pub(super) fn flatten_object(
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
            ObjectBody::Mesh { vertices, triangles } => self.append_mesh(vertices, triangles, transform, flat),
            ObjectBody::Components(components) => {
                above.push(key);
                for component in components {
                    let inner = self.document.resolve_reference(component, Some(key))?;
                    self.collect_meshes(inner, transform * component.transform, above, flat)?;
                }
                above.pop();
                Ok(())
            }
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
