//! The contents of a build file: meshes, their poses, and what they are for. The writer and the reader share these
//! types.

use std::sync::Arc;

use glam::DVec3;
use solids::{Bounds, Mesh, Pose};

use crate::{Arrangement, DeliveryKind};

/// A build, ready to be written.
#[derive(Debug, Clone)]
pub struct BuildFile {
    /// What the build is, and where it comes from.
    pub heading: BuildFileHeading,
    /// The space and the rules that it was made for.
    pub rules: BuildFileRules,
    /// Top of the highest placement, mm.
    pub height_mm: f64,
    /// Part volume / (base area x build height).
    pub density: f64,
    /// Distinct meshes.
    pub objects: Vec<BuildFileObject>,
    /// One per placed copy.
    pub items: Vec<BuildFileItem>,
    /// What it is written as.
    pub delivery: DeliveryKind,
    /// Whether a consumer of a 3MF may re-arrange the placements.
    pub arrangement: Arrangement,
    /// A PNG picture, shown by file browsers.
    pub thumbnail_png: Option<Vec<u8>>,
}

/// What a build is, and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildFileHeading {
    /// Shown by viewers.
    pub title: String,
    /// Name and version of the program, e.g. `nestd 0.1.0`.
    pub application: String,
    /// RFC 3339, e.g. `2026-11-20T04:49:00Z`; the only clock in the file.
    pub created: String,
    /// Machine.
    pub machine: String,
    /// The ledger's number of the build, as in the file's name. UUIDs are derived from it.
    pub build_id: String,
    /// Seed of the search.
    pub seed: u64,
}

/// The space and the rules that a build was made for.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildFileRules {
    /// Edge lengths of the build volume, mm.
    pub volume_mm: DVec3,
    /// Keep-out boxes of the build volume, in which no part may be placed, mm.
    pub keep_out: Vec<Bounds>,
    /// Margins along the walls, above the floor and below the ceiling, mm.
    pub margins_mm: DVec3,
    /// Least distance between the surfaces of two placements, mm.
    pub clearance_mm: f64,
    /// The clearance also holds when either of two placements is raised by up to this, mm.
    pub clearance_z_extra_mm: f64,
    /// Thickness of a layer, mm. Layers are counted from the top of the floor margin.
    pub layer_mm: f64,
    /// Greatest filled area of a layer, mm2.
    pub layer_area_cap_mm2: Option<f64>,
    /// The interlock rule of the build, as settings spell it (`forbid`, `warn`, `allow`).
    pub interlock: String,
}

/// One distinct mesh of a build.
#[derive(Debug, Clone)]
pub struct BuildFileObject {
    /// Name of the part.
    pub name: String,
    /// In mm, in its own frame.
    pub mesh: Arc<Mesh>,
    /// The farm's number of the part.
    pub part_number: String,
    /// Hash of the part's content; UUIDs are derived from it.
    pub content_hash: String,
}

/// What the order of a copy says, for the people who unpack the build.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OrderWords {
    /// Order or kit to which the copy belongs.
    pub order: Option<String>,
    /// When it is due, as people read it.
    pub due: Option<String>,
    /// The customer's note.
    pub note: Option<String>,
    /// What the customer's own system calls the line.
    pub reference: Option<String>,
    /// What the build is made of.
    pub material: Option<String>,
}

/// One placed copy.
#[derive(Debug, Clone)]
pub struct BuildFileItem {
    /// Index into [`BuildFile::objects`].
    pub object: usize,
    /// Mesh frame -> machine frame (origin bottom front left, z up), mm.
    pub pose: Pose,
    /// What its order says of it.
    pub words: OrderWords,
    /// Copy number, from 1.
    pub copy: u32,
    /// File name under which the part was dropped.
    pub source_name: String,
    /// BLAKE3 of the dropped file.
    pub source_hash: String,
    /// Clearance of this part, mm.
    pub clearance_mm: Option<f64>,
    /// The orientation rule under which the part was placed, as settings spell it (`free`, `upright`, ...).
    pub orientation: Option<String>,
    /// Directions that had to point nearly straight up, as a line of text (`0,0,1:30;...`).
    pub tilts: Option<String>,
}

/// One placed copy, as read from a build file.
#[derive(Debug, Clone)]
pub struct PlacedMesh {
    /// Name of the object.
    pub name: String,
    /// In mm; copies of one object share it.
    pub mesh: Arc<Mesh>,
    /// Mesh frame -> machine frame, mm.
    pub pose: Pose,
    /// `partnumber` of the item, else of the object.
    pub part_number: Option<String>,
    /// Copy number, from 1.
    pub copy: Option<u32>,
    /// What its order says of it.
    pub words: OrderWords,
    /// File name under which the part was dropped.
    pub source_name: Option<String>,
    /// BLAKE3 of the dropped file.
    pub source_hash: Option<String>,
    /// Clearance of this part, mm.
    pub clearance_mm: Option<f64>,
    /// The orientation rule under which the part was placed.
    pub orientation: Option<String>,
    /// Directions that had to point nearly straight up.
    pub tilts: Option<String>,
}

/// The metadata of a build file; `None` where another packer wrote the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BuildMetadata {
    /// What the build is, and where it comes from.
    pub heading: HeadingMetadata,
    /// The space and the rules that it was made for.
    pub rules: RulesMetadata,
    /// Top of the highest placement, mm.
    pub height_mm: Option<f64>,
    /// Part volume / (base area x build height).
    pub density: Option<f64>,
}

/// The values of [`BuildFileHeading`] that a file contains.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeadingMetadata {
    /// Shown by viewers.
    pub title: Option<String>,
    /// Program that wrote it.
    pub application: Option<String>,
    /// Creation time.
    pub created: Option<String>,
    /// Machine.
    pub machine: Option<String>,
    /// The ledger's number of the build.
    pub build_id: Option<String>,
    /// Seed of the search.
    pub seed: Option<u64>,
}

/// The values of [`BuildFileRules`] that a file contains.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RulesMetadata {
    /// Edge lengths of the build volume, mm.
    pub volume_mm: Option<DVec3>,
    /// Keep-out boxes of the build volume, in which no part may be placed, mm.
    pub keep_out: Vec<Bounds>,
    /// Margins along the walls, above the floor and below the ceiling, mm.
    pub margins_mm: Option<DVec3>,
    /// Least distance between the surfaces of two placements, mm.
    pub clearance_mm: Option<f64>,
    /// The clearance also holds when either of two placements is raised by up to this, mm.
    pub clearance_z_extra_mm: Option<f64>,
    /// Thickness of a layer, mm. Layers are counted from the top of the floor margin.
    pub layer_mm: Option<f64>,
    /// Greatest filled area of a layer, mm2.
    pub layer_area_cap_mm2: Option<f64>,
    /// The interlock rule of the build.
    pub interlock: Option<String>,
}
