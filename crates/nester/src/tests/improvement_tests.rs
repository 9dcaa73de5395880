//! Tests of rounds of improvement: nothing gets higher, the pool is of different layouts, and what is not valid is left
//! out.

use glam::DVec3;

use super::{
    nester_tests::{asked, assert_good, item, nested},
    testing::{block, tetrahedron},
};
use crate::{
    ImprovedLayouts, ItemPlacement, NestingConfig, NestingInstance, NestingSolution, PreparedMeshes, SearchBudget,
    improve_layouts, prove_layout,
};

/// Three shapes, four copies of each.
fn mixed(clearance_mm: f64) -> NestingInstance {
    let corners = [DVec3::ZERO, DVec3::X * 25.0, DVec3::Y * 20.0, DVec3::Z * 15.0];
    let meshes = [block(DVec3::new(12.0, 30.0, 6.0)), tetrahedron(corners), block(DVec3::new(9.0, 9.0, 14.0))];
    let items = meshes.map(|mesh| item(mesh, 4, crate::OrientationRule::Free));
    asked(DVec3::new(45.0, 45.0, 200.0), clearance_mm, items.into())
}

fn improved(instance: &NestingInstance, seed: u64, pool: &[Vec<ItemPlacement>], evaluations: u64) -> ImprovedLayouts {
    let (config, budget) =
        (NestingConfig { seed, ..NestingConfig::default() }, SearchBudget::of_evaluations(evaluations));
    improve_layouts(instance, &config, pool, &PreparedMeshes::default(), &budget, &mut ())
}

#[test]
fn rounds_never_raise_a_layout_and_their_pool_is_of_different_valid_ones() {
    let instance = mixed(1.5);
    let first = nested(&instance, &NestingConfig::default(), &[], 300);
    let (mut pool, mut height_mm) = (vec![first.placements.clone()], first.height_mm);
    for (seed, evaluations) in [(2, 2000), (3, 8000), (4, 200_000)] {
        let found = improved(&instance, seed, &pool, evaluations);
        assert_good(&instance, &found.best);
        assert!(found.best.height_mm <= height_mm && found.best.unplaced.is_empty());
        assert!(found.best.evaluations > 0 && found.best.evaluations <= evaluations + 500);
        assert_eq!(found.pool[0], found.best.placements);
        (pool, height_mm) = (found.pool, found.best.height_mm);
    }
    assert!(height_mm < first.height_mm, "{height_mm} of {}", first.height_mm);
    assert!((2..=4).contains(&pool.len()), "{}", pool.len());
    for (at, layout) in pool.iter().enumerate() {
        assert!(layout.len() == 12 && prove_layout(&instance, layout).is_proved());
        assert!(!pool[..at].contains(layout), "each is another one");
    }
    assert_eq!(improved(&instance, 5, &pool, 3000), improved(&instance, 5, &pool, 3000));
}

#[test]
fn layouts_that_lack_copies_or_their_clearance_are_left_out() {
    let instance = mixed(1.5);
    let good = nested(&instance, &NestingConfig::default(), &[], 300);
    let tight = nested(&mixed(0.2), &NestingConfig::default(), &[], 3000);
    assert!(tight.height_mm < good.height_mm);
    let lacking = good.placements[1..].to_vec();
    let found = improved(&instance, 2, &[lacking, tight.placements, good.placements], 2000);
    assert_good(&instance, &found.best);
    assert!(found.best.unplaced.is_empty() && found.best.height_mm <= good.height_mm);
    assert!(found.pool.iter().all(|layout| prove_layout(&instance, layout).is_proved() && layout.len() == 12));
    let anew = improved(&instance, 2, &[], 2000);
    assert!(anew.best.unplaced.is_empty() && anew.pool == [anew.best.placements.clone()]);
}

#[test]
fn the_listener_hears_of_the_pool_and_of_each_lower_layout() {
    let instance = mixed(1.5);
    let first = nested(&instance, &NestingConfig::default(), &[], 300);
    let (mut heights_mm, prepared) = (Vec::new(), PreparedMeshes::default());
    let mut listener = |better: &NestingSolution, _: u64| heights_mm.push(better.height_mm);
    let budget = SearchBudget::of_evaluations(20_000);
    let pool = [first.placements];
    let found = improve_layouts(&instance, &NestingConfig::default(), &pool, &prepared, &budget, &mut listener);
    assert!((heights_mm[0] - first.height_mm).abs() < 1e-9 && heights_mm.is_sorted_by(|one, next| one > next));
    assert!(found.best.height_mm <= heights_mm[heights_mm.len() - 1] + 1e-9);
}
