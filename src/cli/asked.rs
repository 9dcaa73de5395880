//! A list of parts that were asked for, compared with the meshes of a build file: names say nothing, geometry does.

use std::path::Path;

use anyhow::{Context, Result};
use build_file::{Limits, PlacedMesh, Unit};
use solids::Mesh;

use super::Usage;

/// Shares by which two readings of one mesh may differ: other packers write fewer digits.
const SAME: f64 = 1e-5;

/// A mesh that was asked for.
pub struct Asked {
    name: String,
    copies: usize,
    shape: Shape,
}

/// What does not change when a mesh is moved, turned or written anew.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shape {
    triangles: usize,
    volume_mm3: f64,
    area_mm2: f64,
    /// Sum of the areas times the squared distance of the triangles from the middle, mm4.
    spread_mm4: f64,
}

impl Shape {
    fn of(mesh: &Mesh) -> Self {
        let corners = || (0..mesh.triangles().len()).map(|t| mesh.corners(t));
        let area = |[a, b, c]: [glam::DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
        let area_mm2: f64 = corners().map(area).sum();
        let middle = |[a, b, c]: [glam::DVec3; 3]| (a + b + c) / 3.0;
        let center = corners().map(|t| middle(t) * area(t)).sum::<glam::DVec3>() / area_mm2;
        let spread_mm4 = corners().map(|t| area(t) * (middle(t) - center).length_squared()).sum();
        Self { triangles: mesh.triangles().len(), volume_mm3: mesh.volume_mm3(), area_mm2, spread_mm4 }
    }

    fn is(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
        self.triangles == other.triangles
            && close(self.volume_mm3, other.volume_mm3)
            && close(self.area_mm2, other.area_mm2)
            && close(self.spread_mm4, other.spread_mm4)
    }
}

/// Reads a list with the columns `file` and `copies` (or `quantity`; 1 when there is none), and the files that it names.
pub fn read_list(list: &Path, base: &Path, limits: &Limits) -> Result<Vec<Asked>> {
    let unreadable = |error: csv::Error| Usage(format!("{}: {error}", list.display()));
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_path(list).map_err(unreadable)?;
    let headers = reader.headers().map_err(unreadable)?.clone();
    let column = |names: &[&str]| headers.iter().position(|h| names.contains(&h.to_ascii_lowercase().as_str()));
    let file_column =
        column(&["file"]).ok_or_else(|| Usage(format!("{}: there is no column `file`", list.display())))?;
    let copies_column = column(&["copies", "quantity"]);
    let mut asked = Vec::new();
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let name = record.get(file_column).unwrap_or_default().to_owned();
        let copies: usize = match copies_column.and_then(|c| record.get(c)).filter(|text| !text.is_empty()) {
            Some(text) => text.parse().with_context(|| format!("{name}: {text:?} is no number of copies"))?,
            None => 1,
        };
        let contents = build_file::read(&base.join(&name), &name, None, Unit::Millimeter, limits)
            .map_err(|error| Usage(format!("{name}: {:#}", anyhow::Error::from(error))))?;
        let many = contents.solids.len() > 1;
        asked.extend(contents.solids.into_iter().map(|solid| Asked {
            name: if many { format!("{name} ({})", solid.name) } else { name.clone() },
            copies: copies * solid.copies as usize,
            shape: Shape::of(&solid.mesh),
        }));
    }
    Ok(asked)
}

/// What is missing and what is too much. Equal shapes that are asked for in several rows are counted together.
pub fn faults(asked: &[Asked], placed: &[PlacedMesh]) -> Vec<String> {
    let mut kinds: Vec<(Shape, Vec<&str>, usize, usize)> = Vec::new();
    for row in asked {
        match kinds.iter_mut().find(|kind| kind.0.is(&row.shape)) {
            Some(kind) => {
                kind.1.push(&row.name);
                kind.2 += row.copies;
            }
            None => kinds.push((row.shape, vec![&row.name], row.copies, 0)),
        }
    }
    let mut faults = Vec::new();
    let mut known: Vec<(*const Mesh, Shape)> = Vec::new();
    for item in placed {
        let address = std::sync::Arc::as_ptr(&item.mesh);
        let shape = match known.iter().find(|(of, _)| *of == address) {
            Some(&(_, shape)) => shape,
            None => {
                known.push((address, Shape::of(&item.mesh)));
                known[known.len() - 1].1
            }
        };
        match kinds.iter_mut().find(|kind| kind.0.is(&shape)) {
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
