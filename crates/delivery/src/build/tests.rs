//! Written files are proved, and faults in a written file are detected.

use std::{
    io::{Cursor, Write},
    sync::Arc,
};

use build_file::{DeliveryKind, ReadLimits};
use glam::{DQuat, DVec3};
use nester::{InterlockRule, LayerAreaCap, OrientationLimits, OrientationRule};
use solids::Pose;

use super::{
    fixtures::{one_cube, with_an_item_more},
    *,
};

/// Proves `asked` against a file that contains `written`.
fn proved(asked: &SolvedBuild, written: &SolvedBuild) -> Result<ProvedBuild, String> {
    let (mut file, mut table) = (tempfile::NamedTempFile::new().unwrap(), tempfile::NamedTempFile::new().unwrap());
    let description = written.to_build_file((16, 16));
    build_file::write_build(&description, file.as_file_mut()).unwrap();
    build_file::write_placement_table(&description, table.as_file_mut()).unwrap();
    asked
        .prove_written_file(file.path(), Some(table.path()), &ReadLimits::for_testing())
        .map_err(|error| format!("{:#}", anyhow::Error::from(error)))
}

#[test]
fn a_build_that_is_written_as_it_was_found_is_proved() {
    let build = one_cube();
    let proved = proved(&build, &build).unwrap();
    assert!(proved.proof.is_proved() && proved.separability.is_some());
    assert_eq!((proved.removal_order[0].0, proved.removal_order[0].1), (0, 4));
    assert_eq!(build.machine_height_mm(), 33.0);
}

#[test]
fn a_build_that_a_second_reader_reads_differently_is_not_proved() {
    let build = one_cube();
    let mut written = Cursor::new(Vec::new());
    build_file::write_build(&build.to_build_file((16, 16)), &mut written).unwrap();
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(&with_an_item_more(written.get_ref())).unwrap();
    let error = build.prove_written_file(file.path(), None, &ReadLimits::for_testing()).unwrap_err();
    assert!(matches!(error, BuildProofError::SecondReader(_)), "{error:?}");
}

/// A fault in the written file, and the expected message.
type WriteFault = (&'static str, fn(&mut SolvedBuild));

#[test]
fn a_build_that_holds_something_else_is_not_proved() {
    let wrong: [WriteFault; 8] = [
        ("which was not asked for", |build| build.parts[0].part_number = "8".to_owned()),
        ("other copies", |build| build.placed[0].copy = 5),
        ("another mesh", |build| {
            build.parts[0].mesh = Arc::new(sample_parts::cuboid(DVec3::new(10.0, 10.0, 10.0 + 1e-6)));
        }),
        ("turned against its orientation rule", |build| {
            build.placed[0].pose.rotation = DQuat::from_rotation_x(0.3);
        }),
        ("2 placements instead of 1", |build| {
            let mut again = build.placed[0].clone();
            again.pose.translation.x += 40.0;
            build.placed.push(again);
        }),
        ("another mesh", |build| {
            let cube = &build.parts[0].mesh;
            let mut vertices = cube.vertices().to_vec();
            let corner = vertices[0];
            vertices[0] = corner.lerp(DVec3::splat(5.0), 0.2);
            build.parts[0].mesh = Arc::new(solids::Mesh::new(vertices, cube.triangles().to_vec()).unwrap());
        }),
        ("out of the volume", |build| build.placed[0].pose.translation.x = 95.0),
        ("keep-out box 1", |_| {}),
    ];
    for (expected, change) in wrong {
        let (mut asked, mut written) = (one_cube(), one_cube());
        change(&mut written);
        if expected.starts_with("keep-out") {
            let cube = solids::Bounds { min: DVec3::splat(20.0), max: DVec3::splat(40.0) };
            asked.machine.keep_out.push(cube);
        }
        let refused = proved(&asked, &written).unwrap_err();
        assert!(refused.contains(expected), "{refused}");
    }
}

/// Two copies of the cube, the second one moved along x.
fn two_cubes(moved_mm: f64, copy: u32) -> SolvedBuild {
    let mut build = one_cube();
    build.parts[0].copies = vec![4, 5];
    let mut second = build.placed[0].clone();
    second.copy = copy;
    second.pose.translation.x += moved_mm;
    build.placed.push(second);
    build
}

#[test]
fn copies_that_are_too_close_or_there_twice_or_fill_a_layer_are_not_proved() {
    let mut asked = two_cubes(40.0, 5);
    assert!(proved(&asked, &asked).is_ok());
    for (written, expected) in [
        (two_cubes(13.0, 5), "is not proved: "),
        (two_cubes(40.0, 4), "copy 5 of cube.stl twice"),
        (one_cube(), "1 placements instead of 2"),
    ] {
        let refused = proved(&asked, &written).unwrap_err();
        assert!(refused.contains(expected), "{refused}");
    }
    asked.machine.layer_cap = LayerAreaCap { layer_mm: 0.1, area_mm2: 150.0 };
    let refused = proved(&asked, &asked).unwrap_err();
    assert!(refused.contains("fills a layer beyond its cap"), "{refused}");
    asked.machine.layer_cap.area_mm2 = 250.0;
    assert!(proved(&asked, &asked).is_ok());
}

#[test]
fn a_fault_in_a_file_of_any_kind_is_found() {
    let faults: [WriteFault; 7] = [
        ("which was not asked for", |build| build.parts[0].part_number = "8".to_owned()),
        ("turned against its orientation rule", |build| build.placed[0].pose.rotation = DQuat::from_rotation_x(0.3)),
        ("mesh", |build| build.parts[0].mesh = Arc::new(sample_parts::cuboid(DVec3::new(10.0, 10.0, 10.001)))),
        ("out of the volume", |build| build.placed[0].pose.translation.x = 95.0),
        ("mm apart instead of 3 mm", |build| build.placed[1].pose.translation.x -= 28.5),
        ("copy 5 of cube.stl twice", |build| build.placed[1].copy = 4),
        ("1 placements instead of 2", |build| build.placed.truncate(1)),
    ];
    for delivery in DeliveryKind::ALL {
        let mut asked = two_cubes(40.0, 5);
        asked.machine.delivery = delivery;
        assert!(proved(&asked, &asked).is_ok(), "{delivery:?}");
        for (expected, change) in faults {
            let mut written = asked.clone();
            change(&mut written);
            // Where the layout itself is wrong, its file is what was asked for.
            let is_layout = expected.contains("volume") || expected.contains("apart");
            let refused = proved(if is_layout { &written } else { &asked }, &written).unwrap_err();
            assert!(refused.contains(expected), "{delivery:?}: {refused}");
        }
        // A file of which one copy stands elsewhere than it was nested.
        let mut moved = asked.clone();
        moved.placed[1].pose.translation.y += 0.01;
        assert_eq!(proved(&asked, &moved).is_err(), delivery.is_rounded(), "{delivery:?}");
    }
}

#[test]
fn a_layout_for_rounded_coordinates_keeps_what_rounding_may_take() {
    let cube = Arc::new(sample_parts::cuboid(DVec3::splat(10.0)));
    let item = || vec![nester::NestingItem::new("cube", cube.clone(), 2).with_clearance(4.0)];
    for delivery in DeliveryKind::ALL {
        let machine = MachineSpec { delivery, ..one_cube().machine };
        let instance = machine.create_instance(item()).unwrap();
        let spare_mm = instance.clearance_between_mm(0, 0) - 4.0;
        let is_spared = 1e-6 < spare_mm && spare_mm < 1e-3;
        assert_eq!(is_spared, delivery.is_rounded(), "{delivery:?}: {spare_mm}");
        assert_eq!(machine.build_volume().size_mm.x < 96.0, delivery.is_rounded());
        let shared = one_cube().machine;
        assert_eq!(machine.find_stricter_than(&shared, None).is_some(), delivery.is_rounded());
        assert_eq!(shared.find_stricter_than(&machine, None), None);
    }
}

/// Two copies of the cube, one above the other.
fn stacked(gap_mm: f64) -> SolvedBuild {
    let mut build = two_cubes(0.0, 5);
    build.placed[1].pose.translation.z += 10.0 + gap_mm;
    build
}

#[test]
fn copies_that_come_too_close_when_one_is_raised_or_closer_than_a_part_asks_are_not_proved() {
    let mut asked = stacked(5.0);
    asked.machine.clearance_z_extra_mm = 2.0;
    assert!(proved(&asked, &asked).is_ok());
    let refused = proved(&asked, &stacked(4.95)).unwrap_err();
    assert!(refused.contains("mm apart instead of 3 mm"), "{refused}");
    asked.machine.clearance_z_extra_mm = 0.0;
    assert!(proved(&asked, &stacked(3.0)).is_ok());
    asked.parts[0].clearance_mm = Some(5.0);
    assert!(proved(&asked, &asked).is_ok());
    let refused = proved(&asked, &stacked(4.95)).unwrap_err();
    assert!(refused.contains("mm apart instead of 5 mm"), "{refused}");
}

/// Two rings that hang in each other as the links of a chain, with more than the clearance between them; or one beside the other.
fn two_links(is_linked: bool) -> SolvedBuild {
    let mut build = two_cubes(0.0, 5);
    let ring = sample_parts::ring(40.0, 30.0, 4.0);
    let (center, outer_mm) = (ring.bounds().center(), 0.5 * ring.bounds().size().x);
    build.parts[0].mesh = Arc::new(ring);
    build.parts[0].orientation = OrientationLimits::new(OrientationRule::Free, &[], &[]);
    let at = |rotation: DQuat, place: DVec3| Pose::new(rotation, place - rotation * center);
    let apart_mm = if is_linked { 0.875 * outer_mm } else { 2.0 * outer_mm + 8.0 };
    build.placed[0].pose = at(DQuat::IDENTITY, DVec3::new(25.0, 50.0, 50.0));
    build.placed[1].pose =
        at(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2), DVec3::new(25.0 + apart_mm, 50.0, 50.0));
    build
}

#[test]
fn parts_that_are_locked_into_each_other_are_not_proved_where_the_machine_forbids_it() {
    let (mut linked, beside) = (two_links(true), two_links(false));
    assert!(proved(&beside, &beside).is_ok());
    let refused = proved(&linked, &linked).unwrap_err();
    assert!(refused.contains("is not proved: ") && !refused.contains("mm apart"), "{refused}");
    linked.machine.interlock = InterlockRule::Allow;
    assert!(proved(&linked, &linked).is_ok(), "they have their clearance");
}
