//! The door for dropped files: which format it is, then its reader.

use std::path::Path;

use super::{Limits, ReadError, Unit};
use crate::geometry::Mesh;

/// What a dropped file holds.
#[derive(Debug, Clone)]
pub struct Contents {
    /// The parts in it, at least one.
    pub solids: Vec<Solid>,
    /// What a person should know about the file as a whole; sentences.
    pub warnings: Vec<String>,
}

/// One part of a dropped file.
#[derive(Debug, Clone)]
pub struct Solid {
    /// The name that the file gives it, else the dropped name's stem.
    pub name: String,
    /// In mm. Not necessarily closed: see [`Mesh::defects`].
    pub mesh: Mesh,
    /// How often the file itself asks for it, at least 1.
    pub copies: u32,
    /// What a person should know about this part; sentences.
    pub warnings: Vec<String>,
}

/// Reads a dropped file. `name` is the name that it was dropped under (the file may lie in the store under another); content
/// decides the format first, the name's extension second. `unit` is the ticket's and wins over the unit that a 3MF names;
/// `default_unit` is for formats without one. Nothing is ever rescaled otherwise.
pub fn read(
    file: &Path,
    name: &str,
    unit: Option<Unit>,
    default_unit: Unit,
    limits: &Limits,
) -> Result<Contents, ReadError> {
    let _ = (file, unit, default_unit, limits);
    Err(ReadError::Unknown(name.to_owned()))
}
