//! The judge of the benchmark of 3D packing (`benches/packing`), which others run on their entries: it accepts good ones in each form, and
//! names each fault of bad ones. The records in the repository are what it says of their entries, and the table is made of them.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    sync::Arc,
};

use build_file::{Arrangement, BuildFile, DeliveryKind, write_build};
use glam::{DMat4, DQuat, DVec3};
use sample_parts::{ComparedWorkload, axial_fan};
use serde_json::{Value, json};
use solids::{Mesh, Pose};

use crate::support::{block, stl};

/// The Python that can run the judge, if one is there.
fn python() -> Option<&'static str> {
    ["python3", "/usr/bin/python3"].into_iter().find(|program| {
        let mut imports = Command::new(program);
        let status = imports.args(["-c", "import numpy"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
        status.is_ok_and(|status| status.success())
    })
}

/// Why the judge cannot run here.
pub fn missing() -> Option<String> {
    python().is_none().then(|| "needs python3 with numpy".to_owned())
}

fn packing(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/packing").join(file)
}

fn judge() -> Command {
    let mut judge = Command::new(python().unwrap());
    judge.arg("-B").arg(packing("judge.py")); // no compiled files among the sources
    judge
}

/// The exit code of the judge, and what it says.
fn told(output: &Output) -> (Option<i32>, String) {
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    (output.status.code(), format!("{said}{errors}"))
}

/// A workload of a block with 40 mm edges and two fans of 20 x 20 x 8 mm, for a base of 100 x 60 mm and a clearance of 2 mm.
struct TinyWorkload {
    folder: tempfile::TempDir,
    block: Arc<Mesh>,
    fan: Arc<Mesh>,
}

/// Where the fans are in the good entry; the block stands at the origin.
const FANS: [DVec3; 2] = [DVec3::new(42.0, 0.0, 0.0), DVec3::new(64.0, 0.0, 0.0)];

impl TinyWorkload {
    fn write() -> Self {
        let (folder, block, fan) = (tempfile::tempdir().unwrap(), block(40.0, 40.0, 40.0), axial_fan(20.0, 8.0, 5));
        let base = fan.bounds().min;
        let vertices = fan.vertices().iter().map(|&vertex| (vertex - base).as_vec3().as_dvec3()).collect();
        let fan = Mesh::new(vertices, fan.triangles().to_vec()).unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let target = folder.path().join(name);
            fs::create_dir_all(target.parent().unwrap()).unwrap();
            fs::write(target, bytes).unwrap();
        };
        write("tiny/block.stl", &stl(&block));
        write("tiny/fan.stl", &stl(&fan));
        write("workloads/tiny.csv", b"file,quantity\ntiny/block.stl,1\ntiny/fan.stl,2\n");
        write("workloads/tiny.json", br#"{"volume_mm": [100, 60, 600], "clearance_mm": 2}"#);
        Self { folder, block: Arc::new(block), fan: Arc::new(fan) }
    }

    fn judged(&self, entry: &Path) -> (Option<i32>, String) {
        told(&judge().arg(self.folder.path()).arg("tiny").arg(entry).output().unwrap())
    }

    /// What is said of an entry with the block at the origin and each fan moved by a matrix.
    fn judged_fans(&self, fans: &[DMat4]) -> (Option<i32>, String) {
        let part = |file: &str, motion: &DMat4| {
            let rows: Vec<[f64; 4]> = (0..4).map(|row| motion.row(row).to_array()).collect();
            json!({"file": file, "transform": rows})
        };
        let mut parts = vec![part("tiny/block.stl", &DMat4::IDENTITY)];
        parts.extend(fans.iter().map(|motion| part("tiny/fan.stl", motion)));
        let entry = self.folder.path().join("entry.json");
        fs::write(&entry, json!({ "parts": parts }).to_string()).unwrap();
        self.judged(&entry)
    }

    fn build(&self, delivery: DeliveryKind, arrangement: Arrangement) -> PathBuf {
        let mut build = BuildFile::new(DVec3::new(100.0, 60.0, 600.0), 2.0);
        (build.delivery, build.arrangement) = (delivery, arrangement);
        let block = build.add_object("block", self.block.clone());
        let fan = build.add_object("fan", self.fan.clone());
        build.add_item(block, 0, Pose::IDENTITY);
        build.add_item(fan, 0, Pose::new(DQuat::IDENTITY, FANS[0]));
        // Turned by a right angle, it stands where it would stand without.
        build.add_item(fan, 1, Pose::new(DQuat::from_rotation_z(90f64.to_radians()), FANS[1] + 20.0 * DVec3::X));
        let file = self.folder.path().join("entry.3mf");
        write_build(&build, fs::File::create(&file).unwrap()).unwrap();
        file
    }
}

pub fn good_entries_count_in_each_form() {
    let tiny = TinyWorkload::write();
    for (delivery, arrangement) in [
        (DeliveryKind::Shared, Arrangement::Items),
        (DeliveryKind::Shared, Arrangement::Locked),
        (DeliveryKind::Expanded, Arrangement::Items),
    ] {
        let (code, text) = tiny.judged(&tiny.build(delivery, arrangement));
        assert_eq!(code, Some(0), "{delivery:?} {arrangement:?}: {text}");
        assert!(text.contains("height          40.0000 mm\nleast distance  2.0000 mm\n"), "{text}");
    }
    let (code, text) = tiny.judged_fans(&FANS.map(DMat4::from_translation));
    assert!(code == Some(0) && text.ends_with("OK\n"), "{text}");
    let aslant = DMat4::from_rotation_translation(DQuat::from_rotation_y(0.3), DVec3::new(70.0, 20.0, 20.0));
    assert_eq!(tiny.judged_fans(&[DMat4::from_translation(FANS[0]), aslant]).0, Some(0));
}

pub fn each_fault_of_an_entry_is_named() {
    let tiny = TinyWorkload::write();
    let [first, second] = FANS.map(DMat4::from_translation);
    let at = |x: f64, y: f64, z: f64| DMat4::from_translation(DVec3::new(x, y, z));
    for (fans, fault) in [
        (vec![first, at(63.9, 0.0, 0.0)], "tiny/fan.stl #1 and tiny/fan.stl #2 are 1.9000 mm apart, 2 mm are asked"),
        (vec![first, at(50.0, 3.0, 2.0)], "tiny/fan.stl #1 and tiny/fan.stl #2 meet"),
        (vec![first, at(10.0, 10.0, 10.0)], "tiny/fan.stl #2 is inside the solid of tiny/block.stl #1"),
        (vec![first, at(84.0, 0.0, 0.0) * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0))], "is mirrored"),
        (vec![first, second * DMat4::from_scale(DVec3::splat(0.99))], "is scaled by 0.99"),
        (vec![first, second * DMat4::from_scale(DVec3::new(1.0, 1.0, 0.9))], "away from the moved STL"),
        (vec![first], "tiny/fan.stl: 1 missing"),
        (vec![first, second, at(42.0, 30.0, 0.0)], "tiny/fan.stl: 1 too many"),
        (vec![first, at(64.0, 0.0, -0.01)], "tiny/fan.stl #2 is 0.0100 mm below the floor"),
        (vec![first, at(80.5, 0.0, 0.0)], "tiny/fan.stl #2 is 0.5000 mm outside the base of 100 x 60 mm"),
    ] {
        let (code, text) = tiny.judged_fans(&fans);
        assert!(code == Some(1) && text.contains(fault), "{fault}: {text}");
        // A copy that is none of the parts is also missing.
        assert_eq!(text.matches("FAULT").count(), 1 + usize::from(text.contains("FAULT: copy")), "{text}");
    }
    let wrong = tiny.folder.path().join("wrong");
    for text in ["no entry", "{}", r#"{"parts": [{"file": "other.stl", "transform": []}]}"#] {
        fs::write(&wrong, text).unwrap();
        assert_eq!(tiny.judged(&wrong).0, Some(2), "{text}");
    }
    assert_eq!(tiny.judged(&tiny.folder.path().join("none")).0, Some(2));
}

pub fn a_record_is_what_the_judge_says_of_its_entry_and_the_table_is_made_of_all() {
    let records: Value = serde_json::from_slice(&fs::read(packing("results.json")).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for file in ComparedWorkload::named("fans20").unwrap().files() {
        let target = folder.path().join(&file.path);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::write(target, file.bytes).unwrap();
    }
    let mut judged = 0;
    for record in records["entries"].as_array().unwrap() {
        let word = |key: &str| record[key].as_str().unwrap_or_default().to_owned();
        assert!(ComparedWorkload::named(&word("workload")).is_some(), "{record}");
        let entry = packing(&word("file"));
        if !entry.is_file() || word("workload") != "fans20" {
            continue;
        }
        judged += 1;
        let said = folder.path().join("said.json");
        judge().arg(folder.path()).arg("fans20").arg(&entry).arg("--json").arg(&said).output().unwrap();
        let said: Value = serde_json::from_slice(&fs::read(&said).unwrap()).unwrap();
        for key in ["height_mm", "least_distance_mm", "file_sha256"] {
            assert_eq!(said[key], record[key], "{record}");
        }
        assert_eq!(said["ok"], record["clearance_ok"], "{record}");
    }
    assert!(judged > 0, "no entry of fans20 is in the repository");
    let (code, table) = told(&judge().arg("--table").arg(packing("results.json")).output().unwrap());
    let page = fs::read_to_string(packing("README.md")).unwrap();
    assert!(code == Some(0) && page.contains(&table), "write this into benches/packing/README.md:\n{table}");
}
