//! A build for tests, of this crate and of `nestd nest`.

use std::{
    io::{Cursor, Read, Write},
    sync::Arc,
};

use build_file::{Arrangement, DeliveryKind};
use delivery::build::{BuildHeading, BuildPart, MachineSpec, PartPlacement, SolvedBuild};
use glam::{DQuat, DVec3};
use nester::{InterlockRule, LayerAreaCap, OrientationLimits, OrientationRule, VolumeMargins};
use solids::Pose;
use zip::{ZipArchive, ZipWriter, write::SimpleFileOptions};

/// A cube of 10 mm that stands free on a machine of 100 mm.
pub fn one_cube() -> SolvedBuild {
    let machine = MachineSpec {
        name: "small".to_owned(),
        volume_mm: DVec3::splat(100.0),
        margins: VolumeMargins { wall_mm: 2.0, floor_mm: 3.0, lid_mm: 1.0 },
        keep_out: Vec::new(),
        clearance_mm: 3.0,
        clearance_z_extra_mm: 0.0,
        layer_cap: LayerAreaCap::default(),
        interlock: InterlockRule::Forbid,
        delivery: DeliveryKind::default(),
        arrangement: Arrangement::default(),
    };
    let part = BuildPart {
        name: "cube.stl".to_owned(),
        object_name: "cube.stl".to_owned(),
        part_number: "7".to_owned(),
        source_name: "cube.stl".to_owned(),
        source_hash: "00".to_owned(),
        content_hash: "00-0".to_owned(),
        mesh: Arc::new(sample_parts::cuboid(DVec3::splat(10.0))),
        copies: vec![4],
        orientation: OrientationLimits::new(OrientationRule::Upright, &[], &[]),
        clearance_mm: None,
        words: Default::default(),
    };
    let pose = Pose::new(DQuat::from_rotation_z(0.3), DVec3::splat(20.0));
    SolvedBuild {
        heading: BuildHeading {
            title: "one cube".to_owned(),
            build_id: "1".to_owned(),
            created: jiff::Timestamp::UNIX_EPOCH,
            seed: 1,
        },
        machine,
        parts: vec![part],
        placed: vec![PartPlacement { part: 0, copy: 4, pose }],
        height_mm: 30.0,
        density: 0.1,
    }
}

/// A written build with one more item that is not printable: our reader leaves it out, the second reader counts it.
pub fn with_an_item_more(package: &[u8]) -> Vec<u8> {
    let mut package = ZipArchive::new(Cursor::new(package)).unwrap();
    let mut changed = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..package.len() {
        let mut entry = package.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if entry.name().ends_with(".model") {
            let text = String::from_utf8(bytes).unwrap();
            let (_, id) = text.split_once(" objectid=\"").unwrap();
            let (id, _) = id.split_once('"').unwrap();
            let item = format!("<item objectid=\"{id}\" printable=\"0\"/></build>");
            bytes = text.replace("</build>", &item).into_bytes();
        }
        changed.start_file(entry.name().to_owned(), SimpleFileOptions::default()).unwrap();
        changed.write_all(&bytes).unwrap();
    }
    changed.finish().unwrap().into_inner()
}
