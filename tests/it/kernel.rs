//! The distance kernel in difficult cases: touching, coplanar, degenerate, nested and far-apart meshes compared with
//! the exact geometry, and real parts compared with another kernel.

use std::{f64::consts::FRAC_PI_2, sync::Arc};

use glam::{DQuat, DVec3, EulerRot};
use parry3d_f64::{math::Pose3, query, shape::TriMesh};
use proptest::prelude::*;
use sample_parts::random_part;
use solids::{Bounds, ClearanceTree, Mesh, Pose};

/// A box whose top is a triangle fan around one of its points. If the point is on an edge or corner, some triangles
/// have no area; if it is near one, they are needles.
fn brick(size: DVec3, middle: [f64; 2]) -> Arc<Mesh> {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * size;
    let quads = [[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    triangles.extend([[4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]);
    let top = DVec3::new(middle[0] * size.x, middle[1] * size.y, size.z);
    let mesh = Mesh::new((0..8).map(corner).chain([top]).collect(), triangles).unwrap();
    assert!(mesh.defects().is_closed());
    Arc::new(mesh)
}

/// The distance between the surfaces of two axis-parallel boxes; 0 where they meet.
fn box_distance(one: &Bounds, two: &Bounds) -> f64 {
    let gap = (two.min - one.max).max(one.min - two.max);
    if gap.max_element() >= 0.0 {
        return gap.max(DVec3::ZERO).length();
    }
    let wall = |outer: &Bounds, inner: &Bounds| (inner.min - outer.min).min(outer.max - inner.max).min_element();
    wall(one, two).max(wall(two, one)).max(0.0)
}

/// One of the 24 rotations that map axes onto axes.
fn right_turn([a, b, c]: [u8; 3]) -> DQuat {
    let angle = |quarters: u8| f64::from(quarters) * FRAC_PI_2;
    DQuat::from_euler(EulerRot::XYZ, angle(a), angle(b), angle(c))
}

fn rounded(bounds: Bounds) -> Bounds {
    Bounds { min: bounds.min.round(), max: bounds.max.round() }
}

fn other_kernel(mesh: &Mesh) -> TriMesh {
    TriMesh::new(mesh.vertices().to_vec(), mesh.triangles().to_vec()).unwrap()
}

fn other_distance(one: &Mesh, two: &Mesh, pose12: &Pose) -> f64 {
    let pose = Pose3::from_parts(pose12.translation, pose12.rotation);
    query::distance(&Pose3::IDENTITY, &other_kernel(one), &pose, &other_kernel(two)).unwrap().distance
}

/// A position along an edge: its ends, its middle, a random point, or very close to an end.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0..1.0f64, Just(1e-12), Just(1e-7), Just(1.0 - 1e-9)]
}

fn lattice_size() -> impl Strategy<Value = DVec3> {
    (1..9u8, 1..9u8, 1..9u8).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()))
}

fn any_turn() -> impl Strategy<Value = DQuat> {
    let angle = -3.2..3.2f64;
    (angle.clone(), angle.clone(), angle).prop_map(|(a, b, c)| DQuat::from_euler(EulerRot::XYZ, a, b, c))
}

fn any_direction() -> impl Strategy<Value = DVec3> {
    any_turn().prop_map(|turn| turn * DVec3::Z)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// On a lattice of whole millimetres nearly every pair has coplanar faces; many touch, some are nested.
    #[test]
    fn boxes_on_a_lattice_are_as_far_apart_as_their_corners_say(
        sizes in (lattice_size(), lattice_size()),
        middles in ([share(), share()], [share(), share()]),
        quarters in ([0..4u8, 0..4u8, 0..4u8], [0..4u8, 0..4u8, 0..4u8]),
        at in (-9..9i8, -9..9i8, -9..9i8),
        frame in any_turn(),
        cap in prop_oneof![Just(1.0), Just(2.0), Just(100.0), 0.1..9.0f64],
    ) {
        let (one, two) = (brick(sizes.0, middles.0), brick(sizes.1, middles.1));
        let pose1 = Pose::new(right_turn(quarters.0), DVec3::ZERO);
        let pose2 = Pose::new(right_turn(quarters.1), DVec3::new(at.0.into(), at.1.into(), at.2.into()));
        let truth = box_distance(&rounded(one.bounds_at(&pose1)), &rounded(two.bounds_at(&pose2)));
        // In a random frame, so that not only exact numbers are tested.
        let around = Pose::new(frame, DVec3::new(3.0, -1.0, 7.0));
        let (tree1, tree2) = (ClearanceTree::new(one), ClearanceTree::new(two));
        for pose12 in [pose1.relative_pose_of(&pose2), around.compose_with(&pose1).relative_pose_of(&around.compose_with(&pose2))] {
            let found = tree1.distance_capped_mm(&tree2, &pose12, cap);
            prop_assert!((found - truth.min(cap)).abs() < 1e-9, "{found} instead of {truth}, capped at {cap}");
            let back = tree2.distance_capped_mm(&tree1, &pose12.inverse(), cap);
            prop_assert!((back - truth.min(cap)).abs() < 1e-9, "{back} from the other side");
            if (truth - cap).abs() > 1e-9 {
                prop_assert_eq!(tree1.is_closer_than(&tree2, &pose12, cap), truth < cap);
            }
            prop_assert_eq!(tree1.is_closer_than(&tree2, &pose12, 0.0), truth == 0.0);
        }
    }

    /// A box strictly inside another one is found inside, despite triangles without an area; a box beside it is not.
    #[test]
    fn a_box_is_held_exactly_where_it_is_nested(
        sizes in (lattice_size(), lattice_size()),
        middles in ([share(), share()], [share(), share()]),
        at in (-9..9i8, -9..9i8, -9..9i8),
        frame in any_turn(),
    ) {
        let (one, two) = (brick(3.0 * sizes.0, middles.0), brick(sizes.1, middles.1));
        let place = DVec3::new(at.0.into(), at.1.into(), at.2.into());
        let (outer, inner) = (one.bounds(), Bounds { min: place, max: place + sizes.1 });
        let distance = box_distance(&outer, &inner);
        prop_assume!(distance > 0.0);
        let nested = outer.contains_bounds(&inner, 0.0);
        let pose12 = Pose::new(frame, DVec3::ZERO).relative_pose_of(&Pose::new(frame, frame * place));
        let (tree1, tree2) = (ClearanceTree::new(one), ClearanceTree::new(two));
        prop_assert_eq!(tree1.contains_part(&tree2, &pose12), nested);
        prop_assert!(!tree2.contains_part(&tree1, &pose12.inverse()) || Bounds::contains_bounds(&inner, &outer, 0.0));
        prop_assert!((tree1.distance_capped_mm(&tree2, &pose12, 50.0) - distance).abs() < 1e-9);
    }

    /// Parts that are metres or kilometres apart, in frames far from the parts.
    #[test]
    fn far_apart_parts_keep_their_distance(
        seeds in (0..40u64, 0..40u64), turn in any_turn(), direction in any_direction(), far in 1e3..1e6f64, away in -1e5..1e5f64
    ) {
        let (one, two) = (Arc::new(random_part(seeds.0)), Arc::new(random_part(seeds.1)));
        let (tree1, tree2) = (ClearanceTree::new(one), ClearanceTree::new(two));
        let frame = Pose::new(turn, DVec3::splat(away));
        let pose12 = frame.relative_pose_of(&Pose::new(turn, DVec3::splat(away) + far * direction));
        prop_assert_eq!(tree1.distance_capped_mm(&tree2, &pose12, 3.0), 3.0);
        prop_assert!(!tree1.is_closer_than(&tree2, &pose12, 3.0));
        prop_assert!(!tree1.contains_part(&tree2, &pose12) && !tree2.contains_part(&tree1, &pose12.inverse()));
        let found = tree1.distance_capped_mm(&tree2, &pose12, 1e9);
        prop_assert!((found - far).abs() < 200.0, "no part is larger than 100 mm: {found} instead of about {far}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn another_kernel_agrees_on_real_parts_beside_and_within_each_other(
        seeds in (0..400u64, 0..400u64),
        turn in any_turn(),
        direction in any_direction(),
        near in 0.0..1.2f64,
        cap in 0.5..10.0f64,
    ) {
        let (one, two) = (Arc::new(random_part(seeds.0)), Arc::new(random_part(seeds.1)));
        let (center1, center2) = (one.bounds().center(), turn * two.bounds().center());
        // From one part inside the other to just beside it.
        let reach = 0.5 * (one.bounds().size().length() + two.bounds().size().length());
        let pose12 = Pose::new(turn, center1 - center2 + near * reach * direction);
        let truth = other_distance(&one, &two, &pose12);
        let (tree1, tree2) = (ClearanceTree::new(one), ClearanceTree::new(two));
        let found = tree1.distance_capped_mm(&tree2, &pose12, cap);
        prop_assert!((found - truth.min(cap)).abs() < 1e-6, "{found}, the other kernel {truth}, capped at {cap}");
        let back = tree2.distance_capped_mm(&tree1, &pose12.inverse(), cap);
        prop_assert!((back - found).abs() < 1e-9, "{found}, from the other side {back}");
        if (truth - cap).abs() > 1e-6 {
            prop_assert_eq!(tree1.is_closer_than(&tree2, &pose12, cap), truth < cap);
        }
    }
}
