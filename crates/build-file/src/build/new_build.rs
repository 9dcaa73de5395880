//! Puts a build together for a caller that has meshes and poses, and no farm.

use std::sync::Arc;

use blake3::Hasher;
use glam::DVec3;
use solids::{Mesh, Pose};

use crate::{
    Arrangement, BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, DeliveryKind, OrderWords,
};

/// Creation time of a build whose caller names none, the earliest of a ZIP.
const EARLIEST: &str = "1980-01-01T00:00:00Z";
/// Thickness of a layer of a build whose caller names none, mm.
const LAYER_MM: f64 = 0.1;

impl BuildFile {
    /// An empty build of a machine: `volume_mm` is the edges of its box, and `clearance_mm` the least distance between parts. It is
    /// written as a 3MF. What else a file says of its build has defaults, which the caller may replace: the title, the creation time
    /// (1980, because this crate has no clock), the layers, the picture.
    ///
    /// ```
    /// use std::{io::Cursor, sync::Arc};
    /// use build_file::{BuildFile, write_build};
    /// use build_file::glam::{DQuat, DVec3};
    /// use build_file::solids::{Mesh, Pose};
    ///
    /// let mut build = BuildFile::new(DVec3::new(200.0, 200.0, 300.0), 2.0);
    /// build.heading.title = "two bars".to_owned();
    /// let bar = build.add_object("bar", Arc::new(Mesh::cuboid(DVec3::new(80.0, 10.0, 5.0))?));
    /// for copy in 0..2 {
    ///     build.add_item(bar, copy, Pose::new(DQuat::IDENTITY, DVec3::new(0.0, 20.0 * f64::from(copy), 0.0)));
    /// }
    /// assert_eq!(build.height_mm, 5.0);
    ///
    /// let mut threemf = Cursor::new(Vec::new()); // or a `File`
    /// write_build(&build, &mut threemf)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(volume_mm: DVec3, clearance_mm: f64) -> Self {
        Self {
            heading: BuildFileHeading {
                title: "Build".to_owned(),
                application: concat!("build-file ", env!("CARGO_PKG_VERSION")).to_owned(),
                created: EARLIEST.to_owned(),
                machine: "none".to_owned(),
                build_id: "0".to_owned(),
                seed: 0,
            },
            rules: BuildFileRules {
                volume_mm,
                keep_out: Vec::new(),
                margins_mm: DVec3::ZERO,
                clearance_mm,
                clearance_z_extra_mm: 0.0,
                layer_mm: LAYER_MM,
                layer_area_cap_mm2: None,
                interlock: "forbid".to_owned(),
            },
            height_mm: 0.0,
            density: 0.0,
            objects: Vec::new(),
            items: Vec::new(),
            delivery: DeliveryKind::Shared,
            arrangement: Arrangement::Items,
            thumbnail_png: None,
        }
    }

    /// Adds a mesh in mm and returns its number, for [`BuildFile::add_item`]. A mesh without a placed copy is not written.
    pub fn add_object(&mut self, name: impl Into<String>, mesh: Arc<Mesh>) -> usize {
        let number = self.objects.len();
        let content_hash = hash_of(&mesh);
        self.objects.push(BuildFileObject {
            name: name.into(),
            mesh,
            part_number: (number + 1).to_string(),
            content_hash,
        });
        number
    }

    /// Adds a copy of an object at a pose in the machine, and brings height and density up to date. `copy` counts from 0, as the
    /// placements of a nester do; files count from 1. In the file, the object's name stands for that of its source.
    ///
    /// # Panics
    /// If there is no such object.
    pub fn add_item(&mut self, object: usize, copy: u32, pose: Pose) {
        let (mesh, name) = (&self.objects[object].mesh, &self.objects[object].name);
        let item = BuildFileItem {
            object,
            pose,
            words: OrderWords::default(),
            copy: copy + 1,
            source_name: name.clone(),
            source_hash: self.objects[object].content_hash.clone(),
            clearance_mm: None,
            orientation: None,
            tilts: None,
        };
        let base_mm2 = self.rules.volume_mm.x * self.rules.volume_mm.y;
        let filled_mm3 = self.density * base_mm2 * self.height_mm + mesh.volume_mm3();
        self.height_mm = self.height_mm.max(mesh.bounds_at(&pose).max.z);
        self.density = if self.height_mm > 0.0 { filled_mm3 / (base_mm2 * self.height_mm) } else { 0.0 };
        self.items.push(item);
    }
}

/// BLAKE3 of the corners and triangles of a mesh.
fn hash_of(mesh: &Mesh) -> String {
    let mut hasher = Hasher::new();
    for corner in mesh.vertices() {
        corner.to_array().iter().for_each(|coordinate| _ = hasher.update(&coordinate.to_le_bytes()));
    }
    mesh.triangles().iter().flatten().for_each(|corner| _ = hasher.update(&corner.to_le_bytes()));
    hasher.finalize().to_hex().to_string()
}
