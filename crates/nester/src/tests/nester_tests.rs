//! Tests of the entry point: every layout is proved, every copy is accounted for, the same seed gives the same build.

use std::{collections::BTreeSet, sync::Arc};

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use solids::{Mesh, Pose};

use super::testing::{block, each_method, hollow, tetrahedron};
use crate::{
    BuildVolume, ItemPlacement, LayerAreaCap, LayerAreas, NestingConfig, NestingInstance, NestingItem, NestingSolution,
    OrientationLimits, OrientationRule, PlacedSolid, SearchBudget, StopCondition, TiltLimit, lower_bound_mm, nest,
    obeys_orientation, prove_with_keep_out,
};

/// A budget of evaluations without a clock: tests do not depend on the machine.
pub(super) struct NesterTestBudget(pub(crate) u64);

impl StopCondition for NesterTestBudget {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        evaluations as f64 / self.0 as f64
    }
}

pub(crate) fn item(mesh: Arc<Mesh>, copies: u32, orientation: impl Into<OrientationLimits>) -> NestingItem {
    NestingItem { name: "part".to_owned(), mesh, copies, orientation: orientation.into(), clearance_mm: None }
}

pub(crate) fn asked(size: DVec3, clearance_mm: f64, items: Vec<NestingItem>) -> NestingInstance {
    NestingInstance::new(BuildVolume { size_mm: size }, clearance_mm, items).expect("makes sense")
}

pub(crate) fn nested(
    instance: &NestingInstance,
    config: &NestingConfig,
    start: &[ItemPlacement],
    evaluations: u64,
) -> NestingSolution {
    nest(instance, config, start, &NesterTestBudget(evaluations), &mut |_: &NestingSolution, _: u64| {})
}

/// Checks that the independent proof passes, that rules hold, and that every copy is either placed or unplaced, once.
pub(crate) fn assert_good(instance: &NestingInstance, solution: &NestingSolution) {
    let bodies: Vec<PlacedSolid> = (solution.placements.iter())
        .map(|p| PlacedSolid {
            name: format!("{} #{}", p.item, p.copy),
            mesh: instance.items()[p.item].mesh.clone(),
            pose: p.pose,
            clearance_mm: instance.clearance_between_mm(p.item, p.item),
        })
        .collect();
    let (room, extra_mm) = (instance.volume().size_mm, instance.clearance_z_extra_mm());
    let proof = prove_with_keep_out(&bodies, room, extra_mm, &instance.keep_out());
    assert!(proof.is_proved(), "{proof:?}");
    assert!((proof.height_mm - solution.height_mm).abs() < 1e-6);
    let areas = LayerAreas::from_meshes(bodies.iter().map(|b| (&*b.mesh, b.pose)), instance.layer_cap());
    assert!(areas.keeps_cap(), "{areas:?}");
    for p in &solution.placements {
        assert!(obeys_orientation(&instance.items()[p.item].orientation, &p.pose), "{p:?}");
    }
    let all_copies: Vec<(usize, u32)> =
        solution.placements.iter().map(|p| (p.item, p.copy)).chain(solution.unplaced.iter().copied()).collect();
    let once: BTreeSet<(usize, u32)> = all_copies.iter().copied().collect();
    assert_eq!(once.len(), all_copies.len(), "a copy is told twice");
    let all: BTreeSet<(usize, u32)> =
        instance.items().iter().enumerate().flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c))).collect();
    assert_eq!(once, all);
}

#[test]
fn a_part_too_large_is_unplaced_and_the_rest_goes_on() {
    let items = vec![
        item(block(DVec3::new(90.0, 90.0, 90.0)), 1, OrientationRule::Free),
        item(block(DVec3::new(10.0, 20.0, 5.0)), 6, OrientationRule::Free),
    ];
    let instance = asked(DVec3::splat(50.0), 1.0, items);
    let solution = nested(&instance, &NestingConfig::default(), &[], 3000);
    assert_good(&instance, &solution);
    assert_eq!(solution.unplaced, vec![(0, 0)]);
}

#[test]
fn where_not_all_fit_earlier_items_come_first() {
    let cube = block(DVec3::splat(20.0));
    let items = (0..4).map(|_| item(cube.clone(), 3, OrientationRule::Free)).collect();
    let instance = asked(DVec3::new(45.0, 45.0, 45.0), 2.0, items);
    let solution = nested(&instance, &NestingConfig::default(), &[], 3000);
    assert_good(&instance, &solution);
    assert_eq!(solution.unplaced, vec![(2, 2), (3, 0), (3, 1), (3, 2)]);
}

#[test]
fn the_same_seed_and_evaluations_give_the_same_build() {
    let items = vec![
        item(block(DVec3::new(12.0, 30.0, 6.0)), 5, OrientationRule::Free),
        item(tetrahedron([DVec3::ZERO, DVec3::X * 25.0, DVec3::Y * 20.0, DVec3::Z * 15.0]), 6, OrientationRule::Free),
    ];
    let instance = asked(DVec3::new(50.0, 50.0, 80.0), 1.5, items);
    for threads in [1, 2] {
        let config = NestingConfig { threads, seed: 9, ..NestingConfig::default() };
        let first = nested(&instance, &config, &[], 4000);
        assert_good(&instance, &first);
        assert_eq!(first, nested(&instance, &config, &[], 4000), "{threads} threads");
    }
}

#[test]
fn lanes_give_the_same_build_on_any_number_of_threads_and_one_lane_gives_another() {
    let items = vec![
        item(block(DVec3::new(12.0, 30.0, 6.0)), 3, OrientationRule::Free),
        item(tetrahedron([DVec3::ZERO, DVec3::X * 25.0, DVec3::Y * 20.0, DVec3::Z * 15.0]), 5, OrientationRule::Free),
    ];
    let instance = asked(DVec3::new(40.0, 40.0, 80.0), 1.5, items);
    let build = |threads: usize, lanes: usize| {
        nested(&instance, &NestingConfig { threads, lanes, seed: 9, ..NestingConfig::default() }, &[], 24_000)
    };
    let alone = build(1, 3);
    assert_good(&instance, &alone);
    for threads in [2, 3, 5] {
        assert_eq!(build(threads, 3), alone, "{threads} threads");
    }
    assert_eq!(build(3, 0), alone, "as many lanes as threads");
    assert_ne!(build(1, 1).placements, alone.placements);
}

#[test]
fn a_search_ends_in_every_lane_where_no_lower_layout_exists() {
    let items = vec![item(block(DVec3::new(30.0, 20.0, 8.0)), 2, OrientationRule::Free)];
    let instance = asked(DVec3::new(50.0, 50.0, 80.0), 1.5, items);
    let build = |threads: usize, lanes: usize| {
        nested(&instance, &NestingConfig { threads, lanes, ..NestingConfig::default() }, &[], 1_000_000_000)
    };
    for lanes in [1, 3] {
        let found = build(1, lanes);
        assert_good(&instance, &found);
        assert!(found.is_lowest(lower_bound_mm(&instance)), "{} mm", found.height_mm);
        assert_eq!(build(2, lanes), found);
    }
}

#[test]
fn a_limit_on_time_ends_lanes_that_take_turns() {
    let instance = asked(DVec3::new(40.0, 40.0, 80.0), 1.5, vec![item(hollow(12.0, 2.0), 9, OrientationRule::Free)]);
    let config = NestingConfig { threads: 1, lanes: 3, ..NestingConfig::default() };
    let budget = SearchBudget::of_secs(1.0);
    let solution = nest(&instance, &config, &[], &budget, &mut ());
    assert_good(&instance, &solution);
    assert!(solution.unplaced.is_empty() && budget.secs_over() < 10.0, "{}", budget.secs_over());
}

#[test]
fn an_earlier_layout_is_kept_and_lacking_copies_are_inserted() {
    let bar = block(DVec3::new(10.0, 40.0, 8.0));
    let few = asked(DVec3::new(60.0, 60.0, 60.0), 2.0, vec![item(bar.clone(), 6, OrientationRule::Free)]);
    let start = nested(&few, &NestingConfig::default(), &[], 2000);
    let more = asked(DVec3::new(60.0, 60.0, 60.0), 2.0, vec![item(bar, 8, OrientationRule::Free)]);
    let mut first = None;
    let solution = nest(
        &more,
        &NestingConfig::default(),
        &start.placements,
        &NesterTestBudget(2000),
        &mut |s: &NestingSolution, _: u64| {
            first.get_or_insert(s.clone());
        },
    );
    assert_good(&more, &solution);
    let first = first.expect("tells of a layout");
    for placement in &start.placements {
        let kept = first.placements.iter().find(|p| p.copy == placement.copy).expect("still placed");
        assert!(kept.pose.translation.distance(placement.pose.translation) < 1e-6);
    }
}

#[test]
fn a_layout_only_ever_gets_better() {
    let items = vec![item(
        tetrahedron([DVec3::ZERO, DVec3::X * 30.0, DVec3::Y * 30.0, DVec3::Z * 30.0]),
        9,
        OrientationRule::Free,
    )];
    let instance = asked(DVec3::new(50.0, 50.0, 200.0), 1.0, items);
    let mut heights = Vec::new();
    let solution = nest(
        &instance,
        &NestingConfig::default(),
        &[],
        &NesterTestBudget(30_000),
        &mut |s: &NestingSolution, _: u64| {
            heights.push((s.unplaced.len(), s.height_mm));
        },
    );
    assert_good(&instance, &solution);
    assert!(heights.len() > 1 && heights.is_sorted_by(|a, b| b < a), "{heights:?}");
    assert!(heights.last().expect("is not empty").1 < 0.95 * heights[0].1, "{heights:?}");
}

#[test]
fn nothing_is_put_into_a_sealed_cavity() {
    let items = vec![
        item(hollow(40.0, 2.0), 1, OrientationRule::Free),
        item(block(DVec3::splat(8.0)), 10, OrientationRule::Free),
    ];
    let instance = asked(DVec3::new(45.0, 45.0, 120.0), 1.0, items);
    let solution = nested(&instance, &NestingConfig::default(), &[], 4000);
    assert_good(&instance, &solution);
    assert!(solution.unplaced.is_empty() && solution.height_mm > 45.0);
}

#[test]
fn a_start_that_breaks_the_rules_is_not_kept() {
    let cube = block(DVec3::splat(10.0));
    let instance = asked(DVec3::splat(50.0), 2.0, vec![item(cube, 3, OrientationRule::Fixed)]);
    let at = |copy: u32, x: f64, turn: DQuat| ItemPlacement {
        item: 0,
        copy,
        pose: Pose::new(turn, DVec3::new(x, 10.0, 10.0)),
    };
    // Too near to the first, and turned.
    let start = [at(0, 10.0, DQuat::IDENTITY), at(1, 21.0, DQuat::IDENTITY), at(2, 40.0, DQuat::from_rotation_x(0.3))];
    let solution = nested(&instance, &NestingConfig::default(), &start, 500);
    assert_good(&instance, &solution);
    assert!(solution.unplaced.is_empty());
}

fn any_mesh() -> impl Strategy<Value = Arc<Mesh>> {
    let edge = || 4.0..40.0_f64;
    prop_oneof![
        (edge(), edge(), edge()).prop_map(|(x, y, z)| block(DVec3::new(x, y, z))),
        (edge(), edge(), edge(), -5.0..5.0_f64).prop_map(|(x, y, z, skew)| {
            tetrahedron([DVec3::ZERO, DVec3::new(x, skew, 0.0), DVec3::new(skew, y, 0.0), DVec3::new(skew, skew, z)])
        }),
        (15.0..40.0_f64).prop_map(|size| hollow(size, 2.0)),
    ]
}

fn any_rule() -> impl Strategy<Value = OrientationRule> {
    use OrientationRule::{Axis, Fixed, Free, Upright};
    prop_oneof![Just(Free), Just(Upright), Just(Axis), Just(Fixed)]
}

fn any_tilt() -> impl Strategy<Value = TiltLimit> {
    let direction = prop_oneof![
        Just(DVec3::Z),
        Just(DVec3::NEG_X),
        (-1.0..1.0_f64, -1.0..1.0_f64, 0.1..1.0_f64).prop_map(DVec3::from),
    ];
    (direction, prop_oneof![Just(0.0), 0.0..90.0_f64, 90.0..180.0_f64])
        .prop_map(|(direction, within_deg)| TiltLimit::new(direction, within_deg).expect("is a tilt"))
}

fn any_orientation() -> impl Strategy<Value = OrientationLimits> {
    (any_rule(), prop::collection::vec(any_tilt(), 0..3)).prop_map(|(rule, tilts)| OrientationLimits { rule, tilts })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn every_layout_is_proved_and_every_copy_accounted_for(
        parts in prop::collection::vec((any_mesh(), 1..4_u32, any_orientation()), 1..6),
        size in (30.0..80.0_f64, 30.0..80.0_f64, 30.0..90.0_f64),
        clearance_mm in 0.0..4.0_f64,
        extra_mm in prop_oneof![Just(0.0), 0.0..4.0_f64],
        share in prop_oneof![Just(None), (0.1..1.0_f64).prop_map(Some)],
        seed in 0..1000_u64,
    ) {
        let items = parts.into_iter().map(|(mesh, copies, rule)| item(mesh, copies, rule)).collect();
        let instance = asked(size.into(), clearance_mm, items).with_clearance_z_extra(extra_mm).expect("is a distance");
        let cap = LayerAreaCap::from_share(0.2, share, &instance.volume());
        let instance = instance.with_layer_cap(cap).expect("is a cap");
        let solution = nested(&instance, &NestingConfig { seed, ..NestingConfig::default() }, &[], 2500);
        assert_good(&instance, &solution);
        for mut config in each_method(2).into_iter().skip(1) {
            config.seed = seed;
            assert_good(&instance, &nested(&instance, &config, &[], 2500));
        }
    }
}

#[test]
fn a_cone_and_a_face_are_kept_while_the_lid_falls() {
    let plate = block(DVec3::new(30.0, 20.0, 4.0));
    let wedge = tetrahedron([DVec3::ZERO, DVec3::X * 25.0, DVec3::Y * 20.0, DVec3::Z * 15.0]);
    let tilts = |direction: DVec3, within| vec![TiltLimit::new(direction, within).expect("is a tilt")];
    // Plates are placed on edge and may lean by at most 25 degrees. The foot of the wedges must not look down.
    let on_edge = OrientationLimits { rule: OrientationRule::Free, tilts: tilts(DVec3::X, 25.0) };
    let foot_up = OrientationLimits { rule: OrientationRule::Free, tilts: tilts(DVec3::NEG_Z, 135.0) };
    let instance = asked(DVec3::new(60.0, 50.0, 200.0), 1.0, vec![item(plate, 8, on_edge), item(wedge, 8, foot_up)]);
    let mut heights = Vec::new();
    let solution = nest(
        &instance,
        &NestingConfig::default(),
        &[],
        &NesterTestBudget(20_000),
        &mut |s: &NestingSolution, _: u64| {
            heights.push(s.height_mm);
        },
    );
    assert_good(&instance, &solution);
    assert!(solution.unplaced.is_empty());
    // 8 plates need at least their height of 30 mm leaning by 25 degrees; the search finds better than the start.
    assert!(solution.height_mm >= 27.0 && solution.height_mm < heights[0], "{heights:?}");
}

#[test]
fn parts_exactly_as_large_as_the_volume_fit() {
    let slab = block(DVec3::new(60.0, 40.0, 15.0));
    for rule in [OrientationRule::Free, OrientationRule::Upright, OrientationRule::Axis, OrientationRule::Fixed] {
        // Two slabs and the clearance between them fill the height but for the spare of the clearance.
        let slabs = asked(DVec3::new(60.0, 40.0, 33.01), 3.0, vec![item(slab.clone(), 2, rule)]);
        let solution = nested(&slabs, &NestingConfig::default(), &[], 2_000);
        assert_good(&slabs, &solution);
        assert!(solution.unplaced.is_empty(), "{rule:?}: {solution:?}");
    }
}
