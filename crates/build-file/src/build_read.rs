//! `.build.3mf` -> meshes and poses, for the proof of what was written.

use std::{collections::HashMap, path::Path, sync::Arc};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use solids::{Bounds, Mesh, Pose};

use super::{
    BuildInfo, Limits, PlacedMesh, ReadError,
    document::{Document, ObjectKey},
    flatten::Flattener,
    model::{Body, Item, Metadata, Reference},
    solid::checked_mesh,
};

/// How far a written rotation may be from one: files print 6 digits and more.
const RIGID: f64 = 1e-5;

/// Every placed copy of a build file; items of one object share the mesh. Reads the files of other packers too: items with
/// components are flattened. A transform that is not rigid is an error that names the item.
pub fn read_build(file: &Path, limits: &Limits) -> Result<Vec<PlacedMesh>, ReadError> {
    Ok(read_build_and_info(file, limits)?.1)
}

/// As [`read_build`], with what the file says about itself.
pub fn read_build_and_info(file: &Path, limits: &Limits) -> Result<(BuildInfo, Vec<PlacedMesh>), ReadError> {
    let document = Document::read(file, limits)?;
    let metadata = &document.start().metadata;
    let locked = metadata.nestd("arrangement").is_some_and(|a| a == "locked");
    let mut reader = Reader {
        document: &document,
        flattener: Flattener::new(&document, limits),
        scale: document.start().unit.mm(),
        meshes: HashMap::new(),
        limit: limits.max_instances,
        placed: Vec::new(),
    };
    for (number, item) in (1..).zip(&document.start().items) {
        if item.printable {
            reader.item(number, item, locked)?;
        }
    }
    let placed = reader.placed;
    if placed.is_empty() {
        return Err(ReadError::threemf("it places nothing"));
    }
    Ok((info(metadata), placed))
}

fn info(metadata: &Metadata) -> BuildInfo {
    let number = |name: &str| metadata.nestd(name).and_then(|text| text.parse().ok());
    BuildInfo {
        title: metadata.plain("Title"),
        application: metadata.plain("Application"),
        created: metadata.plain("CreationDate"),
        profile: metadata.nestd("profile"),
        build_id: metadata.nestd("build"),
        seed: metadata.nestd("seed").and_then(|text| text.parse().ok()),
        volume_mm: metadata.nestd("volume_mm").and_then(|text| three_numbers(&text)),
        keep_out: metadata.nestd("keep_out_mm").map(|text| boxes(&text)).unwrap_or_default(),
        margins_mm: metadata.nestd("margins_mm").and_then(|text| three_numbers(&text)),
        clearance_mm: number("clearance_mm"),
        clearance_z_extra_mm: number("clearance_z_extra_mm"),
        layer_mm: number("layer_mm"),
        layer_area_cap_mm2: number("layer_area_cap_mm2"),
        height_mm: number("height_mm"),
        density: number("density"),
        interlock: metadata.nestd("interlock"),
    }
}

fn three_numbers(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
    <[f64; 3]>::try_from(numbers).ok().map(DVec3::from_array)
}

/// Six numbers a box; one that cannot be read is everywhere, so that it is never taken for kept free.
fn boxes(text: &str) -> Vec<Bounds> {
    let everywhere = Bounds { min: DVec3::splat(-1e6), max: DVec3::splat(1e6) };
    let corners = |text: &str| -> Option<Bounds> {
        let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().ok()).collect::<Option<_>>()?;
        let [a, b, c, d, e, f] = <[f64; 6]>::try_from(numbers).ok()?;
        Some(Bounds { min: DVec3::new(a, b, c), max: DVec3::new(d, e, f) })
    };
    text.split(';').map(|text| corners(text).unwrap_or(everywhere)).collect()
}

struct Reader<'a> {
    document: &'a Document,
    flattener: Flattener<'a>,
    scale: f64,
    meshes: HashMap<ObjectKey, Arc<Mesh>>,
    limit: u64,
    placed: Vec<PlacedMesh>,
}

impl Reader<'_> {
    fn item(&mut self, number: usize, item: &Item, locked: bool) -> Result<(), ReadError> {
        let document = self.document;
        let key = document.key(&item.reference, None)?;
        let object = document.object(key);
        let what = format!("build item {number} ({})", object.name.as_deref().unwrap_or("without a name"));
        match &object.body {
            Body::Components(components) if locked => {
                for component in components {
                    self.locked_placement(&what, item.reference.transform, component, key)?;
                }
                Ok(())
            }
            _ => self.place(&what, key, item.reference.transform, &item.metadata, item.part_number.clone()),
        }
    }

    /// A component of our own locked object: an object with the placement's metadata around the mesh that copies share.
    fn locked_placement(
        &mut self,
        what: &str,
        outer: DAffine3,
        component: &Reference,
        locked: ObjectKey,
    ) -> Result<(), ReadError> {
        let document = self.document;
        let wrapper = document.key(component, Some(locked))?;
        let transform = outer * component.transform;
        let object = document.object(wrapper);
        match &object.body {
            Body::Components(inner) if inner.len() == 1 => {
                let mesh = document.key(&inner[0], Some(wrapper))?;
                let part_number = object.part_number.clone();
                self.place(what, mesh, transform * inner[0].transform, &object.metadata, part_number)
            }
            _ => self.place(what, wrapper, transform, &object.metadata, object.part_number.clone()),
        }
    }

    fn place(
        &mut self,
        what: &str,
        key: ObjectKey,
        transform: DAffine3,
        metadata: &Metadata,
        part_number: Option<String>,
    ) -> Result<(), ReadError> {
        if self.placed.len() as u64 >= self.limit {
            return Err(ReadError::TooLarge {
                what: "it has too many placements".to_owned(),
                limit: self.limit,
                key: "max_instances",
            });
        }
        let pose = rigid(transform, self.scale).ok_or_else(|| {
            ReadError::threemf(format!("the transform of {what} is not a rotation and a translation"))
        })?;
        let object = self.document.object(key);
        let name = object.name.clone().unwrap_or_else(|| format!("object {}", key.id()));
        let mesh = self.mesh(key, &name)?;
        self.placed.push(PlacedMesh {
            name,
            mesh,
            pose,
            part_number: part_number.or_else(|| object.part_number.clone()),
            copy: metadata.nestd("copy").and_then(|text| text.parse().ok()),
            order: metadata.nestd("order"),
            source_name: metadata.nestd("source"),
            source_hash: metadata.nestd("source_hash"),
            clearance_mm: metadata.nestd("clearance_mm").and_then(|text| text.parse().ok()),
            orientation: metadata.nestd("orientation"),
            tilts: metadata.nestd("tilts"),
        });
        Ok(())
    }

    /// The mesh of an object in its own frame, made once.
    fn mesh(&mut self, key: ObjectKey, name: &str) -> Result<Arc<Mesh>, ReadError> {
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let flat = self.flattener.flatten(key, DAffine3::IDENTITY, self.scale)?;
        let mesh = Arc::new(checked_mesh(name, flat.vertices, flat.triangles)?);
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }
}

/// The pose that a transform is, `None` where it scales, shears or mirrors. `scale` is millimetres per unit.
fn rigid(transform: DAffine3, scale: f64) -> Option<Pose> {
    let matrix = transform.matrix3;
    let off = matrix.transpose() * matrix - DMat3::IDENTITY;
    let farthest = off.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
    let is_rotation = farthest <= RIGID && matrix.determinant() > 0.0;
    is_rotation.then(|| Pose::new(DQuat::from_mat3(&matrix), transform.translation * scale))
}
