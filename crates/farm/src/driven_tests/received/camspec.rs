//! CAMSPEC packages as orders: each line is a part with what the package says of it, and its id comes back out.

use std::{fs, io::Write};

use ledger::{CommandKind, PartState};
use nester::OrientationRule;
use serde_json::json;
use solids::Pose;
use zip::{ZipWriter, write::SimpleFileOptions};

use crate::driven_tests::{
    HandDrivenFarm, QUICK, block,
    hand_driven_farm::farm_files::{assert_each_copy_once, list_build_files},
};

const IDS: [&str; 3] = [
    "550e8400-e29b-41d4-a716-446655440000",
    "550e8400-e29b-41d4-a716-446655440020",
    "550e8400-e29b-41d4-a716-446655440001",
];

/// A package of one model, with this document.
fn package(document: &serde_json::Value) -> Vec<u8> {
    let document = document.to_string().into_bytes();
    zipped(&[("models/critical_part.stl", stl_of_block()), ("camspec.json", document)])
}

fn stl_of_block() -> Vec<u8> {
    let mut stl = Vec::new();
    let (mesh, pose) = (block(10.0, 20.0, 30.0), Pose::IDENTITY);
    build_file::write_stl(std::iter::once((&mesh, &pose)), &mut stl).unwrap();
    stl
}

fn zipped(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The manifest that the book shows.
fn printed_example() -> String {
    let chapter = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/technician.md"));
    let section = chapter.split("## CAMSPEC packages").nth(1).unwrap();
    let is_code = |line: &&str| line.starts_with("    ");
    section.lines().skip_while(|line| !is_code(line)).take_while(is_code).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_package_of_the_book_is_taken_exactly_as_it_is_printed() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let manifest = printed_example().into_bytes();
    farm.drop_bytes("K-4711.camspec", &zipped(&[("bracket.stl", stl_of_block()), ("camspec.json", manifest)]));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((part.owed.copies, part.terms.clearance_mm, part.terms.reference.as_str()), (12, Some(4.0), IDS[0]));
    assert_eq!(part.terms.order_name, "K-4711");
    farm.order(CommandKind::Flush, None);
    assert_each_copy_once(&farm.wait_for_queued(1), 12);
}

fn line(id: &str, quantity: u32) -> serde_json::Value {
    json!({"id": id, "file": "critical_part.stl", "quantity": quantity, "units": "MM"})
}

#[test]
fn each_line_of_a_package_is_a_part_and_its_id_comes_back_in_the_pick_map_and_the_build_file() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let mut urgent = line(IDS[1], 1);
    urgent["priority"] = 100.into();
    urgent["name"] = "Precision Surface Part".into();
    let normals = json!({"normals": [[0, 0, 1]], "tolerance": 10, "units": "DEG"});
    let document = json!({
        "version": "1.0.0", "manifest": [line(IDS[0], 2), urgent, line(IDS[2], 1)],
        "constraints": [
            {"manifestId": IDS[1], "type": "FORBIDDEN_ORIENTATION", "value": normals},
            {"manifestId": IDS[2], "type": "FIXED_ORIENTATION", "value": {"rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1]}},
        ],
        "globalConstraints": [{"type": "MIN_PART_DISTANCE", "value": {"distance": 0.4, "units": "CM"}}],
    });
    farm.drop_bytes("Brandt 12.camspec", &package(&document));
    let parts = farm.wait_for_parts(PartState::Waiting, 3);
    let terms = |id: &str| parts.iter().find(|part| part.terms.reference == id).unwrap();
    let [usual, urgent, fixed] = IDS.map(terms);
    assert_eq!((usual.owed.copies, usual.terms.priority, usual.terms.clearance_mm), (2, 50, Some(4.0)));
    assert_eq!((urgent.terms.priority, urgent.solid.object_name.as_str()), (100, "Precision Surface Part"));
    assert_eq!((urgent.terms.tilts.0.len(), usual.terms.tilts.0.len()), (1, 0));
    assert_eq!((fixed.terms.orientation, usual.terms.orientation), (OrientationRule::Fixed, OrientationRule::Free));
    assert!(parts.iter().all(|part| part.terms.order_name == "Brandt 12"), "{parts:?}");
    farm.order(CommandKind::Flush, None);
    let queued = farm.wait_for_queued(1);
    assert_each_copy_once(&queued, 4);
    let limits = build_file::ReadLimits::default();
    let mut references: Vec<String> = build_file::read_build(&queued[0], &limits)
        .unwrap()
        .into_iter()
        .filter_map(|item| item.words.reference)
        .collect();
    references.sort();
    assert_eq!(references, [IDS[0], IDS[0], IDS[2], IDS[1]]);
    let pick_map = fs::read_dir(farm.folder("queue")).unwrap().map(|entry| entry.unwrap().path());
    let pick_map = pick_map.into_iter().find(|path| path.to_str().unwrap().ends_with(".parts.csv")).unwrap();
    let text = fs::read_to_string(pick_map).unwrap();
    assert_eq!(text.matches(IDS[0]).count(), 2, "{text}");
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_package_that_is_dropped_again_is_made_as_it_says_now_and_keeps_its_date() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let document = |lines: serde_json::Value, fixed: &str| {
        let constraint = json!({"manifestId": fixed, "type": "FIXED_ORIENTATION", "value": {"rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1]}});
        package(&json!({"version": "1.0.0", "manifest": lines, "constraints": [constraint], "globalConstraints": []}))
    };
    farm.drop_bytes("Brandt_x12.camspec.toml", b"due = 2031-01-01");
    farm.drop_bytes("Brandt_x12.camspec", &document(json!([line("a", 5)]), "a"));
    let first = farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!((first[0].owed.copies, first[0].terms.orientation), (5, OrientationRule::Fixed));
    farm.drop_bytes("Brandt_x12.camspec", &document(json!([line("a", 3), line("b", 2)]), "b"));
    farm.wait_for_parts(PartState::Refused, 1);
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let asked = |part: &ledger::PartRow| {
        (
            part.terms.reference.clone(),
            part.owed.copies,
            part.terms.orientation,
            part.terms.due_at == first[0].terms.due_at,
        )
    };
    let expected =
        [("a".to_owned(), 3, OrientationRule::Free, true), ("b".to_owned(), 2, OrientationRule::Fixed, true)];
    assert_eq!(parts.iter().map(asked).collect::<Vec<_>>(), expected);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_package_that_cannot_be_obeyed_is_refused_as_a_whole_with_the_reason() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let place = json!({"x": 0, "y": 0, "z": 0, "units": "MM"});
    let document = json!({
        "version": "1.0.0", "manifest": [line(IDS[0], 1), line(IDS[1], 1)],
        "constraints": [{"manifestId": IDS[1], "type": "FIXED_LOCATION", "value": place}], "globalConstraints": [],
    });
    farm.drop_bytes("fixed.camspec", &package(&document));
    let refused = farm.wait_for_parts(PartState::Refused, 1);
    let reason = &refused[0].refused.reason;
    assert!(reason.contains("FIXED_LOCATION") && reason.contains("nestd chooses the places itself"), "{reason}");
    assert!(farm.parts(PartState::Waiting).is_empty() && list_build_files(&farm.folder("queue")).is_empty());
    assert!(farm.folder("error").join("fixed.camspec").exists());
    farm.assert_ledger_agrees_with_folders();
}
