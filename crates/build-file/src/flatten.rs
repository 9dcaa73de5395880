//! Objects made of components -> one triangle soup each, with cycles, depth and counts checked.

use glam::{DAffine3, DVec3};

use super::{
    Limits, ReadError,
    document::{Document, ObjectKey},
    model::{Body, Object},
};

/// Flattens objects of one document and keeps count of what it has copied.
pub(super) struct Flattener<'a> {
    document: &'a Document,
    limits: &'a Limits,
    instances: u64,
    triangles: u64,
    vertices: u64,
}

/// A triangle soup and what is to be said about the objects in it.
#[derive(Debug, Default)]
pub(super) struct Flat {
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) sliced: bool,
}

impl<'a> Flattener<'a> {
    pub(super) fn new(document: &'a Document, limits: &'a Limits) -> Self {
        Self { document, limits, instances: 0, triangles: 0, vertices: 0 }
    }

    /// All meshes of an object, moved by `transform` and then scaled; orientation is kept where a transform mirrors.
    pub(super) fn flatten(&mut self, key: ObjectKey, transform: DAffine3, scale: f64) -> Result<Flat, ReadError> {
        let mut flat = Flat::default();
        let scaled = DAffine3::from_scale(DVec3::splat(scale)) * transform;
        self.collect(key, scaled, &mut Vec::new(), &mut flat)?;
        Ok(flat)
    }

    fn collect(
        &mut self,
        key: ObjectKey,
        transform: DAffine3,
        above: &mut Vec<ObjectKey>,
        flat: &mut Flat,
    ) -> Result<(), ReadError> {
        if above.contains(&key) {
            return Err(ReadError::threemf(format!("object {} is a component of itself", key.id())));
        }
        if above.len() as u64 > u64::from(self.limits.max_depth) {
            let what = "its components are nested too deeply".to_owned();
            return Err(ReadError::TooLarge { what, limit: self.limits.max_depth.into(), key: "max_depth" });
        }
        self.instances += 1;
        if self.instances > self.limits.max_instances {
            let what = "it has too many component instances".to_owned();
            return Err(ReadError::TooLarge { what, limit: self.limits.max_instances, key: "max_instances" });
        }
        let object = self.document.object(key);
        check_object(key, object, transform)?;
        flat.sliced |= object.sliced;
        match &object.body {
            Body::Mesh { vertices, triangles } => self.append(vertices, triangles, transform, flat),
            Body::Components(components) => {
                above.push(key);
                for component in components {
                    let inner = self.document.key(component, Some(key))?;
                    self.collect(inner, transform * component.transform, above, flat)?;
                }
                above.pop();
                Ok(())
            }
        }
    }

    fn append(
        &mut self,
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        transform: DAffine3,
        flat: &mut Flat,
    ) -> Result<(), ReadError> {
        self.triangles += triangles.len() as u64;
        self.vertices += vertices.len() as u64;
        // Vertices count too: they are copied even where no triangle names them.
        if self.triangles.max(self.vertices / 3) > self.limits.max_triangles {
            let what = "all its instances together have too many triangles".to_owned();
            return Err(ReadError::TooLarge { what, limit: self.limits.max_triangles, key: "max_triangles" });
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

/// Refuses what the triangles do not tell, and transforms that flatten.
fn check_object(key: ObjectKey, object: &Object, transform: DAffine3) -> Result<(), ReadError> {
    if object.lattice {
        return Err(ReadError::Unsupported {
            what: format!("object {} is a beam lattice: its shape is in beams, not in triangles", key.id()),
            remedy: "Turn the beams into a mesh in the CAD program, and export that.",
        });
    }
    if !transform.is_finite() || transform.matrix3.determinant().abs() < 1e-12 {
        let reason = format!("object {} has a transform that is singular, so no volume", key.id());
        return Err(ReadError::threemf(reason));
    }
    Ok(())
}
