//! The document of a CAMSPEC package: which models are to be made, how often, and how they may be placed (schema 1.0.0 of
//! camspec.org, with what its documentation says differently).
//!
//! The schema and the documentation disagree: the file is `camspec.json` or `.camspec.json`, units are in capitals or not, and
//! fields that one requires are missing in the examples of the other. All of it is read. What cannot be obeyed is refused: nothing is
//! made otherwise than asked.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{
    file_name::CAMSPEC_ENDING,
    part_terms::{MAX_CLEARANCE_MM, check_name},
};
use crate::{FileReadError, LengthUnit, escape_invisible};

/// Greatest deviation of a rotation matrix from an orthonormal one, and of a normal from length 1.
const PRECISION: f64 = 1e-3;
/// A fixed orientation obeys to this angle, degrees: matrices are written with few digits.
const FIXED_WITHIN_DEG: f64 = 0.1;

/// Whether a file of this name is a package.
pub fn is_camspec_name(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, ending)| ending.eq_ignore_ascii_case(CAMSPEC_ENDING))
}

/// What a package says of one of its models beyond the mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SolidRequest {
    /// The customer's own number of the line, as given.
    pub reference: String,
    /// What it is to be made of; `None` = not said.
    #[serde(default)]
    pub material: Option<String>,
    /// Priority, 0 to 100; `None` = not said.
    pub priority: Option<u8>,
    /// Least distance to all other parts, mm; `None` = not said.
    pub clearance_mm: Option<f64>,
    /// Whether the part must stand exactly as its file has it.
    pub is_fixed: bool,
    /// Directions of the file that must point up: a vector, and the greatest angle to straight up, degrees.
    pub up: Vec<(DVec3, f64)>,
    /// Outward normals of the file that must not point down: a vector, and the least angle to straight down, degrees.
    pub not_down: Vec<(DVec3, f64)>,
}

/// A line of the manifest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CamspecLine {
    /// Path of the model below `models/`.
    pub(crate) file: String,
    /// Name for people; "" = none.
    pub(crate) name: String,
    /// Copies; 0 = none are wanted.
    pub(crate) copies: u32,
    /// Unit of the model.
    pub(crate) unit: LengthUnit,
    /// Everything else.
    pub(crate) request: SolidRequest,
}

#[derive(Debug, Deserialize)]
struct RawDocument {
    version: String,
    manifest: Vec<RawLine>,
    #[serde(default)]
    constraints: Vec<RawConstraint>,
    #[serde(default, rename = "globalConstraints")]
    global_constraints: Vec<RawConstraint>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct RawLine {
    id: String,
    file: String,
    #[serde(default)]
    name: Option<String>,
    /// Its own word of nestd: the schema has none.
    #[serde(default)]
    material: Option<String>,
    #[serde(default)]
    priority: Option<i64>,
    quantity: i64,
    units: String,
    #[serde(default)]
    reference_transform: Option<RawTransform>,
}

#[derive(Debug, Deserialize)]
struct RawTransform {
    rotation: Vec<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct RawConstraint {
    #[serde(default)]
    manifest_id: String,
    #[serde(rename = "type")]
    kind: String,
    value: Value,
}

/// Reads a document.
///
/// # Errors
/// It is not valid, or asks for something that cannot be obeyed; says where.
pub(crate) fn parse_camspec(text: &str) -> Result<Vec<CamspecLine>, FileReadError> {
    let text = text.trim_start_matches('\u{feff}');
    let document: RawDocument = serde_json::from_str(text).map_err(|error| invalid(error.to_string()))?;
    let numbers: Vec<Option<u32>> = document.version.split('.').map(|number| number.parse().ok()).collect();
    match numbers[..] {
        [Some(0 | 1), Some(_), Some(_)] => {}
        [Some(_), Some(_), Some(_)] => {
            return Err(unsupported(format!("it is of CAMSPEC {}; versions 0 and 1 are known", document.version)));
        }
        _ => return Err(invalid(format!("its version {:?} is not of the form 1.0.0", document.version))),
    }
    if document.manifest.is_empty() {
        return Err(invalid("its manifest names no model"));
    }
    let mut lines = Vec::with_capacity(document.manifest.len());
    let (mut places, mut references) = (HashMap::new(), Vec::new());
    for raw in &document.manifest {
        if places.insert(raw.id.trim().to_lowercase(), lines.len()).is_some() {
            return Err(invalid(format!("the id {:?} is in its manifest twice", raw.id)));
        }
        references.push(reference_rotation(raw)?);
        lines.push(read_line(raw)?);
    }
    let clearance_mm =
        document.global_constraints.iter().map(spacing_mm).try_fold(0.0_f64, |most, mm| mm.map(|mm| most.max(mm)))?;
    for line in &mut lines {
        line.request.clearance_mm = (clearance_mm > 0.0).then_some(clearance_mm);
    }
    let mut oriented = HashSet::new();
    for constraint in &document.constraints {
        let at = places.get(&constraint.manifest_id.trim().to_lowercase());
        let &at = at.ok_or_else(|| {
            invalid(format!("a constraint names the id {:?}, which its manifest does not", constraint.manifest_id))
        })?;
        let is_orientation = matches!(constraint.kind.as_str(), "FIXED_ORIENTATION" | "RANGE_ORIENTATION");
        if is_orientation && !oriented.insert(at) {
            let line = &lines[at].request.reference;
            return Err(unsupported(format!(
                "the model {line} has two constraints of its orientation; one can be obeyed"
            )));
        }
        constrain(&mut lines[at].request, references[at], constraint)?;
    }
    Ok(lines)
}

fn invalid(reason: impl Into<String>) -> FileReadError {
    FileReadError::Invalid { format: "CAMSPEC", reason: escape_invisible(&reason.into()) }
}

fn unsupported(what: String) -> FileReadError {
    let remedy =
        "Take that out of the document of the package, or drop the model itself with a ticket; then drop it again.";
    FileReadError::Unsupported { what: escape_invisible(&what), remedy }
}

fn read_line(raw: &RawLine) -> Result<CamspecLine, FileReadError> {
    let of = |what: &str| format!("the {what} of the model {:?}", raw.id);
    if raw.id.trim().is_empty() {
        return Err(invalid(format!("the model {:?} has no id", raw.file)));
    }
    let copies = u32::try_from(raw.quantity).map_err(|_| invalid(format!("{} is {}", of("quantity"), raw.quantity)))?;
    let priority = raw.priority.map(|priority| match u8::try_from(priority) {
        Ok(priority @ 0..=100) => Ok(priority),
        _ => Err(invalid(format!("{} is {priority}; it is 0 to 100", of("priority")))),
    });
    let reference = escape_invisible(raw.id.trim());
    let material = raw.material.as_deref().filter(|word| !word.trim().is_empty());
    let material = material.map(|word| check_name("material", word)).transpose().map_err(invalid)?;
    let request = SolidRequest { reference, material, priority: priority.transpose()?, ..SolidRequest::default() };
    let name = escape_invisible(raw.name.as_deref().unwrap_or_default().trim());
    Ok(CamspecLine { file: raw.file.clone(), name, copies, unit: read_unit(&raw.units, &of("unit"))?, request })
}

fn read_unit(word: &str, what: &str) -> Result<LengthUnit, FileReadError> {
    match word.to_ascii_uppercase().as_str() {
        "MM" => Ok(LengthUnit::Millimeter),
        "CM" => Ok(LengthUnit::Centimeter),
        "IN" => Ok(LengthUnit::Inch),
        "FT" => Ok(LengthUnit::Foot),
        _ => Err(invalid(format!("{what} is {word:?}; it is MM, CM, IN or FT"))),
    }
}

/// From the model as its file has it to its standard orientation, to which all constraints refer.
fn reference_rotation(raw: &RawLine) -> Result<DMat3, FileReadError> {
    let what = format!("the referenceTransform of the model {:?}", raw.id);
    raw.reference_transform.as_ref().map_or(Ok(DMat3::IDENTITY), |transform| read_rotation(&transform.rotation, &what))
}

/// A rotation matrix in row-major order.
fn read_rotation(numbers: &[f64], what: &str) -> Result<DMat3, FileReadError> {
    let numbers: [f64; 9] =
        numbers.try_into().map_err(|_| invalid(format!("{what} has {} numbers instead of nine", numbers.len())))?;
    let matrix = DMat3::from_cols_array(&numbers).transpose();
    let is_rotation =
        (matrix * matrix.transpose()).abs_diff_eq(DMat3::IDENTITY, PRECISION) && matrix.determinant() > 0.0;
    if is_rotation { Ok(matrix) } else { Err(invalid(format!("{what} is no rotation"))) }
}

/// The least distance between parts that a global constraint asks for, mm. Where it depends on their volume, the greatest is used.
fn spacing_mm(constraint: &RawConstraint) -> Result<f64, FileReadError> {
    let value = &constraint.value;
    let length = |value: &Value, key: &str| {
        let unit = value["units"].as_str().unwrap_or_default();
        let unit = read_unit(unit, &format!("the unit of {}", constraint.kind))?;
        let length = value[key].as_f64().filter(|length| length.is_finite() && *length >= 0.0);
        let length = length.ok_or_else(|| invalid(format!("{} has no {key}", constraint.kind)))?;
        let mm = length * unit.mm_per_unit();
        match mm <= MAX_CLEARANCE_MM {
            true => Ok(mm),
            false => Err(invalid(format!("{} is {mm} mm; it is {MAX_CLEARANCE_MM} mm at most", constraint.kind))),
        }
    };
    match constraint.kind.as_str() {
        "MIN_PART_DISTANCE" => length(value, "distance"),
        "VOLUME_BASED_SPACING" => {
            Ok(length(&value["smallParts"], "minSpacing")?.max(length(&value["largeParts"], "minSpacing")?))
        }
        kind => Err(unsupported(format!("the global constraint {kind:?} is not known"))),
    }
}

/// Adds a constraint of a model. `reference` = from its file to its standard orientation.
fn constrain(request: &mut SolidRequest, reference: DMat3, constraint: &RawConstraint) -> Result<(), FileReadError> {
    let (kind, value) = (constraint.kind.as_str(), &constraint.value);
    let of = format!("{kind} of the model {}", request.reference);
    match kind {
        "FIXED_ORIENTATION" => {
            let numbers: Vec<f64> = serde_json::from_value(value["rotation"].clone()).unwrap_or_default();
            fix_orientation(request, read_rotation(&numbers, &of)? * reference)
        }
        "RANGE_ORIENTATION" => allow_range(request, reference, value, &of),
        "FORBIDDEN_ORIENTATION" => {
            let normals: Vec<Vec<f64>> = serde_json::from_value(value["normals"].clone()).unwrap_or_default();
            if normals.is_empty() {
                return Err(invalid(format!("{of} has no normals")));
            }
            let tolerance = angle_deg(value, "tolerance", &of)?;
            for normal in normals {
                request.not_down.push((reference.transpose() * read_unit_vector(&normal, &of)?, tolerance));
            }
            Ok(())
        }
        "FIXED_LOCATION" | "RANGE_LOCATION" => {
            Err(unsupported(format!("{of} asks for a place in the volume; nestd chooses the places itself")))
        }
        _ => Err(unsupported(format!("{of} is not known"))),
    }
}

/// The part stands in one orientation. Where that is not how its file has it, what is up is fixed, and turns about the vertical stay
/// free: they change nothing in a powder bed but the marks of the recoater.
fn fix_orientation(request: &mut SolidRequest, rotation: DMat3) -> Result<(), FileReadError> {
    if rotation.abs_diff_eq(DMat3::IDENTITY, PRECISION) {
        request.is_fixed = true;
    } else {
        request.up.push((rotation.transpose() * DVec3::Z, FIXED_WITHIN_DEG));
    }
    Ok(())
}

/// The part may be turned about an axis, from its standard orientation. Any turn about the vertical is a rule; of other ranges that
/// hold the standard orientation, that one is used.
fn allow_range(request: &mut SolidRequest, reference: DMat3, value: &Value, of: &str) -> Result<(), FileReadError> {
    let axis: Vec<f64> = serde_json::from_value(value["axis"].clone()).unwrap_or_default();
    let axis = read_unit_vector(&axis, of)?;
    let range = serde_json::json!({
        "min": value["range"]["min"], "max": value["range"]["max"], "units": value["units"],
    });
    let (min, max) = (angle_deg(&range, "min", of)?, angle_deg(&range, "max", of)?);
    if min > max {
        return Err(invalid(format!("{of} begins at {min} and ends at {max} degrees")));
    }
    if axis.z.abs() > 1.0 - PRECISION && max - min >= 360.0 - PRECISION {
        request.up.push((reference.transpose() * DVec3::Z, FIXED_WITHIN_DEG));
        return Ok(());
    }
    if min <= 0.0 && max >= 0.0 {
        return fix_orientation(request, reference);
    }
    let middle = DMat3::from_axis_angle(axis, ((min + max) / 2.0).to_radians());
    fix_orientation(request, middle * reference)
}

fn read_unit_vector(numbers: &[f64], of: &str) -> Result<DVec3, FileReadError> {
    let numbers: [f64; 3] =
        numbers.try_into().map_err(|_| invalid(format!("{of} has a vector without three numbers")))?;
    let vector = DVec3::from_array(numbers);
    match (vector.length() - 1.0).abs() <= PRECISION {
        true => Ok(vector.normalize()),
        false => Err(invalid(format!("{of} has the vector {numbers:?}, whose length is not 1"))),
    }
}

fn angle_deg(value: &Value, key: &str, of: &str) -> Result<f64, FileReadError> {
    let angle = value[key].as_f64().ok_or_else(|| invalid(format!("{of} has no {key}")))?;
    match value["units"].as_str().map(str::to_ascii_uppercase).as_deref() {
        Some("DEG") => Ok(angle),
        Some("RAD") => Ok(angle.to_degrees()),
        other => Err(invalid(format!("{of} has angles in {other:?}; they are in DEG or RAD"))),
    }
}
