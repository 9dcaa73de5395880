//! Each kind of delivery holds the same copies in the same places, and a fault in one is found.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::DVec3;
use solids::{Mesh, Pose};

use super::build_tests::sample;
use crate::*;

const LIMITS: fn() -> ReadLimits = ReadLimits::for_testing;

/// A build of this kind, with a part whose numbers need more than 32 bits and one far from its origin.
fn build(kind: DeliveryKind) -> BuildFile {
    let mut build = sample(kind, Arrangement::Items);
    let cube = build.objects[1].mesh.clone();
    let far = cube.vertices().iter().map(|corner| *corner + DVec3::new(3000.25, 0.0, 0.0)).collect();
    build.objects[1].mesh = Arc::new(Mesh::new(far, cube.triangles().to_vec()).unwrap());
    let turned = build.items[1].pose;
    let translation = turned.translation - turned.rotation * DVec3::new(3000.25, 0.0, 0.0);
    build.items[1].pose = Pose { translation, ..turned };
    build
}

/// The file of a build below its name, with its table.
fn write(build: &BuildFile, folder: &Path) -> PathBuf {
    let name = build_file_name("2026-11-20T04:49:00Z".parse().unwrap(), "mjf-5200", 42, build.delivery);
    let file = folder.join(&name);
    write_build(build, fs::File::create(&file).unwrap()).unwrap();
    if build.delivery == DeliveryKind::Stl {
        let table = folder.join(placement_table_name(build_file_stem(&name).unwrap()));
        write_placement_table(build, fs::File::create(table).unwrap()).unwrap();
    }
    file
}

#[test]
fn every_kind_holds_the_same_copies_in_the_same_places() {
    for kind in DeliveryKind::ALL {
        let (folder, build) = (tempfile::tempdir().unwrap(), build(kind));
        let file = write(&build, folder.path());
        let (info, placed) = read_build_and_metadata(&file, &LIMITS()).unwrap();
        cross_check_stl(&file, &build, &LIMITS()).unwrap();
        assert_eq!(placed.len(), build.items.len(), "{kind:?}");
        let most_mm = kind.rounding_mm(build.rules.volume_mm).max(1e-9);
        for (read, item) in placed.iter().zip(&build.items) {
            let object = &build.objects[item.object];
            assert!((read.pose.translation - item.pose.translation).length() < 1e-9, "{kind:?}");
            for triangle in 0..object.mesh.triangles().len() {
                let corners = |mesh: &Mesh, pose: &Pose| mesh.corners(triangle).map(|c| pose.transform_point(c));
                let (was, is) = (corners(&object.mesh, &item.pose), corners(&read.mesh, &read.pose));
                assert!(was.iter().zip(is).all(|(was, is)| was.distance(is) <= most_mm), "{kind:?}: {was:?} {is:?}");
            }
            assert_eq!((&read.words, read.copy), (&item.words, Some(item.copy)));
            assert_eq!(read.part_number.as_deref(), Some(object.part_number.as_str()));
            assert_eq!((&read.orientation, &read.tilts), (&item.orientation, &item.tilts));
            assert_eq!((read.source_hash.as_deref(), read.clearance_mm), (Some("0123"), item.clearance_mm));
        }
        // One mesh for the copies of a part, where the file has one.
        let is_shared = matches!(kind, DeliveryKind::Shared | DeliveryKind::Parts);
        assert_eq!(Arc::ptr_eq(&placed[0].mesh, &placed[2].mesh), is_shared, "{kind:?}");
        if kind != DeliveryKind::Stl {
            assert_eq!((info.rules.clearance_mm, info.rules.keep_out), (Some(3.0), build.rules.keep_out.clone()));
        }
        let renamed = folder.path().join("job.bin");
        fs::rename(&file, &renamed).unwrap();
        let own = read_own_name(&renamed, &LIMITS()).unwrap();
        assert_eq!(own.as_deref(), file.file_name().unwrap().to_str(), "it says what it is under any name");
    }
}

#[test]
fn an_expanded_model_has_no_transforms_and_each_copy_in_its_place() {
    for arrangement in [Arrangement::Items, Arrangement::Locked] {
        let folder = tempfile::tempdir().unwrap();
        let build = BuildFile { arrangement, ..build(DeliveryKind::Expanded) };
        let file = write(&build, folder.path());
        let mut package = zip::ZipArchive::new(fs::File::open(&file).unwrap()).unwrap();
        let model = std::io::read_to_string(package.by_name("3D/3dmodel.model").unwrap()).unwrap();
        assert!(!model.contains("transform"), "{arrangement:?}");
        assert_eq!(model.matches("<mesh>").count(), 3);
        cross_check(&file, &read_build(&file, &LIMITS()).unwrap(), &LIMITS()).unwrap();
    }
}

#[test]
fn a_whole_build_as_stl_without_its_table_is_not_guessed_at() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(&build(DeliveryKind::Stl), folder.path());
    let table =
        folder.path().join(placement_table_name(build_file_stem(file.file_name().unwrap().to_str().unwrap()).unwrap()));
    let text = fs::read_to_string(&table).unwrap();
    for (from, to) in [(",12,", ",11,"), (",12,", ",13,")] {
        fs::write(&table, text.replacen(from, to, 1)).unwrap();
        let error = read_build(&file, &LIMITS()).unwrap_err().to_string();
        assert!(error.contains("36 triangles") && error.contains("the table"), "{error}");
    }
    fs::remove_file(table).unwrap();
    let error = read_build(&file, &LIMITS()).unwrap_err();
    assert!(error.to_string().contains("is not beside it"), "{error}");
}

#[test]
fn a_second_reader_finds_a_copy_that_is_elsewhere_or_has_another_shape() {
    for kind in [DeliveryKind::Stl, DeliveryKind::Parts] {
        let folder = tempfile::tempdir().unwrap();
        let wanted = build(kind);
        let moved = |off_mm: f64| {
            let mut moved = wanted.clone();
            moved.items[2].pose.translation.y += off_mm;
            moved
        };
        let turned = {
            let mut turned = wanted.clone();
            turned.items[0].pose.rotation = turned.items[0].pose.rotation.conjugate();
            turned
        };
        let mut without = wanted.clone();
        without.items.pop();
        let found = |written: &BuildFile| cross_check_stl(&write(written, folder.path()), &wanted, &LIMITS()).is_err();
        assert_eq!([&moved(0.0), &moved(1e-3), &turned, &without].map(found), [false, true, true, true], "{kind:?}");
    }
}

#[test]
fn a_table_with_a_place_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(&build(DeliveryKind::Stl), folder.path());
    let table = folder.path().join("20261120T044900Z_mjf-5200_000042.placements.csv");
    let text = fs::read_to_string(&table).unwrap();
    let cell = |name: &str| text.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
    for (column, value) in [("quaternion_w", "7"), ("position_x_mm", "inf"), ("origin_y_mm", ""), ("triangles", "-1")] {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut cells: Vec<&str> = lines[1].split(',').collect();
        cells[cell(column)] = value;
        lines[1] = cells.join(",");
        fs::write(&table, lines.join("\n")).unwrap();
        let error = read_build(&file, &LIMITS()).unwrap_err().to_string();
        assert!(error.contains("row 1 of the table"), "{column}: {error}");
    }
}
