//! Reads the requested parts: arguments and lists become meshes with copies.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Result};
use delivery::build::BuildPart;
use solids::Mesh;

use super::{args::NestArgs, setup::NestingSetup};
use crate::cli::{UsageError, terminal::table::print_to_stderr};

/// A part file that the user requested.
pub struct RequestedFile {
    /// Its name for people.
    pub name: String,
    /// The path of the file.
    pub file: PathBuf,
    /// Copies of each solid in it; `None` = not said.
    pub copies: Option<u32>,
}

/// All requested files, not read yet.
pub fn requested_files(args: &NestArgs) -> Result<Vec<RequestedFile>> {
    let mut rows =
        args.source.parts.iter().map(|text| parse_part_argument(text)).collect::<Result<Vec<RequestedFile>>>()?;
    if args.source.list.is_some() {
        rows.extend(read_part_list(args)?);
    }
    Ok(rows)
}

/// Reads all parts; warnings go to standard error.
pub fn read_parts(rows: Vec<RequestedFile>, setup: &NestingSetup) -> Result<Vec<BuildPart>> {
    // Files with the same content are read once, so that the search shares all work on them.
    let mut known: BTreeMap<String, Vec<(String, Arc<Mesh>, u32)>> = BTreeMap::new();
    let mut parts = Vec::new();
    for row in rows {
        let unusable = |error: anyhow::Error| UsageError(format!("{}: {error:#}", row.name));
        let source_hash = blake3::hash(&read_bytes(&row.file).map_err(unusable)?).to_hex().to_string();
        if !known.contains_key(&source_hash) {
            let contents = build_file::read_part_file(&row.file, &row.name, None, setup.unit, &setup.limits)
                .map_err(|error| unusable(error.into()))?;
            let solid_warnings = contents
                .solids
                .iter()
                .flat_map(|s| s.warnings.iter().chain(&s.question).map(move |w| format!("{}: {w}", s.name)));
            for warning in contents.warnings.iter().cloned().chain(solid_warnings) {
                print_to_stderr(&format!("{}: {warning}", row.name));
            }
            let solids = contents.solids.into_iter().map(|s| (s.name, s.mesh, s.copies)).collect();
            known.insert(source_hash.clone(), solids);
        }
        let solids = &known[&source_hash];
        for (solid, mesh, copies) in solids {
            // The name of the solid is added where a file holds several.
            let name = if solids.len() > 1 { format!("{} ({solid})", row.name) } else { row.name.clone() };
            parts.push(BuildPart {
                name: name.clone(),
                object_name: name,
                part_number: (parts.len() + 1).to_string(),
                source_name: row.name.clone(),
                source_hash: source_hash.clone(),
                content_hash: format!("{source_hash}-{}", parts.len()),
                mesh: mesh.clone(),
                copies: (0..copies.saturating_mul(row.copies.unwrap_or(1))).collect(),
                orientation: setup.orientation.clone(),
                clearance_mm: None,
                words: Default::default(),
            });
        }
    }
    Ok(parts)
}

/// Parses `bracket.stl` or `bracket.stl=4`. An existing file whose name itself ends in `=4` is taken as that file.
pub fn parse_part_argument(text: &str) -> Result<RequestedFile> {
    let whole = PathBuf::from(text);
    let split = text.rsplit_once('=').and_then(|(name, copies)| Some((name, copies.parse::<u32>().ok()?)));
    let (name, copies) = match split {
        Some((name, copies)) if !whole.exists() => (name.to_owned(), Some(copies)),
        _ => (text.to_owned(), None),
    };
    if copies == Some(0) {
        return Err(UsageError(format!("{text}: 0 copies are none; leave the part out")).into());
    }
    let file = PathBuf::from(&name);
    let short = file.file_name().map_or_else(|| name.clone(), |n| n.to_string_lossy().into_owned());
    Ok(RequestedFile { name: short, file, copies })
}

/// Reads the rows of the list.
fn read_part_list(args: &NestArgs) -> Result<Vec<RequestedFile>> {
    let Some(list) = &args.source.list else { return Ok(Vec::new()) };
    let base = args.source.base.clone().or_else(|| list.parent().map(PathBuf::from)).unwrap_or_default();
    let wrong = |what: String| UsageError(format!("{}: {what}", list.display()));
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .flexible(true)
        .from_path(list)
        .map_err(|error| wrong(error.to_string()))?;
    let headers = reader.headers().map_err(|error| wrong(error.to_string()))?.clone();
    let named = |header: &str| header.trim_start_matches('\u{feff}').to_ascii_lowercase();
    let column = |names: &[&str]| headers.iter().position(|h| names.contains(&named(h).as_str()));
    let file_column = column(&["file"]).ok_or_else(|| wrong("there is no column `file`".to_owned()))?;
    let copies_column = column(&["quantity", "copies"]);
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| wrong(error.to_string()))?;
        let name = record.get(file_column).unwrap_or_default().to_owned();
        let line = record.position().map_or(0, csv::Position::line);
        if name.is_empty() {
            return Err(wrong(format!("line {line} names no file")).into());
        }
        let copies = match copies_column.and_then(|c| record.get(c)).filter(|text| !text.is_empty()) {
            Some(text) => text.parse().map_err(|_| wrong(format!("line {line}: {text:?} is no number of copies")))?,
            None => 1,
        };
        rows.push(RequestedFile { file: base.join(&name), name, copies: Some(copies) });
    }
    Ok(rows)
}

/// Reads the bytes of a file to hash them; an error names the file.
fn read_bytes(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("reading {}", file.display()))
}
