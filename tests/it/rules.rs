//! Rules of orientation and clearance: given to `nestd nest`, and checked in the file that it wrote.

use std::{
    fs::File,
    path::{Path, PathBuf},
};

use assert_cmd::Command;
use build_file::{ReadLimits, write_stl};
use glam::DVec3;
use nester::{PlacedSolid, VolumeMargins};
use solids::{Mesh, Pose};

/// A wedge: a box whose upper edge runs along one side only.
fn wedge(dir: &Path, name: &str, size: DVec3) -> PathBuf {
    let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1]];
    let vertices = corners.map(|c| size * DVec3::from_array(c.map(f64::from))).to_vec();
    let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 5], [0, 5, 4], [1, 2, 5], [0, 4, 3], [3, 4, 5], [3, 5, 2]];
    let mesh = Mesh::new(vertices, triangles).unwrap();
    let file = dir.join(name);
    write_stl([(&mesh, &Pose::IDENTITY)].into_iter(), File::create(&file).unwrap()).unwrap();
    file
}

fn nestd(words: &[&str]) -> (i32, String) {
    let out = Command::cargo_bin("nestd").unwrap().args(words).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    (out.status.code().unwrap(), text)
}

/// Nests six wedges and six plates in 60 x 60 x 120 mm with the given options; returns the written file.
fn nested(dir: &Path, options: &[&str]) -> PathBuf {
    let wedges = format!("{}=6", wedge(dir, "wedge.stl", DVec3::new(20.0, 12.0, 9.0)).display());
    let plates = format!("{}=6", wedge(dir, "plate.stl", DVec3::new(25.0, 18.0, 3.0)).display());
    let file = dir.join("a.build.3mf");
    let out = file.to_str().unwrap();
    let fixed = ["nest", "--volume", "60x60x120", "--evaluations", "1500", &wedges, &plates, "-o", out];
    let (code, text) = nestd(&[&fixed[..], options].concat());
    assert_eq!(code, 0, "{text}");
    file
}

/// The proof of the written file, without its own metadata.
fn proof(file: &Path, margins: VolumeMargins, clearance_mm: f64, extra_mm: f64) -> nester::LayoutProof {
    let read = build_file::read_build(file, &ReadLimits::default()).unwrap();
    let bodies: Vec<PlacedSolid> = (read.into_iter())
        .map(|item| {
            let pose = Pose { translation: item.pose.translation - margins.origin_mm(), ..item.pose };
            PlacedSolid { name: item.name, mesh: item.mesh, pose, clearance_mm }
        })
        .collect();
    assert_eq!(bodies.len(), 12);
    nester::prove_with_z_extra(&bodies, margins.usable_volume(DVec3::new(60.0, 60.0, 120.0)).size_mm, extra_mm)
}

#[test]
fn margins_and_clearances_hold_in_the_written_file() {
    let dir = tempfile::tempdir().unwrap();
    for method in ["nestd", "paper"] {
        let options = ["--method", method, "--clearance", "1", "--clearance-z-extra", "2.5", "--margins", "2,7,4"];
        let file = nested(dir.path(), &options);
        let margins = VolumeMargins { wall_mm: 2.0, floor_mm: 7.0, lid_mm: 4.0 };
        assert!(proof(&file, margins, 1.0, 2.5).is_proved(), "{method}");
        assert!(
            !proof(&file, VolumeMargins { floor_mm: 7.5, ..margins }, 1.0, 2.5).is_proved(),
            "parts stand on the floor"
        );
        let (code, text) = nestd(&["verify", file.to_str().unwrap()]);
        assert_eq!(code, 0, "{text}");
        assert!(text.contains("7 at the floor") && text.contains("up to 2.5 mm"), "{text}");
        let (code, _) = nestd(&["verify", file.to_str().unwrap(), "--margins", "2.6,7,4"]);
        assert_eq!(code, 1, "parts stand at the walls");
    }
}

#[test]
fn no_layer_of_the_written_file_is_filled_beyond_its_cap() {
    let dir = tempfile::tempdir().unwrap();
    let report = dir.path().join("report.json");
    let plain = nested(dir.path(), &["--clearance", "1", "--report", report.to_str().unwrap()]);
    let layer_cap_of = |file: &Path| {
        build_file::read_build_and_metadata(file, &ReadLimits::default()).unwrap().0.rules.layer_area_cap_mm2
    };
    assert_eq!(layer_cap_of(&plain), None);
    let largest = |json: &serde_json::Value| json["layers"]["largest_area_mm2"].as_f64().unwrap();
    let free: serde_json::Value = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
    assert!(free["layers"]["cap_mm2"].is_null() && free["packed_density"].as_f64().unwrap() > 0.05);
    let share = 0.7 * largest(&free) / 3600.0;
    let options = ["--clearance", "1", "--layer-area-cap", &share.to_string(), "--report", report.to_str().unwrap()];
    let file = nested(dir.path(), &options);
    let capped: serde_json::Value = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
    assert!(largest(&capped) <= 0.7 * largest(&free) * (1.0 + 1e-5), "{capped}");
    assert_eq!(layer_cap_of(&file), Some(share * 3600.0));
    assert_eq!(nestd(&["verify", file.to_str().unwrap()]).0, 0);
}

#[test]
fn directions_stay_up_in_the_written_file() {
    let dir = tempfile::tempdir().unwrap();
    for method in ["nestd", "paper"] {
        let options = ["--method", method, "--clearance", "1", "--keep-up", "1,0,0:25", "--not-down", "-1,0.2,0:5"];
        let file = nested(dir.path(), &options);
        for item in build_file::read_build(&file, &ReadLimits::default()).unwrap() {
            let stands = item.pose.transform_direction(DVec3::X).z;
            assert!(stands >= 25_f64.to_radians().cos() - 1e-9, "{stands}");
            assert!(
                item.pose.transform_direction(DVec3::new(-1.0, 0.2, 0.0)).angle_between(DVec3::NEG_Z)
                    >= 5_f64.to_radians() - 1e-6
            );
            assert!(item.tilts.unwrap().starts_with("1,0,0:25;-0.98"));
        }
        assert_eq!(nestd(&["verify", file.to_str().unwrap()]).0, 0);
    }
}

#[test]
fn rules_that_clash_are_reported_and_nothing_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let part = wedge(dir.path(), "part.stl", DVec3::splat(10.0));
    let out = dir.path().join("none.build.3mf");
    let words = ["--volume", "50x50x50", "--keep-up", "0,0,1:30", "--not-down", "0,0,-1:170", "--evaluations", "100"];
    let (code, text) = nestd(&[&["nest", part.to_str().unwrap(), "-o", out.to_str().unwrap()], &words[..]].concat());
    assert!(code == 1 && text.contains("part.stl: no rotation obeys all of its orientation rules"), "{text}");
    assert!(!out.exists());
    let (code, text) =
        nestd(&["nest", part.to_str().unwrap(), "-o", "x.3mf", "--volume", "9x9x9", "--keep-up", "0,0,0:30"]);
    assert!(code == 2 && text.contains("not all 0"), "{text}");
}

#[test]
fn what_finds_no_place_is_told_with_where_it_would_fit() {
    let dir = tempfile::tempdir().unwrap();
    let part = format!("{}=3", wedge(dir.path(), "part.stl", DVec3::splat(20.0)).display());
    let long = wedge(dir.path(), "long.stl", DVec3::new(90.0, 5.0, 5.0));
    let [out, report] = ["a.build.3mf", "a.json"].map(|name| dir.path().join(name).to_str().unwrap().to_owned());
    let words = ["--volume", "45x22x22", "--clearance", "2", "--evaluations", "500", "-o", &out, "--report", &report];
    let (code, text) = nestd(&[&["nest", &part, long.to_str().unwrap()], &words[..]].concat());
    let fits = "one of them would fit alone, and beside the first 1 of the 2 placed copies (50 % of their volume)";
    assert!(code == 1 && text.contains(&format!("part.stl: 1 of 3 copies found no place: {fits}")), "{text}");
    assert!(text.contains("long.stl: needs "), "{text}");
    let report: nester::NestingReport = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    let told: Vec<_> = report.unplaced.into_iter().map(|left| (left.part, left.copy, left.fits.unwrap())).collect();
    assert_eq!((told[0].1, told[0].2.alone, told[0].2.beside, told[0].2.reason.as_str()), (2, true, Some(1), fits));
    assert_eq!((told[1].0.as_str(), told[1].2.alone, told[1].2.beside), ("long.stl", false, None));
}
