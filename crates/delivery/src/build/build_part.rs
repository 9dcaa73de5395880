//! A part of a build, and the placement of a copy.

use std::sync::Arc;

use build_file::OrderWords;
use nester::{NestingItem, OrientationLimits};
use solids::{Mesh, Pose};

/// A part of a build with its wanted copies.
#[derive(Debug, Clone)]
pub struct BuildPart {
    /// Its name in messages and reports.
    pub name: String,
    /// Name of its object in the build file.
    pub object_name: String,
    /// Its number in the build file, unique within the build.
    pub part_number: String,
    /// Name of its source file.
    pub source_name: String,
    /// BLAKE3 of the source file.
    pub source_hash: String,
    /// Identifies the solid and its source file.
    pub content_hash: String,
    /// The solid, mm.
    pub mesh: Arc<Mesh>,
    /// Wanted copy numbers, from 0.
    pub copies: Vec<u32>,
    /// Allowed orientations.
    pub orientation: OrientationLimits,
    /// Clearance of this part, mm; `None` = that of the machine.
    pub clearance_mm: Option<f64>,
    /// What its order says of it.
    pub words: OrderWords,
}

impl BuildPart {
    /// The part as an item of the nester.
    pub fn to_item(&self) -> NestingItem {
        NestingItem {
            name: self.name.clone(),
            mesh: self.mesh.clone(),
            copies: self.copies.len() as u32,
            orientation: self.orientation.clone(),
            clearance_mm: self.clearance_mm,
        }
    }
}

/// The placement of one copy of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct PartPlacement {
    /// Index of the part.
    pub part: usize,
    /// Number of the copy, from 0.
    pub copy: u32,
    /// Mesh frame -> build volume frame, mm.
    pub pose: Pose,
}
