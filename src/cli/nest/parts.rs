//! Which parts are asked for: arguments and lists -> meshes with copies.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Result};
use solids::Mesh;

use super::{args::Args, setup::Setup};
use crate::{
    build::BuildPart,
    cli::{Usage, table::tell},
};

/// A file that is asked for.
pub struct Row {
    name: String,
    /// Where it is.
    pub file: PathBuf,
    copies: u32,
}

/// All files that are asked for, not read yet.
pub fn rows(args: &Args) -> Result<Vec<Row>> {
    let mut rows = args.source.parts.iter().map(|text| row_of(text)).collect::<Result<Vec<Row>>>()?;
    if args.source.list.is_some() {
        rows.extend(listed(args)?);
    }
    Ok(rows)
}

/// Reads all parts; warnings go to the terminal's error output.
pub fn read(rows: Vec<Row>, setup: &Setup) -> Result<Vec<BuildPart>> {
    // Equal files are read once, so that the search shares all work on them.
    let mut known: BTreeMap<String, Vec<(String, Arc<Mesh>, u32)>> = BTreeMap::new();
    let mut parts = Vec::new();
    for row in rows {
        let unusable = |error: anyhow::Error| Usage(format!("{}: {error:#}", row.name));
        let source_hash = blake3::hash(&bytes_of(&row.file).map_err(unusable)?).to_hex().to_string();
        if !known.contains_key(&source_hash) {
            let contents = build_file::read(&row.file, &row.name, None, setup.unit, &setup.limits)
                .map_err(|error| unusable(error.into()))?;
            let solid_warnings =
                contents.solids.iter().flat_map(|s| s.warnings.iter().map(move |w| format!("{}: {w}", s.name)));
            for warning in contents.warnings.iter().cloned().chain(solid_warnings) {
                tell(&format!("{}: {warning}", row.name));
            }
            let solids = contents.solids.into_iter().map(|s| (s.name, Arc::new(s.mesh), s.copies)).collect();
            known.insert(source_hash.clone(), solids);
        }
        let solids = &known[&source_hash];
        for (solid, mesh, copies) in solids {
            // The solid's name is told where a file holds several.
            let name = if solids.len() > 1 { format!("{} ({solid})", row.name) } else { row.name.clone() };
            parts.push(BuildPart {
                name: name.clone(),
                object_name: name,
                part_number: (parts.len() + 1).to_string(),
                source_name: row.name.clone(),
                source_hash: source_hash.clone(),
                content_hash: format!("{source_hash}-{}", parts.len()),
                mesh: mesh.clone(),
                copies: (0..copies.saturating_mul(row.copies)).collect(),
                orientation: setup.orientation.clone(),
                clearance_mm: None,
                order: None,
            });
        }
    }
    Ok(parts)
}

/// `bracket.stl` or `bracket.stl=4`; a file whose own name ends so is taken as it is.
fn row_of(text: &str) -> Result<Row> {
    let whole = PathBuf::from(text);
    let split = text.rsplit_once('=').and_then(|(name, copies)| Some((name, copies.parse::<u32>().ok()?)));
    let (name, copies) = match split {
        Some((name, copies)) if !whole.exists() => (name.to_owned(), copies),
        _ => (text.to_owned(), 1),
    };
    if copies == 0 {
        return Err(Usage(format!("{text}: 0 copies are none; leave the part out")).into());
    }
    let file = PathBuf::from(&name);
    let short = file.file_name().map_or_else(|| name.clone(), |n| n.to_string_lossy().into_owned());
    Ok(Row { name: short, file, copies })
}

/// The rows of the list.
fn listed(args: &Args) -> Result<Vec<Row>> {
    let Some(list) = &args.source.list else { return Ok(Vec::new()) };
    let base = args.source.base.clone().or_else(|| list.parent().map(PathBuf::from)).unwrap_or_default();
    let wrong = |what: String| Usage(format!("{}: {what}", list.display()));
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
        rows.push(Row { file: base.join(&name), name, copies });
    }
    Ok(rows)
}

/// Reads a file's bytes for a hash, with the name in the error.
fn bytes_of(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).with_context(|| format!("reading {}", file.display()))
}
