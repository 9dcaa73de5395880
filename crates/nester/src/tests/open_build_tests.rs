//! Tests of open builds: copies come and go, some are fixed, zones stay free, queues are truncated, prepared data is
//! cached.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{Arc, Mutex},
};

use glam::DVec3;
use sample_parts::fixtures::star;
use solids::{Bounds, Mesh};

use super::{
    nester_tests::{NesterTestBudget, asked, assert_good, item, nested},
    testing::{block, each_method, tetrahedron},
};
use crate::{
    InstanceError, ItemPlacement, LayerAreaCap, NestingConfig, NestingInstance, NestingItem, NestingSolution,
    OrientationRule, PreparedMeshCache, PreparedMeshes, insert_copies, nest, nest_with_cache, prove_with_keep_out,
};

fn knobbly(size: DVec3, seed: f64) -> Arc<Mesh> {
    star(2, move |d| (size * d).length() * (1.0 + 0.25 * (5.0 * d.x + 3.0 * d.y + seed).sin()))
}

/// 100 copies of ten different shapes.
fn hundred() -> Vec<NestingItem> {
    let mesh = |n: u32| match n % 3 {
        0 => block(DVec3::new(8.0 + f64::from(n), 14.0, 6.0)),
        1 => tetrahedron([DVec3::ZERO, DVec3::X * 20.0, DVec3::Y * (14.0 + f64::from(n)), DVec3::Z * 12.0]),
        _ => knobbly(DVec3::new(9.0, 6.0, 4.0 + 0.4 * f64::from(n)), f64::from(n)),
    };
    (0..10).map(|n| item(mesh(n), 10, OrientationRule::Free)).collect()
}

fn pose_of(solution: &NestingSolution, copy: (usize, u32)) -> Option<solids::Pose> {
    solution.placements.iter().find(|p| (p.item, p.copy) == copy).map(|p| p.pose)
}

#[test]
fn a_copy_more_stands_among_a_hundred_and_those_far_from_it_stay() {
    let size = DVec3::new(100.0, 100.0, 200.0);
    let before = nested(&asked(size, 1.5, hundred()), &NestingConfig::default(), &[], 20_000);
    let mut items = hundred();
    items.push(item(knobbly(DVec3::new(8.0, 7.0, 5.0), 0.3), 1, OrientationRule::Free));
    let more = asked(size, 1.5, items);
    let mut improvements = 0;
    let stop = NesterTestBudget(50_000);
    let after = insert_copies(
        &more,
        &NestingConfig::default(),
        &before.placements,
        &PreparedMeshes::default(),
        &stop,
        &mut |_: &NestingSolution, _: u64| improvements += 1,
    );
    assert_good(&more, &after);
    assert!(after.unplaced.is_empty() && improvements >= 1 && after.evaluations < 10_000, "{}", after.evaluations);
    let moved = before.placements.iter().filter(|p| {
        let now = pose_of(&after, (p.item, p.copy)).expect("still stands");
        now.translation.distance(p.pose.translation) > 1e-6
    });
    assert!(moved.count() <= 40, "most stay");
    // Three are cancelled: no other copy moves.
    let fewer: Vec<ItemPlacement> = after.placements.iter().filter(|p| p.item != 10 || p.copy != 0).copied().collect();
    let gone = asked(size, 1.5, hundred());
    let left = insert_copies(
        &gone,
        &NestingConfig::default(),
        &fewer,
        &PreparedMeshes::default(),
        &stop,
        &mut |_: &NestingSolution, _: u64| {},
    );
    assert_good(&gone, &left);
    assert!(left.placements.iter().all(|p| {
        pose_of(&after, (p.item, p.copy)).is_some_and(|pose| pose.translation.distance(p.pose.translation) < 1e-9)
    }));
}

#[test]
fn what_finds_no_gap_makes_the_parts_around_it_give_way() {
    // Six bars fill the floor except for gaps that together are as wide as a seventh bar.
    let bar = block(DVec3::new(10.0, 60.0, 10.0));
    let size = DVec3::new(88.0, 60.0, 11.0);
    let bars = |copies: u32| asked(size, 1.0, vec![item(bar.clone(), copies, OrientationRule::Fixed)]);
    let at = |copy: u32| ItemPlacement {
        item: 0,
        copy,
        pose: solids::Pose::new(glam::DQuat::IDENTITY, DVec3::X * (0.5 + 14.0 * f64::from(copy))),
    };
    let standing: Vec<ItemPlacement> = (0..6).map(at).collect();
    let seven = bars(7);
    let stop = NesterTestBudget(100_000);
    let after = insert_copies(
        &seven,
        &NestingConfig::default(),
        &standing,
        &PreparedMeshes::default(),
        &stop,
        &mut |_: &NestingSolution, _: u64| {},
    );
    assert_good(&seven, &after);
    assert!(after.unplaced.is_empty(), "{:?}", after.unplaced);
}

#[test]
fn a_promised_copy_never_moves_through_the_whole_search() {
    let size = DVec3::new(60.0, 60.0, 150.0);
    let mut items = hundred();
    items.truncate(6);
    items.iter_mut().for_each(|item| item.copies = 4);
    let free = asked(size, 1.5, items.clone());
    let first = nested(&free, &NestingConfig::default(), &[], 1000);
    let pinned: Vec<ItemPlacement> = first.placements.iter().step_by(7).copied().collect();
    let promised = asked(size, 1.5, items).with_pinned(pinned.clone());
    for (config, evaluations) in each_method(0).iter().zip([40_000, 30_000]) {
        let solution = nested(&promised, config, &first.placements, evaluations);
        assert_good(&promised, &solution);
        for pin in &pinned {
            assert_eq!(pose_of(&solution, (pin.item, pin.copy)), Some(pin.pose), "{:?}", config.method);
        }
    }
    // A copy that was fixed against the rules stays unplaced.
    let mut wrong = pinned[0];
    wrong.pose.translation.z = -30.0;
    let broken = promised.with_pinned(vec![wrong]);
    let solution = nested(&broken, &NestingConfig::default(), &[], 2000);
    assert_good(&broken, &solution);
    assert_eq!(solution.unplaced, vec![(wrong.item, wrong.copy)]);
}

/// Zones at the floor, in the middle, and at the ceiling.
fn zones() -> [Bounds; 3] {
    let zone = |min: [f64; 3], max: [f64; 3]| Bounds { min: min.into(), max: max.into() };
    [
        zone([-5.0, -5.0, -5.0], [25.0, 25.0, 20.0]),
        zone([30.0, 30.0, 14.0], [60.0, 34.0, 40.0]),
        zone([0.0, 0.0, 110.0], [60.0, 60.0, 120.0]),
    ]
}

#[test]
fn nothing_stands_in_a_keep_out_box_by_either_method() {
    let size = DVec3::new(60.0, 60.0, 120.0);
    let mut items = hundred();
    items.iter_mut().for_each(|item| item.copies = 3);
    let reserved = asked(size, 1.5, items).with_keep_out(&zones()).expect("are boxes");
    let searches = each_method(0).into_iter().zip([40_000, 60_000]);
    for (config, evaluations) in searches.chain([(NestingConfig::default(), 1)]) {
        let solution = nested(&reserved, &config, &[], evaluations);
        assert_good(&reserved, &solution);
        assert!(solution.placements.len() >= 25, "{:?} {}", config.method, solution.placements.len());
    }
}

#[test]
fn a_part_raised_for_full_layers_is_not_raised_into_a_zone() {
    let (cubes, size) =
        (vec![item(block(DVec3::splat(10.0)), 4, OrientationRule::Upright)], DVec3::new(30.0, 30.0, 60.0));
    let zone = Bounds { min: DVec3::new(0.0, 0.0, 15.0), max: DVec3::new(14.0, 30.0, 40.0) };
    // A layer takes one cube. There is room under the zone for the first one only.
    let cap = LayerAreaCap { layer_mm: 0.1, area_mm2: 150.0 };
    let instance =
        asked(size, 1.0, cubes).with_layer_cap(cap).expect("is a cap").with_keep_out(&[zone]).expect("a box");
    for evaluations in [1, 3000] {
        let solution = nested(&instance, &NestingConfig::default(), &[], evaluations);
        assert_good(&instance, &solution);
        assert!(solution.unplaced.is_empty(), "{evaluations}: {:?}", solution.unplaced);
    }
}

#[test]
fn the_judge_sees_who_stands_in_a_zone_and_who_only_touches_it() {
    let body = |x: f64| crate::PlacedSolid {
        name: "cube".to_owned(),
        mesh: block(DVec3::splat(10.0)),
        pose: solids::Pose::new(glam::DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)),
        clearance_mm: 0.0,
    };
    let zone = |low: f64, high: f64| Bounds { min: DVec3::splat(low), max: DVec3::splat(high) };
    let intruding = |x: f64, zone: Bounds| prove_with_keep_out(&[body(x)], DVec3::splat(50.0), 0.0, &[zone]).intruding;
    assert_eq!(intruding(20.0, zone(-1.0, 20.0)), []);
    assert_eq!(intruding(19.999, zone(-1.0, 20.0)), [(0, 0)]);
    assert_eq!(intruding(2.0, zone(4.0, 5.0)), [(0, 0)], "the zone is inside the part");
    assert_eq!(intruding(12.0, zone(-1.0, 40.0)), [(0, 0)], "the part is inside the zone");
    let not_a_box = asked(DVec3::splat(9.0), 0.0, vec![item(block(DVec3::ONE), 1, OrientationRule::Free)]);
    assert!(matches!(not_a_box.with_keep_out(&[zone(3.0, 3.0)]), Err(InstanceError::BadKeepOut(..))));
}

#[test]
fn a_line_far_too_long_is_cut_by_precedence() {
    let mesh = |n: u32| block(DVec3::new(6.0 + f64::from(n % 5), 5.0 + f64::from(n % 3), 4.0 + f64::from(n % 7)));
    let items: Vec<NestingItem> = (0..40).map(|n| item(mesh(n), 25, OrientationRule::Free)).collect();
    let line = asked(DVec3::new(50.0, 50.0, 40.0), 1.0, items);
    let solution = nested(&line, &NestingConfig::default(), &[], 3000);
    assert_good(&line, &solution);
    let placed: BTreeSet<(usize, u32)> = solution.placements.iter().map(|p| (p.item, p.copy)).collect();
    let first_out = solution.unplaced[0].0 * 25 + solution.unplaced[0].1 as usize;
    assert!(placed.len() > 100 && placed.len() < 800, "{}", placed.len());
    // Nearly all kept parts come from the front of the queue; later ones only fill gaps.
    assert!(10 * first_out >= 8 * placed.len(), "{first_out} of {}", placed.len());
}

/// A cache in memory that may return truncated bytes.
#[derive(Default)]
struct MemoryMeshCache {
    kept: Mutex<BTreeMap<String, Vec<u8>>>,
    fetched: Mutex<usize>,
    torn: bool,
}

impl PreparedMeshCache for MemoryMeshCache {
    fn fetch_bytes(&self, key: &str) -> Option<Vec<u8>> {
        let mut bytes = self.kept.lock().expect("is sound").get(key)?.clone();
        *self.fetched.lock().expect("is sound") += 1;
        if self.torn {
            bytes.truncate(bytes.len() * 2 / 3);
        }
        Some(bytes)
    }

    fn store_bytes(&self, key: &str, bytes: &[u8]) {
        self.kept.lock().expect("is sound").insert(key.to_owned(), bytes.to_vec());
    }
}

#[test]
fn a_build_is_the_same_whether_work_was_kept_or_torn_or_done_anew() {
    let build = |prepared: PreparedMeshes, threads: usize| {
        let mut items = hundred();
        items.iter_mut().for_each(|item| item.copies = 2);
        let instance: NestingInstance = asked(DVec3::new(50.0, 50.0, 90.0), 1.0, items);
        let config = NestingConfig { threads, ..NestingConfig::default() };
        nest_with_cache(
            &instance,
            &config,
            &[],
            &prepared,
            &NesterTestBudget(3000),
            &mut |_: &NestingSolution, _: u64| {},
        )
    };
    let memory = Arc::new(MemoryMeshCache::default());
    let kept = || memory.kept.lock().expect("is sound").len();
    let fetched = || *memory.fetched.lock().expect("is sound");
    let over = |memory: &Arc<MemoryMeshCache>| PreparedMeshes::default().with_cache(Some(memory.clone()));
    let alone = build(PreparedMeshes::default(), 1);
    assert_eq!(build(over(&memory), 1), alone);
    assert_eq!(fetched(), 0);
    assert_eq!(build(over(&memory), 1), alone);
    assert!(kept() >= 30 && fetched() == kept(), "an outline and two guides each: {}", kept());
    let torn = MemoryMeshCache {
        kept: Mutex::new(memory.kept.lock().expect("is sound").clone()),
        torn: true,
        ..MemoryMeshCache::default()
    };
    let torn = Arc::new(torn);
    assert_eq!(build(over(&torn), 1), alone);
    assert_eq!(torn.kept.lock().expect("is sound").len(), kept());
    assert_eq!(build(over(&torn), 2), build(PreparedMeshes::default(), 2));
}

#[test]
fn a_mesh_that_two_searches_share_is_prepared_once_and_forgotten_with_its_last_holder() {
    let prepared = PreparedMeshes::default();
    let build = |mesh: &Arc<Mesh>, copies: u32| {
        let instance = asked(DVec3::splat(60.0), 1.0, vec![item(mesh.clone(), copies, OrientationRule::Free)]);
        nest_with_cache(
            &instance,
            &NestingConfig::default(),
            &[],
            &prepared,
            &NesterTestBudget(500),
            &mut |_: &NestingSolution, _: u64| {},
        )
    };
    let (bar, cube) = (block(DVec3::new(20.0, 8.0, 5.0)), block(DVec3::splat(9.0)));
    let first = build(&bar, 4);
    assert_eq!(prepared.len(), 1);
    assert_eq!(build(&bar, 4), first, "work at hand changes nothing");
    drop(bar);
    build(&cube, 2);
    assert_eq!(prepared.len(), 1, "the bar is forgotten");
}

#[test]
fn a_part_that_fits_only_aslant_stands_among_zones() {
    let rail = block(DVec3::new(70.0, 3.0, 3.0));
    let size = DVec3::splat(50.0);
    let corner = Bounds { min: DVec3::ZERO, max: DVec3::new(12.0, 50.0, 12.0) };
    let aslant = asked(size, 1.0, vec![item(rail, 1, OrientationRule::Free)]).with_keep_out(&[corner]).expect("a box");
    let solution =
        nest(&aslant, &NestingConfig::default(), &[], &NesterTestBudget(20_000), &mut |_: &NestingSolution, _: u64| {});
    assert_good(&aslant, &solution);
}
