//! Tests of single steps of the search: how parts come inside the walls, and where else a part may go.

use glam::{DQuat, DVec3};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    BuildVolume, NestingInstance, NestingItem,
    separation::{SeparationLimits, SeparationOutcome, separate_parts},
    testing::{block, coarsely_prepared},
    working_layout::{CenterPose, WorkingLayout},
};

const ROOM: DVec3 = DVec3::new(50.0, 50.0, 100.0);
const PATIENCE: SeparationLimits = SeparationLimits { idle_rounds: 40, failed_checks: 16, near_overlap: 10.0 };

/// A block that fits between the walls along x, with this room to spare when it is not turned.
fn long_block(spare_mm: f64) -> NestingInstance {
    let mesh = block(DVec3::new(ROOM.x - spare_mm, 20.0, 20.0));
    NestingInstance::new(BuildVolume { size_mm: ROOM }, 1.0, vec![NestingItem::new("block", mesh, 1)]).expect("fits")
}

/// Separates the only part of an instance from a start at a rotation about z, without moving it elsewhere.
fn separate_turned(instance: &NestingInstance, angle: f64) -> SeparationOutcome {
    let mut prepared = coarsely_prepared(instance);
    prepared.components.relocation = false;
    let rotation = DQuat::from_rotation_z(angle);
    let piece = prepared.place_item((0, 0), rotation, 0.5 * ROOM);
    let mut layout = WorkingLayout::new(&prepared, &[piece], ROOM.z);
    // To the walls, as every part that is moved.
    layout.move_part(0, CenterPose { rotation, center: 0.5 * ROOM + DVec3::Z });
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    separate_parts(&mut layout, PATIENCE, &mut rng, |evaluations| evaluations > 2000)
}

#[test]
fn a_part_that_stands_out_of_a_wall_however_little_comes_inside() {
    let (spare_mm, width_mm) = (0.2, 20.0);
    for out_mm in [3e-6, 3e-5, 3e-4, 6e-4, 5e-3, 0.1] {
        // Its extent along x is length x cos + width x sin.
        let length_mm = ROOM.x - spare_mm;
        let angle =
            (0..20).fold(0.0_f64, |angle, _| ((spare_mm + out_mm + length_mm * (1.0 - angle.cos())) / width_mm).asin());
        let outcome = separate_turned(&long_block(spare_mm), angle);
        assert!(matches!(outcome, SeparationOutcome::Clear(_)), "{out_mm} mm out");
    }
}

#[test]
fn a_part_that_fits_exactly_between_two_walls_stays() {
    assert!(matches!(separate_turned(&long_block(0.0), 0.0), SeparationOutcome::Clear(_)));
}
