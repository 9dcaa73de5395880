//! A part of a build, and where its copies stand.

use std::sync::Arc;

use nester::{Item, Orientation};
use solids::{Mesh, Pose};

/// A part of a build with the copies of it that are wanted.
#[derive(Debug, Clone)]
pub struct BuildPart {
    /// Its name in messages and reports.
    pub name: String,
    /// Name of its object in the build file.
    pub object_name: String,
    /// Its number in the build file; no other part of the build has it.
    pub part_number: String,
    /// Name of the file that it came from.
    pub source_name: String,
    /// BLAKE3 of that file.
    pub source_hash: String,
    /// Says which solid of which file it is.
    pub content_hash: String,
    /// The solid, mm.
    pub mesh: Arc<Mesh>,
    /// Numbers of the wanted copies, from 0.
    pub copies: Vec<u32>,
    /// How it may be turned.
    pub orientation: Orientation,
    /// A clearance of its own, mm.
    pub clearance_mm: Option<f64>,
    /// Order or kit that it is for.
    pub order: Option<String>,
}

impl BuildPart {
    /// As the nester sees it.
    pub fn item(&self) -> Item {
        Item {
            name: self.name.clone(),
            mesh: self.mesh.clone(),
            copies: self.copies.len() as u32,
            orientation: self.orientation.clone(),
            clearance_mm: self.clearance_mm,
        }
    }
}

/// Where one copy of a part stands.
#[derive(Debug, Clone, PartialEq)]
pub struct PartPlacement {
    /// Index of the part.
    pub part: usize,
    /// Number of the copy, from 0.
    pub copy: u32,
    /// Mesh frame -> build volume frame, mm.
    pub pose: Pose,
}
