//! Tests of single steps of the search: how parts come inside the walls, and when a layout is confirmed.

use std::{
    f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4},
    sync::Arc,
};

use glam::{DQuat, DVec3};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use solids::Mesh;

use super::testing::{block, coarsely_prepared};
use crate::{
    BuildVolume, NestingInstance, NestingItem,
    separation::{
        separation::{SeparationLimits, SeparationOutcome, separate_parts},
        working_layout::{CenterPose, WorkingLayout},
    },
};

const ROOM: DVec3 = DVec3::new(50.0, 50.0, 100.0);
const PATIENCE: SeparationLimits = SeparationLimits { idle_rounds: 40, failed_checks: 16, near_overlap: 10.0 };

/// One part in the room.
fn alone(mesh: Arc<Mesh>) -> NestingInstance {
    NestingInstance::new(BuildVolume { size_mm: ROOM }, 1.0, vec![NestingItem::new("part", mesh, 1)]).expect("fits")
}

/// Separates the only part of an instance from a start at a rotation about z, without moving it elsewhere. Returns where
/// it began, too.
fn separate_turned(instance: &NestingInstance, angle: f64) -> (CenterPose, SeparationOutcome) {
    let mut prepared = coarsely_prepared(instance);
    prepared.components.relocation = false;
    let rotation = DQuat::from_rotation_z(angle);
    let piece = prepared.place_item((0, 0), rotation, 0.5 * ROOM);
    let mut layout = WorkingLayout::new(&prepared, &[piece], ROOM.z);
    // To the walls, as every part that is moved.
    layout.move_part(0, CenterPose { rotation, center: 0.5 * ROOM + DVec3::Z });
    let (begun, mut rng) = (layout.poses[0], ChaCha8Rng::seed_from_u64(1));
    (begun, separate_parts(&mut layout, PATIENCE, &mut rng, |evaluations| evaluations > 2000))
}

/// The angle at which a block stands out of the room along x by `out_mm`: its extent is length x cos + width x sin.
fn angle_of(length_mm: f64, width_mm: f64, out_mm: f64) -> f64 {
    let extent_mm = ROOM.x + out_mm;
    (0..20).fold(0.0_f64, |angle, _| ((extent_mm - length_mm * angle.cos()) / width_mm).asin())
}

#[test]
fn a_part_that_stands_out_of_a_wall_however_little_comes_inside() {
    for (spare_mm, width_mm) in [(0.2, 20.0), (0.005, 20.0), (0.2, ROOM.y - 0.01)] {
        let length_mm = ROOM.x - spare_mm;
        let instance = alone(block(DVec3::new(length_mm, width_mm, 20.0)));
        for out_mm in [3e-6, 3e-5, 3e-4, 6e-4, 5e-3, 0.1] {
            let (_, outcome) = separate_turned(&instance, angle_of(length_mm, width_mm, out_mm));
            assert!(matches!(outcome, SeparationOutcome::Clear(_)), "{length_mm} x {width_mm}: {out_mm} mm out");
        }
    }
}

#[test]
fn a_part_that_fits_exactly_between_two_walls_stays() {
    let (begun, outcome) = separate_turned(&alone(block(DVec3::new(ROOM.x, 20.0, 20.0))), 0.0);
    let SeparationOutcome::Clear(pieces) = outcome else { panic!("it fits") };
    assert_eq!((pieces[0].rotation, pieces[0].center), (begun.rotation, begun.center));
}

#[test]
fn an_overlap_of_proxies_that_is_real_refuses_a_layout_without_a_test_of_other_pairs() {
    let volume = BuildVolume { size_mm: ROOM };
    let instance = NestingInstance::new(volume, 1.0, vec![NestingItem::new("part", block(DVec3::splat(10.0)), 4)]);
    let prepared = coarsely_prepared(&instance.expect("fits"));
    // Cubes with their edges towards the walls, side by side: the first two overlap by 2 mm. The others, which are not near
    // these, have 1.5 mm between them, and bounds that overlap.
    let turned = DQuat::from_rotation_z(FRAC_PI_4);
    let beside = |center: DVec3, gap_mm: f64| center + (10.0 + gap_mm) * FRAC_1_SQRT_2 * DVec3::new(1.0, 1.0, 0.0);
    let (low, high) = (DVec3::splat(10.0), DVec3::new(30.0, 30.0, 80.0));
    let centers = [low, beside(low, -2.0), high, beside(high, 1.5)];
    let pieces: Vec<_> =
        centers.iter().zip(0..).map(|(&center, copy)| prepared.place_item((0, copy), turned, center)).collect();
    let mut layout = WorkingLayout::new(&prepared, &pieces, ROOM.z);
    assert!(layout.confirm_clear().is_none());
    assert_eq!(layout.evaluations, 1, "the pair that overlaps is tested, no other one");
    layout.move_part(1, CenterPose { rotation: turned, center: beside(low, 1.5) });
    assert!(layout.confirm_clear().is_some());
    assert_eq!(layout.evaluations, 3, "both pairs are tested");
}
