//! The door for dropped files: which format it is, then its reader.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use glam::DVec3;

use super::{
    Contents, Limits, ReadError, Unit,
    sniff::{Foreign, HEAD_BYTES, Kind, kind},
    solid,
    stl_read::{StlSoup, read_ascii, read_binary},
    threemf_read,
};

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
    let mut opened = File::open(file)?;
    let len = opened.metadata()?.len();
    if len > limits.max_bytes {
        return Err(ReadError::TooLarge {
            what: format!("it is {len} bytes long"),
            limit: limits.max_bytes,
            key: "max_bytes",
        });
    }
    let mut head = Vec::new();
    (&mut opened).take(HEAD_BYTES).read_to_end(&mut head)?;
    let stem = PathBuf::from(name).file_stem().map_or_else(|| name.to_owned(), |s| s.to_string_lossy().into_owned());
    let stl_unit = unit.unwrap_or(default_unit);
    let contents = match kind(&head, len, name) {
        Kind::Package => threemf_read::read_dropped(file, &stem, unit, limits),
        Kind::TextStl => stl_contents(read_ascii(File::open(file)?, limits)?, stem, stl_unit),
        Kind::BinaryStl => stl_contents(read_binary(opened, &head, len, limits)?, stem, stl_unit),
        Kind::Other(Foreign { what, remedy }) => Err(ReadError::Unknown { what, remedy }),
    }?;
    for solid in &contents.solids {
        let shells = solid.mesh.shells() as u64;
        if shells > limits.max_shells {
            let what = format!("{} is made of {shells} pieces that do not hang together", solid.name);
            return Err(ReadError::TooLarge { what, limit: limits.max_shells, key: "max_shells" });
        }
    }
    Ok(contents)
}

/// A whole STL file is one part, also with several `solid` blocks: as dropped.
fn stl_contents(soup: StlSoup, name: String, unit: Unit) -> Result<Contents, ReadError> {
    let StlSoup { mut corners, warnings } = soup;
    if let Some(vertex) = corners.iter().position(|c| !c.is_finite()) {
        return Err(ReadError::stl(format!(
            "triangle {} has a coordinate that is not a finite number",
            vertex / 3 + 1
        )));
    }
    let scale = unit.mm();
    corners.iter_mut().for_each(|c: &mut DVec3| *c *= scale);
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let solid = solid::solid(name, corners, triangles, 1, unit)?;
    Ok(Contents { solids: vec![solid], warnings })
}
