//! Documents of CAMSPEC packages: what is read, and what is refused.

use glam::DVec3;
use serde_json::{Value, json};

use crate::{
    FileReadError, LengthUnit,
    common::camspec::{CamspecLine, SolidRequest, parse_camspec},
};

const ID: &str = "550e8400-e29b-41d4-a716-446655440000";

fn document(line: Value, constraints: Value, global: Value) -> String {
    json!({"version": "1.0.0", "manifest": [line], "constraints": constraints, "globalConstraints": global}).to_string()
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
    let expected =
        CamspecLine { file: "a.stl".to_owned(), name: String::new(), copies: 5, unit: LengthUnit::Millimeter, request };
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
            constraint(ID, "FORBIDDEN_ORIENTATION", json!({"normals": [[0, 0, 2]], "tolerance": 1, "units": "DEG"})),
            "length is not 1",
        ),
        (
            constraint(ID, "FORBIDDEN_ORIENTATION", json!({"normals": [[0, 0, 1]], "tolerance": 1, "units": "GON"})),
            "DEG or RAD",
        ),
        (constraint(ID, "FIXED_LOCATION", json!({"x": 0, "y": 0, "z": 0, "units": "MM"})), "chooses the places itself"),
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
