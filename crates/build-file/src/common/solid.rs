//! The contents of a dropped file: turns vertices and triangles from any reader into checked parts with warnings.

use std::sync::Arc;

use glam::DVec3;
use solids::{Mesh, MeshBuilder, MeshError};

use super::{camspec::SolidRequest, decimal::step_of, unfinished::ZeroFacets};
use crate::{FileReadError, LengthUnit, format_count};

/// Parts with a smaller largest extent were probably drawn in metres or inches.
const SUSPICIOUSLY_SMALL_MM: f64 = 2.0;
/// Parts with a greater largest extent were probably drawn in microns.
const SUSPICIOUSLY_LARGE_MM: f64 = 10_000.0;
/// Coordinates beyond 2^20 mm are invalid: 32-bit numbers are 0.125 mm apart there, more than a layer.
const MAX_COORDINATE_MM: f64 = 1_048_576.0;

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
    pub mesh: Arc<Mesh>,
    /// Number of copies that the file itself requests, at least 1.
    pub copies: u32,
    /// Warnings about this part, for people; sentences.
    pub warnings: Vec<String>,
    /// What a person must confirm before it is printed.
    pub question: Option<String>,
    /// The distance of neighbouring 32-bit numbers at its coordinate farthest from the origin of its file, mm: details may be
    /// off by as much.
    pub coordinate_step_mm: f64,
    /// What its file says of it beyond the mesh, as CAMSPEC packages do.
    pub request: Option<Box<SolidRequest>>,
}

/// Checks a surface in mm; `unit` is the unit of the file.
pub(crate) fn check_solid(
    name: String,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    copies: u32,
    unit: LengthUnit,
) -> Result<PartFileSolid, FileReadError> {
    let mesh = checked_mesh(&name, vertices, triangles)?;
    Ok(described_solid(name, mesh, copies, unit))
}

/// A mesh with warnings about what was mended; `unit` is the unit of the file.
fn described_solid(name: String, mesh: Mesh, copies: u32, unit: LengthUnit) -> PartFileSolid {
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
    PartFileSolid {
        name,
        mesh: Arc::new(mesh),
        copies,
        warnings,
        question: None,
        coordinate_step_mm: 0.0,
        request: None,
    }
}

/// The triangles of a file without a list of corners that they share, while it is read: welded and checked one by one.
#[derive(Debug)]
pub(crate) struct WeldedSurface {
    /// The format of the file, as people call it.
    format: &'static str,
    builder: MeshBuilder,
    unit: LengthUnit,
    scale: f64,
    /// The first corner beyond [`MAX_COORDINATE_MM`].
    far: Option<usize>,
    /// Facets of zeros, in a binary file.
    pub(crate) zero_facets: ZeroFacets,
}

impl WeldedSurface {
    /// An empty surface with room for so many triangles, whose coordinates are in a unit.
    pub(crate) fn new(format: &'static str, unit: LengthUnit, triangles: usize) -> Self {
        Self {
            format,
            builder: MeshBuilder::with_capacity(triangles),
            unit,
            scale: unit.mm_per_unit(),
            far: None,
            zero_facets: ZeroFacets::default(),
        }
    }

    /// Adds a triangle in the file's unit.
    pub(crate) fn add_triangle(&mut self, corners: [DVec3; 3]) {
        let corners = corners.map(|corner| corner * self.scale);
        if self.far.is_none() {
            let at = corners.iter().position(is_far);
            self.far = at.map(|at| 3 * self.builder.triangle_count() + at);
        }
        self.builder.add_triangle(corners);
    }

    /// Checks the whole surface.
    pub(crate) fn into_solid(self, name: String) -> Result<PartFileSolid, FileReadError> {
        let (far, unit) = (self.far, self.unit);
        let made = self.builder.into_mesh();
        if let Err(MeshError::NotFinite { vertex }) = made {
            let reason = format!("triangle {} has a coordinate that is not a finite number", vertex / 3 + 1);
            return Err(FileReadError::Invalid { format: self.format, reason });
        }
        if let Some(vertex) = far {
            return Err(far_error(&name, vertex));
        }
        self.zero_facets.check(made.as_ref().is_ok_and(|mesh| mesh.defects().is_closed()))?;
        let mesh = made.map_err(|source| FileReadError::NoSolid { name: format!("{name:?}"), source })?;
        let reach = mesh.bounds().min.abs().max(mesh.bounds().max.abs()).max_element();
        let mut solid = described_solid(name, mesh, 1, unit);
        solid.coordinate_step_mm = step_of(reach / unit.mm_per_unit()) * unit.mm_per_unit();
        Ok(solid)
    }
}

fn is_far(place: &DVec3) -> bool {
    place.is_finite() && place.abs().max_element() > MAX_COORDINATE_MM
}

fn far_error(name: &str, vertex: usize) -> FileReadError {
    FileReadError::Unsupported {
        what: format!("vertex {} of {name:?} lies farther than 1.05 km from the origin", vertex + 1),
        remedy: "Move the part to the origin in the CAD program, or give the right unit in a ticket; then drop it again.",
    }
}

/// Creates a mesh from a file's data, in mm.
pub(crate) fn checked_mesh(name: &str, vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Mesh, FileReadError> {
    let no_solid = |source: MeshError| FileReadError::NoSolid { name: format!("{name:?}"), source };
    if let Some(vertex) = vertices.iter().position(is_far) {
        return Err(far_error(name, vertex));
    }
    Mesh::new(vertices, triangles).map_err(no_solid)
}

/// Whether three different corners lie on a line, within their precision.
fn has_no_area([a, b, c]: [DVec3; 3]) -> bool {
    let (side1, side2) = (b - a, c - a);
    let longest2 = side1.length_squared().max(side2.length_squared()).max((c - b).length_squared());
    side1.cross(side2).length() <= 1e-7 * longest2
}

/// How the warning of a size begins that is probably a wrong unit: what was read in another unit has another one, or none.
pub const SIZE_WARNING: &str = "suspicious size: ";

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
        "{SIZE_WARNING}the largest extent is {} mm as read in {}; it would be {}",
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
