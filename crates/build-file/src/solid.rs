//! The contents of a dropped file: turns vertices and triangles from any reader into checked parts with warnings.

use glam::DVec3;
use solids::{Mesh, MeshError};

use super::{FileReadError, LengthUnit, format_count};

/// Parts with a smaller largest extent were probably drawn in metres or inches.
const SUSPICIOUSLY_SMALL_MM: f64 = 2.0;
/// Parts with a greater largest extent were probably drawn in microns.
const SUSPICIOUSLY_LARGE_MM: f64 = 10_000.0;
/// Coordinates beyond 10 km are invalid: their precision is too low for a part.
const MAX_COORDINATE_MM: f64 = 1e7;

/// The contents of a dropped file.
#[derive(Debug, Clone)]
pub struct PartFileContents {
    /// The parts in it, at least one.
    pub solids: Vec<PartFileSolid>,
    /// Warnings about the whole file, for people; sentences.
    pub warnings: Vec<String>,
}

/// One part of a dropped file.
#[derive(Debug, Clone)]
pub struct PartFileSolid {
    /// The name in the file, or else the dropped file's name without extension.
    pub name: String,
    /// In mm. Not necessarily closed: see [`Mesh::defects`].
    pub mesh: Mesh,
    /// Number of copies that the file itself requests, at least 1.
    pub copies: u32,
    /// Warnings about this part, for people; sentences.
    pub warnings: Vec<String>,
}

/// Checks a surface in mm; `unit` is the unit of the file.
pub(super) fn check_solid(
    name: String,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    copies: u32,
    unit: LengthUnit,
) -> Result<PartFileSolid, FileReadError> {
    let mesh = checked_mesh(&name, vertices, triangles)?;
    let mut warnings = Vec::new();
    if mesh.defects().inverted {
        warnings.push("the surface was inside out and has been turned".to_owned());
    }
    let welded = mesh.defects().welded_vertices;
    if welded > 0 {
        warnings.push(format!(
            "{} nearer to another than the precision of 32-bit coordinates {} been welded, to close the surface",
            format_count(welded, "corner", "corners"),
            if welded == 1 { "has" } else { "have" }
        ));
    }
    if mesh.defects().equal_triangles > 0 {
        let left_out = mesh.defects().equal_triangles;
        warnings.push(format!(
            "duplicate pieces are at the same place: one of each is kept, {left_out} triangles are left out"
        ));
    }
    let dropped = mesh.defects().degenerate_triangles;
    let kept = (0..mesh.triangles().len()).filter(|&t| has_no_area(mesh.corners(t))).count();
    if dropped + kept > 0 {
        warnings.push(format!(
            "{} without an area ({dropped} left out, {kept} kept to stay closed)",
            format_count(dropped + kept, "triangle", "triangles")
        ));
    }
    warnings.extend(suspicious_size(mesh.bounds().size().max_element(), unit));
    Ok(PartFileSolid { name, mesh, copies, warnings })
}

/// Creates a mesh from a file's data, in mm.
pub(super) fn checked_mesh(name: &str, vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Mesh, FileReadError> {
    let no_solid = |source: MeshError| FileReadError::NoSolid { name: format!("{name:?}"), source };
    if let Some(far) = vertices.iter().position(|v| v.is_finite() && v.abs().max_element() > MAX_COORDINATE_MM) {
        return Err(FileReadError::Unsupported {
            what: format!("vertex {} of {name:?} lies farther than 10 km from the origin", far + 1),
            remedy: "Move the part to the origin in the CAD program, or give the right unit in a ticket; then drop it again.",
        });
    }
    Mesh::new(vertices, triangles).map_err(no_solid)
}

/// Whether three different corners lie on a line, within their precision.
fn has_no_area([a, b, c]: [DVec3; 3]) -> bool {
    let (side1, side2) = (b - a, c - a);
    let longest2 = side1.length_squared().max(side2.length_squared()).max((c - b).length_squared());
    side1.cross(side2).length() <= 1e-7 * longest2
}

/// Warns about a size that is probably a wrong unit, with the possible readings. Nothing is rescaled silently.
fn suspicious_size(largest_mm: f64, unit: LengthUnit) -> Option<String> {
    let others: &[LengthUnit] = match largest_mm {
        size if size < SUSPICIOUSLY_SMALL_MM => &[LengthUnit::Inch, LengthUnit::Meter],
        size if size > SUSPICIOUSLY_LARGE_MM => &[LengthUnit::Micron],
        _ => return None,
    };
    let readings: Vec<String> = (others.iter().filter(|&&other| other != unit))
        .map(|other| {
            format!(
                "{} mm if it was drawn in {}",
                short_number(largest_mm / unit.mm_per_unit() * other.mm_per_unit()),
                unit_name(*other)
            )
        })
        .collect();
    Some(format!(
        "suspicious size: the largest extent is {} mm as read in {}; it would be {}",
        short_number(largest_mm),
        unit_name(unit),
        readings.join(", ")
    ))
}

fn short_number(millimetres: f64) -> String {
    format!("{millimetres:.4}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn unit_name(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Micron => "microns",
        LengthUnit::Millimeter => "millimetres",
        LengthUnit::Centimeter => "centimetres",
        LengthUnit::Inch => "inches",
        LengthUnit::Foot => "feet",
        LengthUnit::Meter => "metres",
    }
}
