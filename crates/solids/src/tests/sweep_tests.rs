//! Tests of the exact sweep against many small steps.

use std::sync::Arc;

use glam::{DQuat, DVec3, EulerRot};
use proptest::prelude::*;

use crate::{
    ClearanceTree, Mesh, Pose,
    fixtures::{block, bucket, cuboid, hollow_box, star},
};

fn tree(mesh: &Arc<Mesh>) -> ClearanceTree {
    ClearanceTree::new(mesh.clone())
}

fn shift(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DQuat::IDENTITY, DVec3::new(x, y, z))
}

fn spiky(seed: f64, level: u32, size: DVec3) -> Arc<Mesh> {
    star(level, move |d| {
        let wave = (4.0 * d.x + seed).sin() * (3.0 * d.y - seed).cos() + (6.0 * d.z + 2.0 * seed).sin();
        (size * d).length() * (1.0 + 0.35 * wave)
    })
}

/// The least distance during the motion, measured every `step` mm over 60 mm.
fn stepped(one: &ClearanceTree, two: &ClearanceTree, pose12: &Pose, direction: DVec3, step: f64) -> f64 {
    let count = (60.0 / step) as usize;
    let at = |k: usize| Pose { translation: pose12.translation - direction * (k as f64 * step), ..*pose12 };
    (0..=count).map(|k| one.distance_capped_mm(two, &at(k), 5.0)).fold(f64::INFINITY, f64::min)
}

fn any_direction() -> impl Strategy<Value = DVec3> {
    let sign = (-1i32..=1).prop_map(f64::from);
    let straight = (sign.clone(), sign.clone(), sign).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    let free = (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    prop_oneof![straight, free].prop_filter("a direction", |d| d.length() > 0.2).prop_map(DVec3::normalize)
}

fn any_pose() -> impl Strategy<Value = Pose> {
    let angle = prop_oneof![-3.2..3.2f64, (-2i32..=2).prop_map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2)];
    let far = -16.0..16.0f64;
    ((angle.clone(), angle.clone(), angle), (far.clone(), far.clone(), far))
        .prop_map(|((a, b, c), t)| Pose::new(DQuat::from_euler(EulerRot::XYZ, a, b, c), DVec3::new(t.0, t.1, t.2)))
}

fn any_solid() -> impl Strategy<Value = Arc<Mesh>> {
    prop_oneof![
        (0.0..6.0f64, 1u32..3, 1.0..6.0f64).prop_map(|(s, level, x)| spiky(s, level, DVec3::new(x, 3.0, 5.0))),
        (4.0..12.0f64, 0.3..1.5f64).prop_map(|(size, wall)| bucket(size, wall)),
        (1.0..12.0f64, 1.0..12.0f64, 0.5..6.0f64).prop_map(|(x, y, z)| block(x, y, z)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_sweep_finds_what_small_steps_find(
        mesh1 in any_solid(), mesh2 in any_solid(), pose12 in any_pose(), direction in any_direction(), gap in 0.01..1.5f64
    ) {
        const STEP: f64 = 0.05;
        let (one, two) = (tree(&mesh1), tree(&mesh2));
        prop_assume!(one.distance_capped_mm(&two, &pose12, gap) >= gap);
        prop_assume!(!one.contains_part(&two, &pose12) && !two.contains_part(&one, &pose12.inverse()));
        let least = stepped(&one, &two, &pose12, direction, STEP);
        let free = one.is_free_along(&two, &pose12, direction, gap);
        prop_assert_eq!(two.is_free_along(&one, &pose12.inverse(), -(pose12.rotation.conjugate() * direction), gap), free);
        if free {
            prop_assert!(least >= gap - 1e-9, "free, but {least} on the way");
        } else {
            prop_assert!(least < gap + 0.5 * STEP, "barred, but {least} on the way");
        }
    }
}

const AXES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

#[test]
fn what_stands_in_a_bucket_leaves_by_its_mouth_only() {
    let (bucket, cube) = (tree(&bucket(20.0, 1.0)), tree(&cuboid(DVec3::splat(5.0), DVec3::splat(10.0))));
    for direction in AXES {
        assert_eq!(cube.is_free_along(&bucket, &Pose::IDENTITY, direction, 0.5), direction == DVec3::Z, "{direction}");
        assert_eq!(
            bucket.is_free_along(&cube, &Pose::IDENTITY, direction, 0.5),
            direction == DVec3::NEG_Z,
            "{direction}"
        );
    }
    let tilted = DVec3::new(0.2, 0.0, 1.0);
    assert!(cube.is_free_along(&bucket, &Pose::IDENTITY, tilted, 0.5));
    let wide = DVec3::new(1.0, 0.0, 1.0);
    assert!(!cube.is_free_along(&bucket, &Pose::IDENTITY, wide, 0.5));
}

#[test]
fn nothing_leaves_a_sealed_cavity() {
    let (safe, cube) = (tree(&hollow_box(30.0, 2.0)), tree(&cuboid(DVec3::splat(12.0), DVec3::splat(18.0))));
    for direction in AXES {
        assert!(!cube.is_free_along(&safe, &Pose::IDENTITY, direction, 0.1), "{direction}");
        assert!(!safe.is_free_along(&cube, &Pose::IDENTITY, direction, 0.1), "{direction}");
    }
}

#[test]
fn the_gap_decides_between_two_walls() {
    let (wall, cube) = (tree(&block(10.0, 1.0, 10.0)), tree(&block(2.0, 2.0, 2.0)));
    // The cube stands beside the wall's plane and slides past its end.
    let pose = shift(-20.0, 1.5, 4.0);
    for (gap, free) in [(0.4, true), (0.499_999, true), (0.500_001, false), (0.7, false)] {
        assert_eq!(wall.is_free_along(&cube, &pose, DVec3::NEG_X, gap), free, "{gap}");
        assert!(wall.is_free_along(&cube, &pose, DVec3::X, gap), "away from it");
    }
}

#[test]
fn sliding_along_a_face_is_free_at_the_distance_that_there_is() {
    let (slab, cube) = (tree(&block(50.0, 50.0, 2.0)), tree(&block(3.0, 3.0, 3.0)));
    let pose = shift(20.0, 20.0, 2.0001);
    for direction in AXES {
        assert_eq!(
            cube.is_free_along(&slab, &pose.inverse(), direction, 5e-5),
            direction != DVec3::NEG_Z,
            "{direction}"
        );
    }
}

#[test]
fn an_open_surface_bars_the_way_from_both_sides() {
    let full = block(10.0, 10.0, 0.5);
    let open: Vec<[u32; 3]> = full.triangles().iter().copied().skip(2).collect();
    let open = Arc::new(Mesh::new(full.vertices().to_vec(), open).expect("holes are no error"));
    assert!(!open.defects().is_closed());
    let (open, cube) = (tree(&open), tree(&block(2.0, 2.0, 2.0)));
    for (height, direction) in [(4.0, DVec3::NEG_Z), (-6.0, DVec3::Z)] {
        assert!(!cube.is_free_along(&open, &shift(4.0, 4.0, height).inverse(), direction, 0.1), "{direction}");
        assert!(cube.is_free_along(&open, &shift(4.0, 4.0, height).inverse(), -direction, 0.1), "{direction}");
    }
}
