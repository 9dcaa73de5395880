//! Compares a list of expected parts with the meshes of a build file. It compares geometry, because other packers
//! change names.

use std::path::Path;

use anyhow::{Context, Result};
use build_file::{LengthUnit, PlacedMesh, ReadLimits};
use solids::Mesh;

use crate::cli::UsageError;

/// Relative difference that two readings of one mesh may have: other packers write fewer digits.
const SHAPE_TOLERANCE: f64 = 1e-5;

/// A mesh that the build file must contain.
pub struct ExpectedPart {
    name: String,
    copies: usize,
    shape: ShapeSignature,
}

/// Properties of a mesh that do not change when it is moved, rotated or written again.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ShapeSignature {
    triangles: usize,
    volume_mm3: f64,
    area_mm2: f64,
    /// Sum over all triangles of area times squared distance from the center of the surface, mm4.
    spread_mm4: f64,
}

impl ShapeSignature {
    fn from_mesh(mesh: &Mesh) -> Self {
        let corners = || (0..mesh.triangles().len()).map(|t| mesh.corners(t));
        let area = |[a, b, c]: [glam::DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
        let area_mm2: f64 = corners().map(area).sum();
        let middle = |[a, b, c]: [glam::DVec3; 3]| (a + b + c) / 3.0;
        let center = corners().map(|t| middle(t) * area(t)).sum::<glam::DVec3>() / area_mm2;
        let spread_mm4 = corners().map(|t| area(t) * (middle(t) - center).length_squared()).sum();
        Self { triangles: mesh.triangles().len(), volume_mm3: mesh.volume_mm3(), area_mm2, spread_mm4 }
    }

    fn matches_shape(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= SHAPE_TOLERANCE * a.abs().max(b.abs());
        self.triangles == other.triangles
            && close(self.volume_mm3, other.volume_mm3)
            && close(self.area_mm2, other.area_mm2)
            && close(self.spread_mm4, other.spread_mm4)
    }
}

/// Reads a list with the columns `file` and `copies` (or `quantity`; 1 when there is none), and the files that it names.
pub fn read_expected_parts(list: &Path, base: &Path, limits: &ReadLimits) -> Result<Vec<ExpectedPart>> {
    let unreadable = |error: csv::Error| UsageError(format!("{}: {error}", list.display()));
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_path(list).map_err(unreadable)?;
    let headers = reader.headers().map_err(unreadable)?.clone();
    let column = |names: &[&str]| headers.iter().position(|h| names.contains(&h.to_ascii_lowercase().as_str()));
    let file_column =
        column(&["file"]).ok_or_else(|| UsageError(format!("{}: there is no column `file`", list.display())))?;
    let copies_column = column(&["copies", "quantity"]);
    let mut expected = Vec::new();
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let name = record.get(file_column).unwrap_or_default().to_owned();
        let copies: usize = match copies_column.and_then(|c| record.get(c)).filter(|text| !text.is_empty()) {
            Some(text) => text.parse().with_context(|| format!("{name}: {text:?} is no number of copies"))?,
            None => 1,
        };
        let contents = build_file::read_part_file(&base.join(&name), &name, None, LengthUnit::Millimeter, limits)
            .map_err(|error| UsageError(format!("{name}: {:#}", anyhow::Error::from(error))))?;
        let many = contents.solids.len() > 1;
        expected.extend(contents.solids.into_iter().map(|solid| ExpectedPart {
            name: if many { format!("{name} ({})", solid.name) } else { name.clone() },
            copies: copies * solid.copies as usize,
            shape: ShapeSignature::from_mesh(&solid.mesh),
        }));
    }
    Ok(expected)
}

/// The parts that are missing and those that are in excess. Equal shapes in several rows are counted together.
pub fn find_list_faults(expected: &[ExpectedPart], placed: &[PlacedMesh]) -> Vec<String> {
    let mut kinds: Vec<(ShapeSignature, Vec<&str>, usize, usize)> = Vec::new();
    for row in expected {
        match kinds.iter_mut().find(|kind| kind.0.matches_shape(&row.shape)) {
            Some(kind) => {
                kind.1.push(&row.name);
                kind.2 += row.copies;
            }
            None => kinds.push((row.shape, vec![&row.name], row.copies, 0)),
        }
    }
    let mut faults = Vec::new();
    let mut known: Vec<(*const Mesh, ShapeSignature)> = Vec::new();
    for item in placed {
        let address = std::sync::Arc::as_ptr(&item.mesh);
        let shape = match known.iter().find(|(of, _)| *of == address) {
            Some(&(_, shape)) => shape,
            None => {
                known.push((address, ShapeSignature::from_mesh(&item.mesh)));
                known[known.len() - 1].1
            }
        };
        match kinds.iter_mut().find(|kind| kind.0.matches_shape(&shape)) {
            Some(kind) => kind.3 += 1,
            None => faults.push(format!("{} was not asked for", item.name)),
        }
    }
    for (_, names, wanted, found) in &kinds {
        if wanted != found {
            faults.push(format!("{} is in the file {found} times instead of {wanted}", names.join(" / ")));
        }
    }
    faults
}
