//! Tests that a written build is read back the same, by our reader and by another one.

use std::{io::Cursor, path::Path, sync::Arc};

use glam::{DQuat, DVec3};
use solids::{Bounds, Mesh, Pose};

use crate::*;

/// A box with its lower corner at the origin.
fn cuboid(size: DVec3) -> Mesh {
    let vertices =
        (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64) * size).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::new(vertices, triangles).unwrap()
}

fn object(name: &str, size: DVec3) -> BuildFileObject {
    BuildFileObject {
        name: name.to_owned(),
        mesh: Arc::new(cuboid(size)),
        part_number: format!("P-{name}"),
        content_hash: blake3::hash(name.as_bytes()).to_string(),
    }
}

fn item(object: usize, copy: u32, pose: Pose) -> BuildFileItem {
    BuildFileItem {
        object,
        pose,
        words: OrderWords {
            order: (copy == 1).then(|| "order 7".to_owned()),
            due: (copy == 1).then(|| "2026-12-24".to_owned()),
            note: (copy == 1).then(|| "nicht strahlen".to_owned()),
            reference: (copy == 1).then(|| "550e8400-e29b-41d4-a716-446655440000".to_owned()),
            material: (copy == 1).then(|| "PA12".to_owned()),
        },
        copy,
        source_name: "a & b <ü>.stl".to_owned(),
        source_hash: "0123".to_owned(),
        clearance_mm: (copy == 2).then_some(2.5),
        orientation: Some("upright".to_owned()),
        tilts: Some("0,0,1:30;".repeat(40) + "1,-0.5e-3,0:90"),
    }
}

/// Three copies of two parts, in several orientations.
pub(super) fn sample(delivery: DeliveryKind, arrangement: Arrangement) -> BuildFile {
    let turned = |x: f64, y: f64, z: f64, at: DVec3| {
        Pose::new(DQuat::from_euler(glam::EulerRot::XYZ, x, y, z), at + DVec3::splat(1.0 / 3.0))
    };
    BuildFile {
        heading: BuildFileHeading {
            title: "mjf-5200 42".to_owned(),
            application: "nestd 0.1.0".to_owned(),
            created: "2026-11-20T04:49:00Z".to_owned(),
            machine: "mjf-5200".to_owned(),
            build_id: "42".to_owned(),
            seed: 7,
        },
        rules: BuildFileRules {
            volume_mm: DVec3::new(380.0, 284.0, 380.0),
            keep_out: vec![Bounds { min: DVec3::ZERO, max: DVec3::new(40.5, 1.0 / 3.0, 10.0) }],
            margins_mm: DVec3::ZERO,
            clearance_mm: 3.0,
            clearance_z_extra_mm: 0.0,
            layer_mm: 0.1,
            layer_area_cap_mm2: None,
            interlock: "forbid".to_owned(),
        },
        height_mm: 61.5,
        density: 0.123,
        objects: vec![
            object("plate", DVec3::new(0.1_f32.into(), 20.0, 30.7)),
            object("cube", DVec3::splat(10.0 / 3.0)),
            object("unused", DVec3::ONE),
        ],
        items: vec![
            item(0, 1, turned(0.3, -0.2, 1.1, DVec3::new(50.0, 60.0, 20.0))),
            item(1, 1, turned(3.1, 0.0, -2.0, DVec3::new(100.0, 60.0, 20.0))),
            item(0, 2, turned(0.0, 0.0, 0.0, DVec3::new(150.0, 100.0, 40.0))),
        ],
        delivery,
        arrangement,
        thumbnail_png: Some(vec![1, 2, 3]),
    }
}

pub(crate) fn bytes(build: &BuildFile) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write_build(build, &mut out).unwrap();
    out.into_inner()
}

pub(super) fn with_file<T>(bytes: &[u8], then: impl FnOnce(&Path) -> T) -> T {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    then(file.path())
}

pub(super) const CHOICES: [(DeliveryKind, Arrangement); 4] = [
    (DeliveryKind::Shared, Arrangement::Items),
    (DeliveryKind::Expanded, Arrangement::Items),
    (DeliveryKind::Shared, Arrangement::Locked),
    (DeliveryKind::Expanded, Arrangement::Locked),
];

#[test]
fn what_is_written_is_read_back_exactly() {
    for (delivery, arrangement) in CHOICES {
        let build = sample(delivery, arrangement);
        let (info, placed) =
            with_file(&bytes(&build), |f| read_build_and_metadata(f, &ReadLimits::for_testing()).unwrap());
        assert_eq!(placed.len(), 3);
        for (read, item) in placed.iter().zip(&build.items) {
            let object = &build.objects[item.object];
            match delivery {
                DeliveryKind::Expanded => {
                    let off = read.mesh.vertices().iter().zip(object.mesh.vertices()).map(|(a, b)| a.distance(*b));
                    assert!(off.fold(0.0, f64::max) < 1e-12, "they were turned, moved, and moved back");
                }
                _ => {
                    assert_eq!(read.mesh.vertices(), object.mesh.vertices(), "no digit of a vertex may be lost");
                }
            }
            assert_eq!(read.mesh.triangles(), object.mesh.triangles());
            assert!(read.pose.translation == item.pose.translation);
            assert!(read.pose.rotation.angle_between(item.pose.rotation) < 1e-7);
            let corner = DVec3::splat(300.0);
            assert!(read.pose.transform_point(corner).distance(item.pose.transform_point(corner)) < 1e-10);
            assert_eq!((read.name.as_str(), read.copy), (object.name.as_str(), Some(item.copy)));
            assert_eq!(read.part_number.as_deref(), Some(object.part_number.as_str()));
            assert_eq!((&read.words, &read.orientation), (&item.words, &item.orientation));
            assert_eq!(read.tilts, item.tilts);
            assert_eq!(read.source_name.as_deref(), Some("a _ b _ü_.stl"));
            assert_eq!((read.source_hash.as_deref(), read.clearance_mm), (Some("0123"), item.clearance_mm));
        }
        let shared = Arc::ptr_eq(&placed[0].mesh, &placed[2].mesh);
        assert_eq!(shared, delivery == DeliveryKind::Shared);
        assert_eq!(info.heading.machine.as_deref(), Some("mjf-5200"));
        assert_eq!((info.heading.seed, info.rules.clearance_mm, info.height_mm), (Some(7), Some(3.0), Some(61.5)));
        assert_eq!((info.rules.volume_mm, info.density), (Some(build.rules.volume_mm), Some(0.123)));
        assert_eq!(info.rules.keep_out, build.rules.keep_out);
        assert_eq!(info.heading.created.as_deref(), Some("2026-11-20T04:49:00Z"));
    }
}

#[test]
fn no_coordinate_of_a_build_is_below_zero() {
    for arrangement in [Arrangement::Items, Arrangement::Locked] {
        let mut build = sample(DeliveryKind::Shared, arrangement);
        let turned = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, 0.1);
        for (item, rotation) in build.items.iter_mut().zip([DQuat::IDENTITY, DQuat::from_rotation_z(1.5), turned]) {
            let at = build.objects[item.object].mesh.bounds_at(&Pose::new(rotation, DVec3::ZERO)).min;
            item.pose = Pose::new(rotation, -at - DVec3::splat(4e-7));
        }
        let mut bytes = Cursor::new(Vec::new());
        write_build(&build, &mut bytes).unwrap();
        let placed = with_file(bytes.get_ref(), |file| read_build(file, &ReadLimits::default())).unwrap();
        for one in &placed {
            let lowest = one.mesh.bounds_at(&one.pose).min;
            assert!(lowest.min_element() >= 0.0 && lowest.max_element() < 2e-9, "{lowest}");
        }
        build.items[0].pose.translation.x -= 1.0;
        let mut bytes = Cursor::new(Vec::new());
        write_build(&build, &mut bytes).unwrap();
        let placed = with_file(bytes.get_ref(), |file| read_build(file, &ReadLimits::default())).unwrap();
        let lowest = placed[0].mesh.bounds_at(&placed[0].pose).min.x;
        assert!(lowest < -0.99, "what really stands outside is not hidden: {lowest}");
    }
}

#[test]
fn the_same_build_gives_the_same_bytes() {
    let build = sample(DeliveryKind::Shared, Arrangement::Items);
    let first = bytes(&build);
    assert_eq!(first, bytes(&build.clone()));
    let mut other = build;
    other.heading.build_id = "43".to_owned();
    assert_ne!(first, bytes(&other));
}

#[test]
fn a_second_reader_agrees_and_notices_a_swap() {
    for (delivery, arrangement) in CHOICES {
        with_file(&bytes(&sample(delivery, arrangement)), |file| {
            let limits = ReadLimits::for_testing();
            let mut placed = read_build(file, &limits).unwrap();
            cross_check(file, &placed, &limits).unwrap();
            let inverse = placed[0].pose.rotation.conjugate();
            placed[0].pose.rotation = inverse;
            assert!(cross_check(file, &placed, &limits).is_err(), "a transposed rotation has to be noticed");
        });
    }
}

#[test]
fn a_second_reader_notices_what_is_a_little_off_and_a_mesh_of_the_same_bounds() {
    with_file(&bytes(&sample(DeliveryKind::Shared, Arrangement::Items)), |file| {
        let limits = ReadLimits::for_testing();
        let placed = read_build(file, &limits).unwrap();
        for (off_mm, agrees) in [(5e-7, true), (2e-6, false), (0.1, false), (1.0, false)] {
            let mut moved = placed.clone();
            moved[1].pose.translation.y += off_mm;
            assert_eq!(cross_check(file, &moved, &limits).is_ok(), agrees, "{off_mm} mm");
        }
        let (mut divided, mesh) = (placed.clone(), &placed[1].mesh);
        let (mut corners, mut triangles) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
        let Some([a, b, c]) = triangles.pop() else { panic!("it has triangles") };
        let middle = corners.len() as u32;
        corners.push((corners[a as usize] + corners[b as usize]) / 2.0);
        triangles.extend([[a, middle, c], [middle, b, c]]);
        divided[1].mesh = Arc::new(Mesh::new(corners, triangles).unwrap());
        assert!(cross_check(file, &divided, &limits).is_err(), "a triangle more");
    });
}

#[test]
fn a_build_dropped_again_gives_its_parts_with_copies() {
    with_file(&bytes(&sample(DeliveryKind::Shared, Arrangement::Items)), |file| {
        let contents = read_part_file(file, "again.3mf", None, LengthUnit::Inch, &ReadLimits::for_testing()).unwrap();
        let named: Vec<(&str, u32)> = contents.solids.iter().map(|s| (s.name.as_str(), s.copies)).collect();
        assert_eq!(named, [("plate", 1), ("cube", 1), ("plate", 1)], "each rotation is a part of its own");
    });
}

#[test]
fn a_build_that_makes_no_sense_is_not_written() {
    let sane = sample(DeliveryKind::Shared, Arrangement::Items);
    let empty = BuildFile { items: Vec::new(), ..sane.clone() };
    let mut undated = sane.clone();
    undated.heading.created = "yesterday".to_owned();
    let mut dangling = sane.clone();
    dangling.items[1].object = 9;
    let mut lost = sane;
    lost.items[0].pose.translation.x = f64::NAN;
    for build in [empty, undated, dangling, lost] {
        assert!(matches!(write_build(&build, Cursor::new(Vec::new())), Err(FileWriteError::Build(_))));
    }
}

#[test]
fn the_whole_build_as_stl_stands_where_the_items_stand() {
    let build = sample(DeliveryKind::Shared, Arrangement::Items);
    let mut out = Vec::new();
    write_stl(build.items.iter().map(|i| (&*build.objects[i.object].mesh, &i.pose)), &mut out).unwrap();
    assert_eq!(out.len(), 84 + 50 * 36);
    let contents = with_file(&out, |f| {
        read_part_file(f, "all.stl", None, LengthUnit::Millimeter, &ReadLimits::for_testing()).unwrap()
    });
    let mesh = &contents.solids[0].mesh;
    let top = build.items.iter().map(|i| build.objects[i.object].mesh.bounds_at(&i.pose).max.z).fold(0.0, f64::max);
    assert!((mesh.bounds().max.z - top).abs() < 1e-5);
    assert!(write_stl(std::iter::empty(), Vec::new()).is_err());
}

#[test]
fn the_pick_map_has_a_row_per_copy() {
    let build = sample(DeliveryKind::Shared, Arrangement::Items);
    let mut out = Vec::new();
    write_pick_map(pick_rows(&build), &mut out).unwrap();
    let mut reader = csv::Reader::from_reader(out.as_slice());
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 3);
    assert_eq!(&rows[2][0], "3");
    assert_eq!(&rows[2][5], "a & b <ü>.stl");
    let top: f64 = rows[2][12].parse().unwrap();
    assert!((top - (40.0 + 1.0 / 3.0 + 30.7)).abs() < 1e-3);
}

#[test]
fn build_files_are_named_so_that_they_sort_by_time() {
    let created = "2026-11-20T04:49:00Z".parse().unwrap();
    for (kind, name) in DeliveryKind::ALL.into_iter().zip(["build.3mf", "build.3mf", "build.stl", "build.zip"]) {
        let name = format!("20261120T044900Z_mjf-5200_000042.{name}");
        assert_eq!(build_file_name(created, "mjf-5200", 42, kind), name);
        assert_eq!(build_file_stem(&name), Some("20261120T044900Z_mjf-5200_000042"));
    }
    let odd = build_file_name(created, &"ö _/".repeat(99), u64::MAX, DeliveryKind::Shared);
    assert!(odd.is_ascii() && odd.len() <= 100 && !odd.contains(['/', ' ']), "{odd}");
}
