//! Tests of disassembly: bodies that are interlocked, and bodies that only look so.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use solids::{Mesh, Pose};

use super::{
    super::{LayoutProver, PlacedSolid},
    Disassembly, DisassemblyProver, FIRST_FALLING, find_removal_order, removal_directions,
};
use crate::tests::testing::{block, cells, hollow, range};

const NOBODY: [usize; 0] = [];
/// Edge of the cells that the solids below are made of, mm.
const CELL: f64 = 4.0;

fn body(mesh: &Arc<Mesh>, at: [f64; 3]) -> PlacedSolid {
    let pose = Pose::new(DQuat::IDENTITY, DVec3::from_array(at));
    PlacedSolid { name: "body".to_owned(), mesh: mesh.clone(), pose, clearance_mm: 1.0 }
}

fn turned(body: PlacedSolid, turn: DQuat) -> PlacedSolid {
    PlacedSolid { pose: Pose::new(turn, DVec3::ZERO).compose_with(&body.pose), ..body }
}

/// A square frame of `size` cells, one cell thick, lying flat.
fn frame(size: i32) -> Arc<Mesh> {
    let inner = 1..size - 1;
    cells(CELL, range([0, 0, 0], [size, size, 1]).filter(|c| !(inner.contains(&c[0]) && inner.contains(&c[1]))))
}

/// A cube of 7 cells, hollow, with a window of 3 x 3 cells in every wall.
fn cage() -> Arc<Mesh> {
    let window = |c: &[i32; 3]| (0..3).filter(|&axis| (2..5).contains(&c[axis])).count() >= 2;
    let inside = |c: &[i32; 3]| c.iter().all(|v| (1..6).contains(v));
    cells(CELL, range([0, 0, 0], [7, 7, 7]).filter(|c| !inside(c) && !window(c)))
}

/// A rod of 12 cells along z, optionally with a plate of 5 x 5 cells at either end.
fn rod(lower_head: bool, upper_head: bool) -> Arc<Mesh> {
    let head = |z| range([-2, -2, z], [3, 3, z + 1]);
    let lower = lower_head.then(|| head(0)).into_iter().flatten();
    let upper = upper_head.then(|| head(11)).into_iter().flatten();
    cells(CELL, range([0, 0, 0], [1, 1, 12]).chain(lower).chain(upper))
}

/// A pot of 7 x 7 x 6 cells whose mouth a flange narrows to 3 x 3 cells.
fn pot() -> Arc<Mesh> {
    let inside = |c: &[i32; 3]| (1..6).contains(&c[0]) && (1..6).contains(&c[1]) && (1..5).contains(&c[2]);
    let mouth = |c: &[i32; 3]| (2..5).contains(&c[0]) && (2..5).contains(&c[1]) && c[2] == 5;
    cells(CELL, range([0, 0, 0], [7, 7, 6]).filter(|c| !inside(c) && !mouth(c)))
}

fn locked(bodies: &[PlacedSolid]) -> Vec<usize> {
    // The result does not depend on the rotation of the whole group: the directions are those of a cube.
    let quarter = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let about: Vec<PlacedSolid> = bodies.iter().map(|b| turned(b.clone(), quarter)).collect();
    let found = find_removal_order(bodies).locked;
    assert_eq!(find_removal_order(&about).locked, found);
    found
}

#[test]
fn linked_rings_are_locked() {
    let ring = frame(7);
    let upright = turned(body(&ring, [0.0; 3]), DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    let through =
        PlacedSolid { pose: Pose { translation: DVec3::new(12.0, 14.0, -12.0), ..upright.pose }, ..upright.clone() };
    assert_eq!(locked(&[body(&ring, [0.0; 3]), through.clone()]), [0, 1]);
    let shifted = PlacedSolid { pose: Pose { translation: DVec3::new(40.0, 14.0, -12.0), ..through.pose }, ..through };
    assert_eq!(locked(&[body(&ring, [0.0; 3]), shifted]), NOBODY);
}

#[test]
fn a_ball_stays_in_a_cage_whose_windows_are_too_small() {
    let cage = body(&cage(), [0.0; 3]);
    let ball = |size: f64| body(&block(DVec3::splat(size)), [14.0 - 0.5 * size; 3]);
    assert_eq!(locked(&[cage.clone(), ball(14.0)]), [0, 1]);
    assert_eq!(locked(&[cage, ball(10.0)]), NOBODY);
}

#[test]
fn a_window_must_leave_the_drawing_gap() {
    let cage = body(&cage(), [0.0; 3]);
    let ball = |size: f64| body(&block(DVec3::splat(size)), [14.0 - 0.5 * size; 3]);
    // The windows are 12 mm wide; at 1 mm clearance half a millimetre is kept on both sides.
    assert_eq!(locked(&[cage.clone(), ball(10.999)]), NOBODY);
    assert_eq!(locked(&[cage, ball(11.001)]), [0, 1]);
}

#[test]
fn a_rod_leaves_two_rings_unless_heads_hold_it() {
    let ring = frame(5);
    let rings = [[-8.0, -8.0, 12.0], [-8.0, -8.0, 28.0]].map(|at| body(&ring, at));
    for (lower, upper) in [(false, false), (true, false), (false, true)] {
        let rod = body(&rod(lower, upper), [0.0; 3]);
        assert_eq!(locked(&[rings[0].clone(), rings[1].clone(), rod]), NOBODY, "{lower} {upper}");
    }
    let rod = body(&rod(true, true), [0.0; 3]);
    assert_eq!(locked(&[rings[0].clone(), rings[1].clone(), rod]), [0, 1, 2]);
}

#[test]
fn a_lid_under_a_flange_is_locked_and_locks_what_is_below_it() {
    let pot = body(&pot(), [0.0; 3]);
    let height_limit = body(&block(DVec3::new(18.0, 18.0, 2.0)), [5.0, 5.0, 16.0]);
    let below = body(&block(DVec3::new(8.0, 8.0, 8.0)), [10.0, 10.0, 5.0]);
    assert_eq!(locked(&[pot.clone(), below.clone()]), NOBODY);
    assert_eq!(locked(&[pot.clone(), height_limit.clone(), below]), [0, 1, 2]);
    assert_eq!(locked(&[pot, body(&block(DVec3::new(18.0, 18.0, 2.0)), [5.0, 5.0, 26.0])]), NOBODY);
}

#[test]
fn the_highest_body_that_comes_out_without_falling_is_removed_first() {
    // A bracket that is open to one side: a wall of `height` cells with an arm of six cells at both ends.
    let bracket = |wall: i32, height: i32| {
        let arm = |z| range([0, 0, z], [6, 3, z + 1]);
        cells(CELL, range([wall, 0, 0], [wall + 1, 3, height]).chain(arm(0)).chain(arm(height - 1)))
    };
    // An arm of each stands between the arms of the other: they part sideways only.
    let low = body(&bracket(0, 8), [0.0; 3]);
    let high = body(&bracket(5, 8), [3.0 * CELL, 0.0, 3.0 * CELL]);
    let beside = body(&block(DVec3::splat(4.0)), [0.0, 100.0, 0.0]);
    let order = find_removal_order(&[beside, low, high]).order;
    assert_eq!(order.iter().map(|(body, _)| *body).collect::<Vec<_>>(), [2, 1, 0], "{order:?}");
}

#[test]
fn what_is_in_a_sealed_cavity_is_locked() {
    let inner = body(&block(DVec3::splat(8.0)), [11.0; 3]);
    assert_eq!(locked(&[body(&hollow(30.0, 2.0), [0.0; 3]), inner]), [0, 1]);
}

#[test]
fn a_part_inside_another_ones_solid_is_locked() {
    let outer = body(&block(DVec3::splat(30.0)), [0.0; 3]);
    assert_eq!(locked(&[outer, body(&block(DVec3::splat(8.0)), [11.0; 3])]), [0, 1]);
}

#[test]
fn the_order_is_one_in_which_all_can_leave() {
    let (pot, plug) = (body(&pot(), [0.0; 3]), body(&block(DVec3::splat(10.0)), [9.0, 9.0, 6.0]));
    let above = body(&block(DVec3::new(28.0, 28.0, 4.0)), [0.0, 0.0, 26.0]);
    let found = find_removal_order(&[plug.clone(), pot.clone(), above]);
    assert_eq!(found.order.iter().map(|&(body, _)| body).collect::<Vec<_>>(), [2, 0, 1]);
    assert!(found.order.iter().all(|&(_, direction)| direction == DVec3::Z));
    assert_eq!(find_removal_order(&[]), Disassembly { order: Vec::new(), locked: Vec::new() });
}

/// Two hooks that hold each other along z and slip off each other sideways, the second higher than the first.
fn clasp() -> [PlacedSolid; 2] {
    let column = |x: i32, low: i32| range([x, 0, low], [x + 1, 1, low + 7]);
    let arms =
        |x: i32, low: i32| range([x, 0, low], [x + 4, 1, low + 1]).chain(range([x, 0, low + 6], [x + 4, 1, low + 7]));
    [column(0, 0).chain(arms(1, 0)), column(7, 3).chain(arms(3, 3))].map(|hook| body(&cells(CELL, hook), [0.0; 3]))
}

/// A bell, a bar that passes through two of its walls, and a block in the bell that keeps the bar's fin from leaving
/// through the wider window. All are placed `z` mm above the floor.
fn bell_with_bar_and_block(z: f64) -> [PlacedSolid; 3] {
    let inside = |c: &[i32; 3]| (1..6).contains(&c[0]) && (1..4).contains(&c[1]) && c[2] < 5;
    let windows = |c: &[i32; 3]| c[2] == 2 && (c[0] == 0 && (1..4).contains(&c[1]) || c[0] == 6 && c[1] == 1);
    let bell = cells(CELL, range([0, 0, 0], [7, 5, 6]).filter(|c| !inside(c) && !windows(c)));
    let bar = cells(2.0, range([-4, 0, 0], [18, 1, 1]).chain(range([8, 1, 0], [9, 4, 1])));
    let block = block(DVec3::new(4.0, 4.0, 12.0));
    [body(&bell, [0.0, 0.0, z]), body(&bar, [0.0, 5.0, z + 9.0]), body(&block, [8.0, 9.0, z + 3.0])]
}

#[test]
fn no_body_is_removed_downwards_while_a_direction_upwards_is_free() {
    let [low, high] = clasp();
    let plate = body(&block(DVec3::new(40.0, 40.0, 4.0)), [0.0, 0.0, 60.0]);
    let found = find_removal_order(&[low, plate, high]);
    assert_eq!(found.order.iter().map(|&(body, _)| body).collect::<Vec<_>>(), [1, 2, 0]);
    assert!(found.order.iter().all(|&(_, direction)| direction.z > 0.0), "{found:?}");
}

#[test]
fn a_part_under_a_bell_that_can_only_go_down_is_not_locked() {
    let bell = bell_with_bar_and_block(20.0);
    let found = find_removal_order(&bell);
    assert_eq!(found.locked, NOBODY);
    assert_eq!(found.order[0], (2, -DVec3::Z));
    assert!(found.order[1..].iter().all(|&(_, direction)| direction.z >= 0.0), "{found:?}");
}

#[test]
fn whoever_can_only_go_down_waits_for_lower_ones_that_need_not() {
    let [low, high] = clasp();
    let low = [low, high].map(|hook| PlacedSolid { pose: Pose { translation: DVec3::X * 60.0, ..hook.pose }, ..hook });
    let bodies: Vec<PlacedSolid> = bell_with_bar_and_block(50.0).into_iter().chain(low).collect();
    let found = find_removal_order(&bodies);
    assert_eq!(found.locked, NOBODY);
    assert_eq!(found.order.iter().position(|&(_, direction)| direction.z < 0.0), Some(2), "{found:?}");
    assert_eq!(found.order[2], (2, -DVec3::Z));
}

#[test]
fn ways_are_the_26_of_a_cube_from_up_to_down() {
    let directions = removal_directions();
    assert_eq!((directions.len(), directions[0]), (26, DVec3::Z));
    for (at, direction) in directions.iter().enumerate() {
        assert!((direction.length() - 1.0).abs() < 1e-12);
        assert!(directions[..at].iter().all(|other| other.distance(*direction) > 0.3), "{direction} is there twice");
        assert_eq!((direction.z > 0.0, direction.z < 0.0), (at < 9, at >= FIRST_FALLING), "{at}: {direction}");
    }
}

type Place = (f64, f64, f64, usize, usize);

fn place() -> impl Strategy<Value = Place> {
    (0.0..40.0f64, 0.0..40.0f64, 0.0..40.0f64, 0usize..4, 0usize..24)
}

/// Bodies at those of the poses that keep their clearance from all previous ones.
fn build(places: Vec<Place>) -> Vec<PlacedSolid> {
    let meshes = [frame(5), frame(4), rod(true, false), cells(CELL, range([0, 0, 0], [3, 1, 1]))];
    let turns = crate::orientation::rotations::axis_rotations();
    let mut bodies: Vec<PlacedSolid> = Vec::new();
    for (x, y, z, kind, turn) in places {
        let next = PlacedSolid { pose: Pose::new(turns[turn], DVec3::new(x, y, z)), ..body(&meshes[kind], [0.0; 3]) };
        bodies.push(next);
        let good = super::super::prove_placed_solids(&bodies, DVec3::splat(1e4));
        if !good.too_close.is_empty() || !good.inside.is_empty() {
            bodies.pop();
        }
    }
    bodies
}

/// The bodies that cannot be removed when always the first possible body is removed, with directions in any order and
/// without remembering results.
fn locked_along(bodies: &[PlacedSolid], directions: &[DVec3]) -> Vec<usize> {
    let layout = LayoutProver::new(bodies, 1);
    let prover = DisassemblyProver::new(&layout);
    let mut left: Vec<usize> = (0..bodies.len()).collect();
    while let Some(at) =
        (0..left.len()).find(|&at| directions.iter().any(|&direction| is_free(&prover, &left, left[at], direction)))
    {
        left.remove(at);
    }
    left
}

fn is_free(prover: &DisassemblyProver<'_>, left: &[usize], leaver: usize, direction: DVec3) -> bool {
    left.iter().all(|&other| other == leaver || !prover.blocks_removal(other, leaver, direction))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn who_is_locked_does_not_depend_on_the_order_of_the_ways(
        places in proptest::collection::vec(place(), 4..12),
        directions in Just(removal_directions()).prop_shuffle()
    ) {
        let bodies = build(places);
        prop_assert_eq!(find_removal_order(&bodies).locked, locked_along(&bodies, &directions));
    }

    #[test]
    fn every_step_is_free_and_goes_down_only_where_nobody_can_go_otherwise(
        places in proptest::collection::vec(place(), 4..12)
    ) {
        let bodies = build(places);
        let layout = LayoutProver::new(&bodies, 1);
        let prover = DisassemblyProver::new(&layout);
        let mut left: Vec<usize> = (0..bodies.len()).collect();
        for (leaver, direction) in find_removal_order(&bodies).order {
            prop_assert!(is_free(&prover, &left, leaver, direction));
            if direction.z < 0.0 {
                let others = removal_directions().into_iter().filter(|direction| direction.z >= 0.0);
                for other in others {
                    prop_assert!(!left.iter().any(|&body| is_free(&prover, &left, body, other)), "{}", other);
                }
            }
            left.retain(|&body| body != leaver);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Walks every removal of the order in small steps, past all later bodies.
    #[test]
    fn a_reported_order_can_be_carried_out(places in proptest::collection::vec(place(), 4..9)) {
        let bodies = build(places);
        let found = find_removal_order(&bodies);
        prop_assert_eq!(found.order.len() + found.locked.len(), bodies.len());
        let mut left = bodies.clone();
        let mut names: Vec<usize> = (0..bodies.len()).collect();
        for (leaver, direction) in found.order {
            let at = names.iter().position(|&n| n == leaver).unwrap();
            for step in 0..200 {
                let mut moved = left.clone();
                moved[at].pose.translation += direction * (0.5 * f64::from(step));
                moved.iter_mut().for_each(|b| b.clearance_mm = 0.4);
                let proof = super::super::prove_placed_solids(&moved, DVec3::splat(1e4));
                prop_assert!(!proof.too_close.iter().any(|p| p.first == at || p.second == at), "step {step}");
            }
            left.remove(at);
            names.remove(at);
        }
    }
}
