//! `nestd verify` on valid and on faulty builds.

use std::{fs::File, path::PathBuf, sync::Arc};

use assert_cmd::Command;
use build_file::{
    Arrangement, BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, DeliveryKind,
    write_build, write_stl,
};
use glam::{DQuat, DVec3};
use solids::{Bounds, Mesh, Pose};

fn cube() -> Arc<Mesh> {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 10.0;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Arc::new(Mesh::new((0..8).map(corner).collect(), triangles).unwrap())
}

/// Two cubes of 10 mm in a 50 mm volume, `gap_mm` apart, rotated by `tilt` about y, with a clearance of 2 mm.
fn build(dir: &tempfile::TempDir, gap_mm: f64, tilt: f64) -> PathBuf {
    turned(dir, gap_mm, tilt, "upright", None)
}

fn turned(dir: &tempfile::TempDir, gap_mm: f64, tilt: f64, rule: &str, tilts: Option<&str>) -> PathBuf {
    written(dir, gap_mm, tilt, rule, tilts, BuildRules::default())
}

/// The rules in the file besides clearance and volume.
#[derive(Default)]
struct BuildRules {
    margins_mm: [f64; 3],
    clearance_z_extra_mm: f64,
    layer_area_cap_mm2: Option<f64>,
}

fn written(
    dir: &tempfile::TempDir,
    gap_mm: f64,
    tilt: f64,
    rule: &str,
    tilts: Option<&str>,
    asked: BuildRules,
) -> PathBuf {
    let item = |copy: u32| BuildFileItem {
        object: 0,
        pose: Pose::new(
            DQuat::from_rotation_y(tilt),
            DVec3::new(10.0 + f64::from(copy - 1) * (10.0 + gap_mm), 5.0, 20.0),
        ),
        words: Default::default(),
        copy,
        source_name: "cube.stl".to_owned(),
        source_hash: "00".to_owned(),
        clearance_mm: None,
        orientation: Some(rule.to_owned()),
        tilts: tilts.map(str::to_owned),
    };
    let object = BuildFileObject {
        name: "cube".to_owned(),
        mesh: cube(),
        part_number: "1".to_owned(),
        content_hash: "c".to_owned(),
    };
    let build = BuildFile {
        heading: BuildFileHeading {
            title: "two cubes".to_owned(),
            application: "nestd test".to_owned(),
            created: "2026-11-20T04:49:00Z".to_owned(),
            machine: "small".to_owned(),
            build_id: "1".to_owned(),
            seed: 1,
        },
        rules: BuildFileRules {
            volume_mm: DVec3::splat(50.0),
            keep_out: vec![Bounds { min: DVec3::new(44.0, 0.0, 0.0), max: DVec3::new(50.0, 20.0, 50.0) }],
            margins_mm: DVec3::from_array(asked.margins_mm),
            clearance_mm: 2.0,
            clearance_z_extra_mm: asked.clearance_z_extra_mm,
            layer_mm: 0.1,
            layer_area_cap_mm2: asked.layer_area_cap_mm2,
            interlock: "forbid".to_owned(),
        },
        height_mm: 30.0,
        density: 0.02,
        objects: vec![object],
        items: vec![item(1), item(2)],
        delivery: DeliveryKind::Shared,
        arrangement: Arrangement::Items,
        thumbnail_png: None,
    };
    let file = dir.path().join("two.build.3mf");
    write_build(&build, File::create(&file).unwrap()).unwrap();
    file
}

/// Runs `nestd verify`; returns the exit code and the output.
fn verify(file: &PathBuf, args: &[&str]) -> (i32, String) {
    let out = Command::cargo_bin("nestd").unwrap().arg("verify").arg(file).args(args).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    (out.status.code().unwrap(), text)
}

#[test]
fn a_right_build_is_proved_by_what_it_says_of_itself() {
    let dir = tempfile::tempdir().unwrap();
    let (code, text) = verify(&build(&dir, 3.0, 0.0), &[]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("30.0000 mm") && text.contains("3.000000 mm, 2 mm asked"), "{text}");
}

#[test]
fn what_stands_in_a_keep_out_box_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let (code, text) = verify(&build(&dir, 24.5, 0.0), &[]);
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("cube #2 (item 2) stands in keep-out box 1"), "{text}");
    assert!(!text.contains("cube #1 (item 1) stands"), "{text}");
}

#[test]
fn each_fault_is_named_and_the_exit_code_is_one() {
    let dir = tempfile::tempdir().unwrap();
    let near = build(&dir, 1.5, 0.0);
    let (code, text) = verify(&near, &[]);
    assert!(code == 1 && text.contains("cube #1 (item 1) and cube #2 (item 2) are 1.500000 mm apart"), "{text}");
    let (code, text) = verify(&near, &["--clearance", "1", "--volume", "30x50x50", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, json["proved"].as_bool()), (1, Some(false)));
    assert_eq!(json["outside"][0]["excess_mm"].as_f64().map(|e| (e * 1e6).round() / 1e6), Some(1.5));
    let (code, text) = verify(&build(&dir, 8.0, 0.2), &[]);
    assert!(code == 1 && text.contains("orientation rule"), "{text}");
}

#[test]
fn a_direction_that_does_not_stay_up_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    let outcome = |tilts| verify(&turned(&dir, 8.0, 0.2, "free", Some(tilts)), &[]);
    // 0.2 radians are 11.46 degrees.
    assert_eq!(outcome("0,0,1:11.46").0, 0);
    for broken in ["0,0,1:11.45", "0,0,1:30;0,0,-1:135", "0,0,1"] {
        let (code, text) = outcome(broken);
        assert!(code == 1 && text.contains("cube #1 (item 1) is turned against its orientation rule"), "{text}");
    }
}

#[test]
fn margins_and_what_is_kept_above_hold_in_the_file_or_are_reported() {
    let dir = tempfile::tempdir().unwrap();
    let outcome = |margins_mm, clearance_z_extra_mm| {
        let asked = BuildRules { margins_mm, clearance_z_extra_mm, ..BuildRules::default() };
        let file = written(&dir, 3.0, 0.0, "free", None, asked);
        verify(&file, &[])
    };
    // The cubes are 5 mm from a wall, 20 mm above the floor and 20 mm below the lid.
    let (code, text) = outcome([5.0, 20.0, 20.0], 4.0);
    assert!(code == 0 && text.contains("30.0000 mm") && text.contains("5 mm at the walls"), "{text}");
    for margins in [[5.1, 0.0, 0.0], [0.0, 20.1, 0.0], [0.0, 0.0, 20.1]] {
        let (code, text) = outcome(margins, 0.0);
        assert!(code == 1 && text.contains("stands 0.100000 mm out of the volume"), "{text}");
    }
    let file = turned(&dir, 0.0, 0.0, "free", None);
    let (code, _) = verify(&file, &["--clearance", "0"]);
    assert_eq!(code, 1, "they touch");
    let leaning = turned(&dir, 3.0, 0.2, "free", None);
    let least = |args: &[&str]| verify(&leaning, args);
    assert_eq!(least(&["--clearance", "2.5"]).0, 0);
    let (code, text) = least(&["--clearance", "2.5", "--clearance-z-extra", "20"]);
    assert!(code == 1 && text.contains("instead of 2.5 mm"), "{text}");
    assert_eq!(least(&["--margins", "2,20"]).0, 2);
}

#[test]
fn a_layer_that_is_filled_beyond_its_cap_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    // Two cubes of 10 mm are at the same height, 20 mm above the floor.
    let outcome = |cap| {
        let asked = BuildRules { layer_area_cap_mm2: Some(cap), ..BuildRules::default() };
        verify(&written(&dir, 3.0, 0.0, "free", None, asked), &[])
    };
    assert_eq!(outcome(200.0).0, 0);
    let (code, text) = outcome(199.9);
    assert!(code == 1 && text.contains("is filled with 200.0 mm2, 199.9 mm2 are allowed"), "{text}");
}

#[test]
fn a_list_counts_the_meshes_and_not_their_names() {
    let dir = tempfile::tempdir().unwrap();
    let file = build(&dir, 3.0, 0.0);
    let mesh = cube();
    write_stl([(&*mesh, &Pose::IDENTITY)].into_iter(), File::create(dir.path().join("other.stl")).unwrap()).unwrap();
    let list = dir.path().join("list.csv");
    let outcome = |text: &str| {
        std::fs::write(&list, text).unwrap();
        verify(&file, &["--list", list.to_str().unwrap()])
    };
    assert_eq!(outcome("file,copies\nother.stl,2\n").0, 0);
    assert_eq!(outcome("quantity,file\n1,other.stl\n1,other.stl\n").0, 0);
    let (code, text) = outcome("file,copies\nother.stl,3\n");
    assert!(code == 1 && text.contains("2 times instead of 3"), "{text}");
    assert_eq!(outcome("file\nmissing.stl\n").0, 2);
    assert_eq!(outcome("part\nother.stl\n").0, 2);
}

#[test]
fn what_cannot_be_read_or_understood_is_wrong_use() {
    let dir = tempfile::tempdir().unwrap();
    let file = build(&dir, 3.0, 0.0);
    assert_eq!(verify(&dir.path().join("none.3mf"), &[]).0, 2);
    assert_eq!(verify(&file, &["--volume", "380x284"]).0, 2);
    let cut = dir.path().join("cut.3mf");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() - 30]).unwrap();
    let (code, text) = verify(&cut, &[]);
    assert!(code == 2 && text.contains("truncated"), "{text}");
}

/// Two rings linked like a chain; the file states its rule for interlocked parts.
fn chain(dir: &tempfile::TempDir, interlock: &str) -> PathBuf {
    let item = |copy: u32, turn: f64, at: DVec3| BuildFileItem {
        object: 0,
        pose: Pose::new(DQuat::from_rotation_x(turn), at),
        words: Default::default(),
        copy,
        source_name: "ring.stl".to_owned(),
        source_hash: "00".to_owned(),
        clearance_mm: None,
        orientation: None,
        tilts: None,
    };
    let object = BuildFileObject {
        name: "ring".to_owned(),
        mesh: Arc::new(sample_parts::ring(30.0, 22.0, 3.0)),
        part_number: "1".to_owned(),
        content_hash: "r".to_owned(),
    };
    let upright = std::f64::consts::FRAC_PI_2;
    let build = BuildFile {
        heading: BuildFileHeading {
            title: "a chain".to_owned(),
            application: "nestd test".to_owned(),
            created: "2026-11-20T04:49:00Z".to_owned(),
            machine: "small".to_owned(),
            build_id: "2".to_owned(),
            seed: 1,
        },
        rules: BuildFileRules {
            volume_mm: DVec3::splat(60.0),
            keep_out: Vec::new(),
            margins_mm: [0.0; 3].into(),
            clearance_mm: 2.0,
            clearance_z_extra_mm: 0.0,
            layer_mm: 0.1,
            layer_area_cap_mm2: None,
            interlock: interlock.to_owned(),
        },
        height_mm: 35.0,
        density: 0.02,
        objects: vec![object],
        items: vec![item(1, 0.0, DVec3::new(20.0, 20.0, 18.5)), item(2, upright, DVec3::new(35.0, 21.5, 20.0))],
        delivery: DeliveryKind::Shared,
        arrangement: Arrangement::Items,
        thumbnail_png: None,
    };
    let file = dir.path().join("chain.build.3mf");
    write_build(&build, File::create(&file).unwrap()).unwrap();
    file
}

#[test]
fn a_chain_is_reported_and_is_a_fault_where_it_was_forbidden() {
    let dir = tempfile::tempdir().unwrap();
    let (code, text) = verify(&chain(&dir, "forbid"), &[]);
    assert!(code == 1 && text.contains("ring #2 (item 2) is locked into others"), "{text}");
    let warned = chain(&dir, "warn");
    let (code, text) = verify(&warned, &[]);
    assert!(code == 0 && text.contains("2 parts are locked"), "{text}");
    assert_eq!(verify(&warned, &["--interlock", "forbid"]).0, 1);
    let (code, text) = verify(&warned, &["--interlock", "allow", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(code == 0 && json["locked"].is_null() && json["interlock"] == "allow", "{text}");
}
