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

use super::{FileReadError, LengthUnit, escape_invisible};

/// Greatest deviation of a rotation matrix from an orthonormal one, and of a normal from length 1.
const PRECISION: f64 = 1e-3;
/// A fixed orientation obeys to this angle, degrees: matrices are written with few digits.
const FIXED_WITHIN_DEG: f64 = 0.1;

/// What a package says of one of its models beyond the mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SolidRequest {
    /// The customer's own number of the line, as given.
    pub reference: String,
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
pub(super) struct CamspecLine {
    /// Path of the model below `models/`.
    pub(super) file: String,
    /// Name for people; "" = none.
    pub(super) name: String,
    /// Copies; 0 = none are wanted.
    pub(super) copies: u32,
    /// Unit of the model.
    pub(super) unit: LengthUnit,
    /// Everything else.
    pub(super) request: SolidRequest,
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
pub(super) fn parse_camspec(text: &str) -> Result<Vec<CamspecLine>, FileReadError> {
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
        if places.insert(raw.id.to_lowercase(), lines.len()).is_some() {
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
        let at = places.get(&constraint.manifest_id.to_lowercase());
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
    let request = SolidRequest { reference, priority: priority.transpose()?, ..SolidRequest::default() };
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
        Ok::<_, FileReadError>(length * unit.mm_per_unit())
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const ID: &str = "550e8400-e29b-41d4-a716-446655440000";

    fn document(line: Value, constraints: Value, global: Value) -> String {
        json!({"version": "1.0.0", "manifest": [line], "constraints": constraints, "globalConstraints": global})
            .to_string()
    }

    fn line() -> Value {
        json!({"id": ID, "file": "a.stl", "quantity": 5, "units": "MM"})
    }

    fn constrained(constraint: Value) -> Result<SolidRequest, FileReadError> {
        let mut constraint = constraint;
        constraint["manifestId"] = ID.into();
        let mut line = line();
        // Its file lies on its back: the z of the standard orientation is the y of the file.
        line["referenceTransform"] = json!({"rotation": [1, 0, 0, 0, 0, -1, 0, 1, 0], "translation": [0, 0, 0]});
        Ok(parse_camspec(&document(line, json!([constraint]), json!([])))?.remove(0).request)
    }

    #[test]
    fn a_bare_document_is_read_and_so_are_the_words_of_the_documentation() {
        let lines = parse_camspec(&document(line(), json!([]), json!([]))).unwrap();
        let request = SolidRequest { reference: ID.to_owned(), ..SolidRequest::default() };
        let expected = CamspecLine {
            file: "a.stl".to_owned(),
            name: String::new(),
            copies: 5,
            unit: LengthUnit::Millimeter,
            request,
        };
        assert_eq!(lines, [expected]);
        let full = json!({
            "$schema": "https://camspec.org/schema/1.0.0/camspec.json", "version": "0.1.0",
            "manifest": [{"id": ID, "file": "a.stl", "format": "STL_ASCII", "name": "Precision", "priority": 100,
                "quantity": 0, "units": "in", "referenceTransform": {"rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "translation": [0, 0, 0]}}],
            "globalConstraints": [{"type": "MIN_PART_DISTANCE", "value": {"distance": 0.25, "units": "cm"}},
                {"type": "VOLUME_BASED_SPACING", "value": {"smallParts": {"maxVolume": 1, "minSpacing": 2, "units": "MM"},
                    "largeParts": {"minVolume": 9, "minSpacing": 5, "units": "MM"}}}],
            "optimization": {"strategy": "MINIMIZE_HEIGHT", "weight": 1.0},
        });
        let read = parse_camspec(&format!("\u{feff}{full}")).unwrap().remove(0);
        assert_eq!((read.copies, read.unit, read.name.as_str()), (0, LengthUnit::Inch, "Precision"));
        assert_eq!((read.request.priority, read.request.clearance_mm), (Some(100), Some(5.0)));
    }

    #[test]
    fn constraints_of_the_orientation_hold_in_the_frame_of_the_file() {
        let rotation = json!([1, 0, 0, 0, 1, 0, 0, 0, 1]);
        let fixed = constrained(json!({"type": "FIXED_ORIENTATION", "value": {"rotation": rotation}})).unwrap();
        assert!(!fixed.is_fixed && fixed.up[0].0.abs_diff_eq(DVec3::Y, 1e-9), "{fixed:?}");
        let back = json!([1, 0, 0, 0, 0, 1, 0, -1, 0]);
        let as_dropped = constrained(json!({"type": "FIXED_ORIENTATION", "value": {"rotation": back}})).unwrap();
        assert!(as_dropped.is_fixed && as_dropped.up.is_empty());
        let forbidden =
            json!({"normals": [[0, 0, 1], [1, 0, 0]], "tolerance": std::f64::consts::FRAC_PI_2, "units": "RAD"});
        let forbidden = constrained(json!({"type": "FORBIDDEN_ORIENTATION", "value": forbidden})).unwrap().not_down;
        assert!(forbidden[0].0.abs_diff_eq(DVec3::Y, 1e-9) && forbidden[1].0.abs_diff_eq(DVec3::X, 1e-9));
        assert!((forbidden[0].1 - 90.0).abs() < 1e-9);
        let range = |axis: Value, min: f64, max: f64| {
            let value = json!({"axis": axis, "range": {"min": min, "max": max}, "units": "DEG"});
            constrained(json!({"type": "RANGE_ORIENTATION", "value": value})).unwrap().up[0].0
        };
        assert!(range(json!([0, 0, 1]), -180.0, 180.0).abs_diff_eq(DVec3::Y, 1e-9), "any turn about the vertical");
        assert!(range(json!([1, 0, 0]), -45.0, 45.0).abs_diff_eq(DVec3::Y, 1e-9), "the standard orientation");
        // A quarter turn about x brings what was up to -y, and what was y up: in the file, that is -z.
        let turned = range(json!([1, 0, 0]), 60.0, 120.0);
        assert!(turned.abs_diff_eq(DVec3::NEG_Z, 1e-9), "{turned}");
    }

    #[test]
    fn what_is_not_valid_or_cannot_be_obeyed_is_refused_with_its_place() {
        let with = |key: &str, value: Value| {
            let mut line = line();
            line[key] = value;
            document(line, json!([]), json!([]))
        };
        let constraint = |id: &str, kind: &str, value: Value| {
            document(line(), json!([{"manifestId": id, "type": kind, "value": value}]), json!([]))
        };
        let twice = json!({"version": "1.0.0", "manifest": [line(), line()]}).to_string();
        let cases = [
            ("{".to_owned(), "EOF"),
            ("[]".to_owned(), "invalid"),
            (json!({"version": "1.0.0"}).to_string(), "manifest"),
            (json!({"version": "1.0.0", "manifest": []}).to_string(), "names no model"),
            (json!({"version": "1", "manifest": [line()]}).to_string(), "not of the form"),
            (json!({"version": "2.0.0", "manifest": [line()]}).to_string(), "versions 0 and 1"),
            (twice, "twice"),
            (with("quantity", json!(-1)), "quantity"),
            (with("quantity", json!("five")), "invalid type"),
            (with("units", json!("parsec")), "MM, CM, IN or FT"),
            (with("priority", json!(101)), "0 to 100"),
            (with("referenceTransform", json!({"rotation": [1, 0, 0], "translation": [0, 0, 0]})), "nine"),
            (with("referenceTransform", json!({"rotation": [2, 0, 0, 0, 1, 0, 0, 0, 1]})), "no rotation"),
            (constraint("other", "FIXED_ORIENTATION", json!({})), "its manifest does not"),
            (constraint(ID, "FIXED_ORIENTATION", json!({})), "nine"),
            (
                constraint(
                    ID,
                    "FORBIDDEN_ORIENTATION",
                    json!({"normals": [[0, 0, 2]], "tolerance": 1, "units": "DEG"}),
                ),
                "length is not 1",
            ),
            (
                constraint(
                    ID,
                    "FORBIDDEN_ORIENTATION",
                    json!({"normals": [[0, 0, 1]], "tolerance": 1, "units": "GON"}),
                ),
                "DEG or RAD",
            ),
            (
                constraint(ID, "FIXED_LOCATION", json!({"x": 0, "y": 0, "z": 0, "units": "MM"})),
                "chooses the places itself",
            ),
            (constraint(ID, "PAINTED", json!({})), "not known"),
            (
                document(line(), json!([]), json!([{"type": "MIN_PART_DISTANCE", "value": {"distance": 1}}])),
                "MM, CM, IN or FT",
            ),
            (document(line(), json!([]), json!([{"type": "WARM", "value": {}}])), "not known"),
        ];
        for (text, expected) in cases {
            let error = parse_camspec(&text).unwrap_err();
            assert!(error.to_string().contains(expected), "{text}: {error}");
            assert!(!error.remedy().is_empty());
        }
    }
}
