//! What a dropped file holds: vertices and triangles from any reader -> checked parts with their warnings.

use glam::DVec3;
use solids::{Mesh, MeshError};

use super::{ReadError, Unit, counted};

/// Parts whose largest extent is smaller were probably drawn in metres or inches.
const SUSPICIOUSLY_SMALL_MM: f64 = 2.0;
/// Parts whose largest extent is greater were probably drawn in microns.
const SUSPICIOUSLY_LARGE_MM: f64 = 10_000.0;
/// Coordinates beyond 10 km are nonsense, and their digits no longer hold a part.
const MAX_COORDINATE_MM: f64 = 1e7;

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

/// Checks a surface in mm; `unit` is the one that it was read in.
pub(super) fn solid(
    name: String,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    copies: u32,
    unit: Unit,
) -> Result<Solid, ReadError> {
    let mesh = checked_mesh(&name, vertices, triangles)?;
    let mut warnings = Vec::new();
    if mesh.defects().inverted {
        warnings.push("the surface was inside out and has been turned".to_owned());
    }
    let welded = mesh.defects().welded_vertices;
    if welded > 0 {
        warnings.push(format!(
            "{} closer together than 32-bit coordinates tell apart {} been welded, to close the surface",
            counted(welded, "corner that lay", "corners that lay"),
            if welded == 1 { "has" } else { "have" }
        ));
    }
    if mesh.defects().equal_triangles > 0 {
        let left_out = mesh.defects().equal_triangles;
        warnings
            .push(format!("equal pieces stand in one place: one of each is kept, {left_out} triangles are left out"));
    }
    let dropped = mesh.defects().degenerate_triangles;
    let kept = (0..mesh.triangles().len()).filter(|&t| has_no_area(mesh.corners(t))).count();
    if dropped + kept > 0 {
        warnings.push(format!(
            "{} without an area ({dropped} left out, {kept} kept to stay closed)",
            counted(dropped + kept, "triangle", "triangles")
        ));
    }
    warnings.extend(suspicious_size(mesh.bounds().size().max_element(), unit));
    Ok(Solid { name, mesh, copies, warnings })
}

/// A mesh out of what a file says, in mm.
pub(super) fn checked_mesh(name: &str, vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Mesh, ReadError> {
    let no_solid = |source: MeshError| ReadError::NoSolid { name: format!("{name:?}"), source };
    if let Some(far) = vertices.iter().position(|v| v.is_finite() && v.abs().max_element() > MAX_COORDINATE_MM) {
        return Err(ReadError::Unsupported {
            what: format!("vertex {} of {name:?} lies farther than 10 km from the origin", far + 1),
            remedy: "Move the part to the origin in the CAD program, or say the right unit in a ticket; then drop it again.",
        });
    }
    Mesh::new(vertices, triangles).map_err(no_solid)
}

/// Whether three different corners lie on a line, as far as their digits tell.
fn has_no_area([a, b, c]: [DVec3; 3]) -> bool {
    let (side1, side2) = (b - a, c - a);
    let longest2 = side1.length_squared().max(side2.length_squared()).max((c - b).length_squared());
    side1.cross(side2).length() <= 1e-7 * longest2
}

/// Nothing is rescaled silently: a size that is probably a wrong unit is told with both readings.
fn suspicious_size(largest_mm: f64, unit: Unit) -> Option<String> {
    let others: &[Unit] = match largest_mm {
        size if size < SUSPICIOUSLY_SMALL_MM => &[Unit::Inch, Unit::Meter],
        size if size > SUSPICIOUSLY_LARGE_MM => &[Unit::Micron],
        _ => return None,
    };
    let readings: Vec<String> = (others.iter().filter(|&&other| other != unit))
        .map(|other| format!("{} mm if it was drawn in {}", short(largest_mm / unit.mm() * other.mm()), word(*other)))
        .collect();
    Some(format!(
        "suspicious size: the largest extent is {} mm as read in {}; it would be {}",
        short(largest_mm),
        word(unit),
        readings.join(", ")
    ))
}

fn short(millimetres: f64) -> String {
    format!("{millimetres:.4}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn word(unit: Unit) -> &'static str {
    match unit {
        Unit::Micron => "microns",
        Unit::Millimeter => "millimetres",
        Unit::Centimeter => "centimetres",
        Unit::Inch => "inches",
        Unit::Foot => "feet",
        Unit::Meter => "metres",
    }
}
