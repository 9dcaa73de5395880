//! Tests of the independent proof.

use std::f64::consts::FRAC_PI_2;

use proptest::prelude::*;
use sample_parts::fixtures::{block, bucket, hollow_box, star};
use solids::Mesh;

use super::*;

fn body(mesh: &Arc<Mesh>, x: f64, y: f64, z: f64) -> PlacedSolid {
    PlacedSolid {
        name: "part".into(),
        mesh: mesh.clone(),
        pose: Pose::new(DQuat::IDENTITY, DVec3::new(x, y, z)),
        clearance_mm: 3.0,
    }
}

const ROOM: DVec3 = DVec3::splat(100.0);

#[test]
fn a_clean_layout_is_proved_with_its_least_distance() {
    let brick = block(10.0, 10.0, 10.0);
    let proof = prove_placed_solids(
        &[body(&brick, 0.0, 0.0, 0.0), body(&brick, 13.0, 0.0, 0.0), body(&brick, 0.0, 0.0, 14.0)],
        ROOM,
    );
    assert!(proof.is_proved(), "{proof:?}");
    assert!((proof.clearance_proved_mm.unwrap() - 3.0).abs() < 1e-12);
    assert!((proof.height_mm - 24.0).abs() < 1e-12);
}

#[test]
fn nothing_near_means_no_distance() {
    let brick = block(10.0, 10.0, 10.0);
    assert_eq!(prove_placed_solids(&[], ROOM).clearance_proved_mm, None);
    assert_eq!(prove_placed_solids(&[body(&brick, 0.0, 0.0, 0.0)], ROOM).clearance_proved_mm, None);
    let apart = prove_placed_solids(&[body(&brick, 0.0, 0.0, 0.0), body(&brick, 17.0, 0.0, 0.0)], ROOM);
    assert!(apart.is_proved() && apart.clearance_proved_mm.is_none());
    let nearer = prove_placed_solids(&[body(&brick, 0.0, 0.0, 0.0), body(&brick, 16.5, 0.0, 0.0)], ROOM);
    assert!((nearer.clearance_proved_mm.unwrap() - 6.5).abs() < 1e-12);
}

#[test]
fn a_pair_that_is_too_close_is_named_with_its_distance() {
    let brick = block(10.0, 10.0, 10.0);
    let bodies = [body(&brick, 0.0, 0.0, 0.0), body(&brick, 50.0, 0.0, 0.0), body(&brick, 0.0, 12.5, 0.0)];
    let proof = prove_placed_solids(&bodies, ROOM);
    let [pair] = proof.too_close[..] else { panic!("{proof:?}") };
    assert_eq!((pair.first, pair.second, pair.wanted_mm), (0, 2, 3.0));
    assert!((pair.distance_mm - 2.5).abs() < 1e-12 && !proof.is_proved());
}

#[test]
fn the_tolerance_is_a_millionth_and_no_more() {
    let brick = block(10.0, 10.0, 10.0);
    let at = |x: f64| prove_placed_solids(&[body(&brick, 0.0, 0.0, 0.0), body(&brick, x, 0.0, 0.0)], ROOM).is_proved();
    assert!(at(13.0 - 5e-7) && !at(13.0 - 2e-6));
    let wall = |x: f64| prove_placed_solids(&[body(&brick, x, 0.0, 0.0)], ROOM).is_proved();
    assert!(wall(-5e-7) && !wall(-2e-6) && wall(90.0 + 5e-7) && !wall(90.0 + 2e-6));
}

#[test]
fn the_clearance_holds_at_every_raise_up_to_the_extra_and_no_further() {
    let brick = block(10.0, 10.0, 10.0);
    let above = |z: f64, extra_mm: f64| {
        let lower = PlacedSolid {
            pose: Pose::new(DQuat::from_rotation_x(FRAC_PI_2), DVec3::Y * 10.0),
            ..body(&brick, 0.0, 0.0, 0.0)
        };
        prove_with_z_extra(&[lower, body(&brick, 0.0, 0.0, z)], ROOM, extra_mm)
    };
    // 3 mm are wanted, and 2 mm more for a raise.
    assert!(above(15.0, 2.0).is_proved() && above(15.0 - 5e-7, 2.0).is_proved());
    let close = above(15.0 - 2e-6, 2.0);
    let [pair] = close.too_close[..] else { panic!("{close:?}") };
    assert!((pair.distance_mm - 3.0).abs() < 1e-5 && pair.wanted_mm == 3.0);
    assert!(above(13.0, 0.0).is_proved() && !above(14.95, 2.0).is_proved());
    // So far apart that they would not be neighbours without the raise.
    assert!(above(33.0, 20.0).is_proved() && !above(32.5, 20.0).is_proved());
}

#[test]
fn a_keep_out_box_is_kept_free_within_the_tolerance() {
    let brick = block(10.0, 10.0, 10.0);
    let zone = Bounds { min: DVec3::splat(20.0), max: DVec3::splat(40.0) };
    let at = |x: f64| prove_with_keep_out(&[body(&brick, x, 25.0, 25.0)], ROOM, 0.0, &[zone]).intruding;
    assert_eq!((at(10.0), at(10.0 + 5e-7), at(40.0)), (vec![], vec![], vec![]));
    assert_eq!((at(10.0 + 2e-6), at(10.05), at(40.0 - 2e-6)), (vec![(0, 0)], vec![(0, 0)], vec![(0, 0)]));
}

#[test]
fn the_greater_clearance_of_two_bodies_holds() {
    let brick = block(10.0, 10.0, 10.0);
    let wide = PlacedSolid { clearance_mm: 5.0, ..body(&brick, 14.0, 0.0, 0.0) };
    let proof = prove_placed_solids(&[body(&brick, 0.0, 0.0, 0.0), wide], ROOM);
    assert_eq!(proof.too_close.len(), 1);
    assert_eq!(proof.too_close[0].wanted_mm, 5.0);
}

#[test]
fn surfaces_that_meet_are_refused_at_clearance_zero_too() {
    let brick = block(10.0, 10.0, 10.0);
    let with = |x: f64| {
        let bodies = [0.0, x].map(|x| PlacedSolid { clearance_mm: 0.0, ..body(&brick, x, 0.0, 0.0) });
        prove_placed_solids(&bodies, ROOM)
    };
    assert!(!with(9.0).is_proved() && !with(10.0).is_proved() && !with(0.0).is_proved());
    let near = with(10.001);
    assert!(near.is_proved() && (near.clearance_proved_mm.unwrap() - 0.001).abs() < 1e-9);
}

#[test]
fn what_stands_out_is_reported_by_how_much() {
    let brick = block(10.0, 10.0, 10.0);
    let proof = prove_placed_solids(&[body(&brick, -2.0, 0.0, 91.5), body(&brick, 50.0, 50.0, 50.0)], ROOM);
    let [(0, excess)] = proof.outside[..] else { panic!("{proof:?}") };
    assert!((excess - 2.0).abs() < 1e-12);
}

#[test]
fn a_pose_of_no_numbers_is_outside() {
    let brick = block(10.0, 10.0, 10.0);
    let lost = PlacedSolid {
        pose: Pose { translation: DVec3::splat(f64::NAN), ..Pose::IDENTITY },
        ..body(&brick, 0.0, 0.0, 0.0)
    };
    let proof = prove_placed_solids(&[lost, body(&brick, 0.0, 0.0, 0.0)], ROOM);
    assert!(proof.outside.iter().any(|&(body, excess)| body == 0 && excess.is_infinite()), "{proof:?}");
}

#[test]
fn a_body_inside_a_solid_or_a_sealed_cavity_is_reported_and_one_in_a_bucket_is_not() {
    let small = block(2.0, 2.0, 2.0);
    let inside = |outer: Arc<Mesh>, flip: bool| {
        let mut bodies = vec![body(&outer, 0.0, 0.0, 0.0), body(&small, 14.0, 14.0, 14.0)];
        if flip {
            bodies.reverse();
        }
        prove_placed_solids(&bodies, ROOM)
    };
    for flip in [false, true] {
        let found = if flip { (1, 0) } else { (0, 1) };
        assert_eq!(inside(block(30.0, 30.0, 30.0), flip).inside, [found]);
        assert_eq!(inside(hollow_box(30.0, 4.0), flip).inside, [found]);
        assert!(inside(bucket(30.0, 4.0), flip).is_proved());
    }
}

#[test]
fn a_rotation_obeys_its_rule_or_not() {
    let of = |rotation: DQuat| Pose::new(rotation, DVec3::ZERO);
    let (quarter, tilt) = (DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_x(1e-4));
    let spin = DQuat::from_rotation_z(1.234);
    let obeyed = |pose: &Pose| {
        use OrientationRule::{Axis, Fixed, Free, Upright};
        [Free, Upright, Axis, Fixed].map(|rule| obeys_orientation(&rule.into(), pose))
    };
    assert_eq!(obeyed(&of(DQuat::IDENTITY)), [true; 4]);
    assert_eq!(obeyed(&of(-DQuat::IDENTITY)), [true; 4], "a quaternion and its opposite are one rotation");
    assert_eq!(obeyed(&of(spin)), [true, true, false, false]);
    assert_eq!(obeyed(&of(quarter)), [true, false, true, false]);
    assert_eq!(obeyed(&of(tilt)), [true, false, false, false]);
    assert_eq!(obeyed(&of(DQuat::from_rotation_x(5e-7))), [true; 4], "within the tolerance");
    assert_eq!(obeyed(&of(DQuat::from_rotation_x(std::f64::consts::PI))), [true, false, true, false], "upside down");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_sweep_forgets_no_pair(places in proptest::collection::vec(proptest::array::uniform3(0.0..80.0f64), 2..20)) {
        let ball = star(1, |_| 5.0);
        let bodies: Vec<PlacedSolid> = places.iter().map(|p| body(&ball, 10.0 + p[0], 10.0 + p[1], 10.0 + p[2])).collect();
        let proof = prove_placed_solids(&bodies, ROOM);
        let tree = ClearanceTree::new(ball);
        let mut pairs = Vec::new();
        let mut least = f64::INFINITY;
        for i in 0..bodies.len() {
            for j in i + 1..bodies.len() {
                let distance = tree.distance_capped_mm(&tree, &bodies[i].pose.relative_pose_of(&bodies[j].pose), 1e3);
                least = least.min(distance);
                if distance < 3.0 {
                    pairs.push((i, j));
                }
            }
        }
        let found: Vec<(usize, usize)> = proof.too_close.iter().map(|p| (p.first, p.second)).collect();
        prop_assert_eq!(found, pairs);
        match proof.clearance_proved_mm {
            Some(proved) => prop_assert!((proved - least).abs() < 1e-9),
            None => prop_assert!(least >= 7.0),
        }
    }
}
