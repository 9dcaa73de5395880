//! Tests of the search when interlocking is forbidden: every result can be taken apart.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use solids::{Mesh, Pose};

use super::testing::{block, cells, coarsely_prepared, range};
use crate::{
    BuildVolume, InterlockRule, ItemPlacement, NestingConfig, NestingInstance, NestingItem, NestingSolution,
    OrientationRule, PlacedSolid, StopCondition, find_removal_order, nest,
    orientation::rotations::axis_rotations,
    prepare::prepared_instance::{PlacedItem, PreparedInstance},
    prove_placed_solids,
    separation::{
        disassembly::{
            KnownDisassembly, can_be_removed, items_blocking_disassembly, locked_pairs, plan_disassembly,
            removal_directions,
        },
        interlock_check::resolve_interlocks,
        overlap_depth_grid::OverlapDepthGrid,
        separation::{SeparationLimits, SeparationOutcome, separate_parts},
        working_layout::WorkingLayout,
    },
};

struct InterlockTestBudget(u64);

impl StopCondition for InterlockTestBudget {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        evaluations as f64 / self.0 as f64
    }
}

/// A square frame of `size` cells of 3 mm, one cell thick, lying flat.
fn frame(size: i32) -> Arc<Mesh> {
    let inner = 1..size - 1;
    cells(3.0, range([0, 0, 0], [size, size, 1]).filter(|c| !(inner.contains(&c[0]) && inner.contains(&c[1]))))
}

/// A rod along z with a plate at either end.
fn dumbbell() -> Arc<Mesh> {
    let head = |z| range([-1, -1, z], [2, 2, z + 1]);
    cells(3.0, range([0, 0, 0], [1, 1, 8]).chain(head(0)).chain(head(7)))
}

fn instance(size: DVec3, clearance_mm: f64, meshes: &[(Arc<Mesh>, u32)]) -> NestingInstance {
    let item = |(mesh, copies): &(Arc<Mesh>, u32)| NestingItem {
        name: "part".to_owned(),
        mesh: mesh.clone(),
        copies: *copies,
        orientation: OrientationRule::Free.into(),
        clearance_mm: None,
    };
    let volume = BuildVolume { size_mm: size };
    NestingInstance::new(volume, clearance_mm, meshes.iter().map(item).collect()).expect("makes sense")
}

fn bodies(instance: &NestingInstance, placements: &[ItemPlacement]) -> Vec<PlacedSolid> {
    let body = |p: &ItemPlacement| PlacedSolid {
        name: String::new(),
        mesh: instance.items()[p.item].mesh.clone(),
        pose: p.pose,
        clearance_mm: instance.clearance_mm(),
    };
    placements.iter().map(body).collect()
}

fn placed(item: usize, copy: u32, turn: DQuat, at: [f64; 3]) -> ItemPlacement {
    ItemPlacement { item, copy, pose: Pose::new(turn, DVec3::from_array(at)) }
}

/// Two frames linked like a chain, 5 mm and more inside the volume.
fn chain() -> (NestingInstance, Vec<ItemPlacement>) {
    let instance = instance(DVec3::splat(60.0), 1.0, &[(frame(7), 2), (block(DVec3::splat(5.0)), 1)]);
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let start = vec![placed(0, 0, DQuat::IDENTITY, [10.0, 10.0, 15.0]), placed(0, 1, upright, [20.0, 21.5, 5.0])];
    (instance, start)
}

fn run(
    instance: &NestingInstance,
    interlock: InterlockRule,
    start: &[ItemPlacement],
    evaluations: u64,
) -> NestingSolution {
    let config = NestingConfig { interlock, ..NestingConfig::default() };
    nest(instance, &config, start, &InterlockTestBudget(evaluations), &mut |found: &NestingSolution, _: u64| {
        if interlock == InterlockRule::Forbid {
            assert_eq!(find_removal_order(&bodies(instance, &found.placements)).locked, Vec::<usize>::new());
        }
    })
}

#[test]
fn ways_are_the_26_of_a_cube_with_up_first() {
    let directions = removal_directions();
    assert_eq!(directions[0], DVec3::Z);
    for (at, direction) in directions.iter().enumerate() {
        assert!((direction.length() - 1.0).abs() < 1e-12);
        assert!(directions[..at].iter().all(|other| other.distance(*direction) > 0.3), "{direction} is there twice");
    }
}

#[test]
fn a_layout_that_was_locked_is_repaired_where_that_is_forbidden() {
    let (instance, start) = chain();
    assert!(
        prove_placed_solids(&bodies(&instance, &start), DVec3::splat(60.0)).is_proved(),
        "the chain is a proved layout"
    );
    assert_eq!(find_removal_order(&bodies(&instance, &start)).locked, [0, 1]);
    let solution = run(&instance, InterlockRule::Forbid, &start, 3000);
    assert_eq!(solution.placements.len(), 3);
    assert!(prove_placed_solids(&bodies(&instance, &solution.placements), DVec3::splat(60.0)).is_proved());
}

#[test]
fn where_it_is_allowed_a_chain_may_stay_one() {
    let (instance, start) = chain();
    // No budget: the given layout stays as it is.
    let solution = run(&instance, InterlockRule::Allow, &start, 1);
    assert_eq!(solution.placements.len(), 3);
    assert_eq!(find_removal_order(&bodies(&instance, &solution.placements)).locked, [0, 1]);
}

#[test]
fn frames_and_dumbbells_come_apart_at_every_height_on_the_way() {
    let instance = instance(DVec3::new(45.0, 45.0, 200.0), 1.0, &[(frame(7), 6), (dumbbell(), 5), (frame(5), 4)]);
    let solution = run(&instance, InterlockRule::Forbid, &[], 25_000);
    assert!(solution.unplaced.is_empty());
    assert!(prove_placed_solids(&bodies(&instance, &solution.placements), instance.volume().size_mm).is_proved());
}

/// Two frames of 21 mm, one flat and one on edge, which must not be rotated, in a volume that holds both only as links
/// of a chain.
fn two_links() -> NestingInstance {
    let inner = |v: i32| (1..6).contains(&v);
    let flat = cells(3.0, range([0, 0, 0], [7, 7, 1]).filter(|c| !(inner(c[0]) && inner(c[1]))));
    let on_edge = cells(3.0, range([0, 0, 0], [7, 1, 7]).filter(|c| !(inner(c[0]) && inner(c[2]))));
    let item = |mesh| NestingItem {
        name: "link".to_owned(),
        mesh,
        copies: 1,
        orientation: OrientationRule::Fixed.into(),
        clearance_mm: None,
    };
    let volume = BuildVolume { size_mm: DVec3::new(32.0, 22.0, 22.0) };
    NestingInstance::new(volume, 1.0, vec![item(on_edge), item(flat)]).expect("makes sense")
}

#[test]
fn where_two_links_fit_only_as_a_chain_one_stays_out() {
    let instance = two_links();
    let start = [placed(0, 0, DQuat::IDENTITY, [10.5, 9.5, 0.5]), placed(1, 0, DQuat::IDENTITY, [0.2, 0.5, 8.0])];
    for (interlock, count) in [(InterlockRule::Forbid, 1), (InterlockRule::Warn, 2), (InterlockRule::Allow, 2)] {
        let solution = run(&instance, interlock, &start, 2000);
        assert_eq!(solution.placements.len(), count, "{interlock:?}");
        assert_eq!(find_removal_order(&bodies(&instance, &solution.placements)).locked.len(), [0, 2][count - 1]);
    }
}

fn pieces(task: &PreparedInstance, placements: &[ItemPlacement]) -> Vec<PlacedItem> {
    let piece = |p: &ItemPlacement| {
        let place = task.prepared_item(p.item).shape.center_at(&p.pose);
        task.place_item((p.item, p.copy), p.pose.rotation, place)
    };
    placements.iter().map(piece).collect()
}

#[test]
fn a_locked_pair_is_found_and_the_smaller_part_has_to_go() {
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let instance = instance(DVec3::splat(60.0), 1.0, &[(frame(7), 1), (frame(6), 1), (block(DVec3::splat(5.0)), 1)]);
    let placements = [
        placed(0, 0, DQuat::IDENTITY, [10.0, 10.0, 15.0]),
        placed(1, 0, upright, [20.0, 21.5, 7.0]),
        placed(2, 0, DQuat::IDENTITY, [45.0, 45.0, 5.0]),
    ];
    let task = coarsely_prepared(&instance);
    let pieces = pieces(&task, &placements);
    let found = plan_disassembly(&task, &pieces, &[0; 3], &mut KnownDisassembly::default());
    assert_eq!(found.locked, [0, 1]);
    assert_eq!(locked_pairs(&task, &pieces, &found.locked), [(0, 1)]);
    assert_eq!(items_blocking_disassembly(&task, &pieces), [1]);
    assert!(!can_be_removed(&task, &pieces[1], &pieces[..1]));
    assert!(can_be_removed(&task, &pieces[2], &pieces[..2]));
}

/// Three oblong frames around one center, as the rings of Borromeo: no two of them are linked, but all three are.
fn borromean_frames(task: &PreparedInstance) -> Vec<PlacedItem> {
    let onward = DQuat::from_mat3(&DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
    let rotations = [DQuat::IDENTITY, onward, onward.inverse()];
    let place = |(copy, rotation)| task.place_item((0, copy), rotation, DVec3::splat(30.0));
    (0..).zip(rotations).map(place).collect()
}

/// The task of [`borromean_frames`].
fn borromean_task() -> PreparedInstance {
    let (long, wide) = (1..8, 1..4);
    let oblong = cells(3.0, range([0, 0, 0], [9, 5, 1]).filter(|c| !(long.contains(&c[0]) && wide.contains(&c[1]))));
    let mut task = coarsely_prepared(&instance(DVec3::splat(60.0), 1.0, &[(oblong, 3)]));
    task.must_be_separable = true;
    task
}

/// The parts that are moved because the layout is locked.
fn parts_that_leave(layout: &mut WorkingLayout<'_>, pieces: &[PlacedItem]) -> Vec<usize> {
    let (began, mut grid) = (layout.poses.clone(), OverlapDepthGrid::new(layout));
    assert!(!resolve_interlocks(layout, pieces, &mut grid, &mut ChaCha8Rng::seed_from_u64(1)));
    (0..layout.part_count()).filter(|&part| layout.poses[part].center != began[part].center).collect()
}

#[test]
fn the_smallest_part_of_a_locked_group_does_not_go_back_to_its_place() {
    let task = borromean_task();
    let pieces = borromean_frames(&task);
    let found = plan_disassembly(&task, &pieces, &[0; 3], &mut KnownDisassembly::default());
    assert_eq!(found.locked, [0, 1, 2]);
    assert!(locked_pairs(&task, &pieces, &found.locked).is_empty());

    let mut layout = WorkingLayout::new(&task, &pieces, 60.0);
    let began = layout.poses.clone();
    assert!(layout.confirm_clear().is_some(), "the frames are clear of each other");
    let left = parts_that_leave(&mut layout, &pieces);
    let [part] = left[..] else { panic!("one part leaves: {left:?}") };
    layout.move_part(part, began[part]);
    let energy = layout.energy_at(part, &layout.proxies[part], false, f32::INFINITY);
    assert!(energy > 0.0, "its place among the others is none for it now");
}

#[test]
fn a_part_that_must_stay_is_not_the_one_that_leaves_a_locked_group() {
    let mut task = borromean_task();
    task.pinned = [(0, 0)].into();
    let pieces = borromean_frames(&task);
    let mut layout = WorkingLayout::new(&task, &pieces, 60.0);
    let left = parts_that_leave(&mut layout, &pieces);
    assert!(left == [1] || left == [2], "a part that can move leaves: {left:?}");
}

#[test]
fn hulls_kept_apart_do_not_make_the_proxies_doubted() {
    let (instance, start) = chain();
    let task = coarsely_prepared(&instance);
    let mut layout = WorkingLayout::new(&task, &pieces(&task, &start), 60.0);
    layout.keep_hulls_apart(0, 1);
    let reach_mm = layout.pair_constraint(0, 1).reach;
    assert!(layout.energy_at(0, &layout.proxies[0], false, f32::INFINITY) > 0.0, "their hulls overlap");
    assert!(layout.confirm_clear().is_some(), "the links are clear of each other");
    assert_eq!(layout.pair_constraint(0, 1).reach, reach_mm);
}

#[test]
fn a_locked_layout_is_not_tested_again_when_the_budget_is_used_up() {
    let mut task = borromean_task();
    task.pinned = (0..3).map(|copy| (0, copy)).collect();
    let mut layout = WorkingLayout::new(&task, &borromean_frames(&task), 60.0);
    let limits = SeparationLimits { idle_rounds: 40, failed_checks: 16, near_overlap: 1.0 };
    let mut asked = 0;
    let outcome = separate_parts(&mut layout, limits, &mut ChaCha8Rng::seed_from_u64(1), |_| {
        asked += 1;
        true
    });
    assert!(matches!(outcome, SeparationOutcome::Stuck(..)));
    assert_eq!(asked, 1, "times that the budget was asked");
}

#[test]
fn a_part_that_moves_is_tested_again() {
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let instance = instance(DVec3::splat(60.0), 1.0, &[(frame(7), 1), (frame(6), 1)]);
    let task = coarsely_prepared(&instance);
    let at = |x_mm: f64| {
        pieces(&task, &[placed(0, 0, DQuat::IDENTITY, [10.0, 10.0, 15.0]), placed(1, 0, upright, [x_mm, 21.5, 7.0])])
    };
    let plan =
        |x_mm: f64, moves: u32, known: &mut KnownDisassembly| plan_disassembly(&task, &at(x_mm), &[0, moves], known);
    let is_free = |x_mm: &f64| {
        let found = plan(*x_mm, 0, &mut KnownDisassembly::default());
        found.locked.is_empty() && found.sweeps > 0
    };
    let beside_mm = (20..60).map(f64::from).find(is_free).expect("a place near the other one");
    let mut known = KnownDisassembly::default();
    assert!(plan(beside_mm, 0, &mut known).locked.is_empty());
    assert_eq!(plan(20.0, 1, &mut known).locked, [0, 1]);
    assert_eq!(plan(20.0, 1, &mut known).locked, [0, 1]);
    assert!(plan(beside_mm, 2, &mut known).locked.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_search_finds_what_the_judge_finds(
        places in proptest::collection::vec((5.0..40.0f64, 5.0..40.0f64, 5.0..40.0f64, 0usize..4, 0usize..24), 4..12),
        number_moved in 0usize..12,
        shift in proptest::array::uniform3(-15.0..15.0f64),
    ) {
        let meshes = [frame(7), frame(5), dumbbell(), block(DVec3::new(4.0, 4.0, 20.0))];
        let instance = instance(DVec3::splat(100.0), 0.6, &meshes.map(|mesh| (mesh, 12)));
        let (mut placements, turns) = (Vec::new(), axis_rotations());
        for (number, (x, y, z, item, turn)) in (0..).zip(places) {
            placements.push(placed(item, number, turns[turn], [x, y, z]));
            let proof = prove_placed_solids(&bodies(&instance, &placements), DVec3::splat(1e4));
            if !proof.too_close.is_empty() || !proof.inside.is_empty() {
                placements.pop();
            }
        }
        let task = coarsely_prepared(&instance);
        let mut pieces = pieces(&task, &placements);
        let (mut move_counts, mut known) = (vec![0; pieces.len()], KnownDisassembly::default());
        let cold = plan_disassembly(&task, &pieces, &move_counts, &mut known);
        let removals = known.removals.clone();
        prop_assert_eq!(&cold.locked, &find_removal_order(&bodies(&instance, &placements)).locked);
        let warm = plan_disassembly(&task, &pieces, &move_counts, &mut known);
        prop_assert_eq!(&warm.locked, &cold.locked);
        prop_assert!(warm.sweeps <= cold.sweeps && (cold.sweeps == 0 || !warm.locked.is_empty() || warm.sweeps == 0));
        prop_assert_eq!(&known.removals, &removals);
        let moved = number_moved % pieces.len();
        let PlacedItem { item, copy, rotation, center, .. } = pieces[moved];
        pieces[moved] = task.place_item((item, copy), rotation, center + DVec3::from_array(shift));
        move_counts[moved] += 1;
        let after = plan_disassembly(&task, &pieces, &move_counts, &mut known);
        let anew = plan_disassembly(&task, &pieces, &move_counts, &mut KnownDisassembly::default());
        prop_assert_eq!(after.locked, anew.locked);
    }
}
