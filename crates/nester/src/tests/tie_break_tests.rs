//! Tests of the criteria after the height, and of the cap on layer areas.

use std::sync::Arc;

use glam::DVec3;
use solids::Mesh;

use super::testing::{block, each_method, tetrahedron};
use crate::{
    BuildVolume, LayerAreaCap, LayerAreas, NestingConfig, NestingInstance, NestingItem, NestingReport, NestingSolution,
    OrientationRule, SearchComponents, StopCondition, nest,
};

struct TieBreakTestBudget(u64);

impl StopCondition for TieBreakTestBudget {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        evaluations as f64 / self.0 as f64
    }
}

fn asked(size: DVec3, items: Vec<(Arc<Mesh>, u32, OrientationRule)>) -> NestingInstance {
    let item = |(mesh, copies, rule): (Arc<Mesh>, u32, OrientationRule)| NestingItem {
        name: "part".to_owned(),
        mesh,
        copies,
        orientation: rule.into(),
        clearance_mm: None,
    };
    NestingInstance::new(BuildVolume { size_mm: size }, 1.0, items.into_iter().map(item).collect())
        .expect("makes sense")
}

fn nested(instance: &NestingInstance, config: &NestingConfig, evaluations: u64) -> NestingSolution {
    nest(instance, config, &[], &TieBreakTestBudget(evaluations), &mut |_: &NestingSolution, _: u64| {})
}

fn measured(instance: &NestingInstance, solution: &NestingSolution) -> NestingReport {
    let placed: Vec<_> = solution.placements.iter().map(|p| (&*instance.items()[p.item].mesh, p.pose)).collect();
    NestingReport::new(instance, solution, crate::SearchSummary::default())
        .with_measurements(&placed, instance.layer_cap())
}

#[test]
fn what_settles_is_denser_and_nearer_and_no_higher() {
    let corner = tetrahedron([DVec3::ZERO, DVec3::X * 30.0, DVec3::Y * 26.0, DVec3::Z * 22.0]);
    let bar = block(DVec3::new(6.0, 28.0, 9.0));
    let items = vec![(corner, 6, OrientationRule::Free), (bar, 4, OrientationRule::Free)];
    let instance = asked(DVec3::new(70.0, 70.0, 100.0), items);
    let report = |settling| {
        let components = SearchComponents { tie_breaks: settling, ..SearchComponents::default() };
        measured(&instance, &nested(&instance, &NestingConfig { components, ..NestingConfig::default() }, 20_000))
    };
    let (loose, settled) = (report(false), report(true));
    // The search before the last step is the same except for its last fiftieth.
    assert!(
        settled.packing.height_mm <= loose.packing.height_mm + 0.5,
        "{} {}",
        settled.packing.height_mm,
        loose.packing.height_mm
    );
    assert!(settled.packing.packed_density >= loose.packing.packed_density * 0.999);
    let (near, far) = (settled.packing.mean_distance_mm, loose.packing.mean_distance_mm);
    assert!(near < far, "{near} {far}");
    let density = settled.packing.layers.mean_area_mm2 / settled.packing.density;
    assert!((density / (70.0 * 70.0) - 1.0).abs() < 0.01, "mean area over base is the density");
    assert!(settled.packing.layers.evenness > 0.0 && settled.packing.layers.evenness <= 1.0);
}

#[test]
fn a_cap_spreads_parts_over_more_layers_before_any_is_left_out() {
    // Four plates of 20 x 20 x 3 mm lie side by side on 45 x 45 mm where nothing forbids it.
    let plates = || vec![(block(DVec3::new(20.0, 20.0, 3.0)), 4, OrientationRule::Fixed)];
    let free = asked(DVec3::new(45.0, 45.0, 40.0), plates());
    for config in each_method(3) {
        let method = config.method;
        let capped = |area_mm2| {
            let instance = free.clone().with_layer_cap(LayerAreaCap { layer_mm: 0.1, area_mm2 }).expect("is a cap");
            let solution = nested(&instance, &config, 4_000);
            let areas = measured(&instance, &solution).packing.layers;
            assert!(areas.keeps_cap(), "{areas:?}");
            (solution.unplaced.len(), solution.height_mm)
        };
        assert!((nested(&free, &config, 4_000).height_mm - 3.0).abs() < 0.1, "{method:?}");
        let (left, height_mm) = capped(850.0);
        assert!(left == 0 && (5.8..9.0).contains(&height_mm), "{method:?} {height_mm}");
        let (left, height_mm) = capped(410.0);
        assert!(left == 0 && (11.6..20.0).contains(&height_mm), "{method:?} {height_mm}");
        assert_eq!(capped(390.0).0, 4, "{method:?}: one plate alone is too much");
    }
}

#[test]
fn a_cap_that_cannot_hold_all_leaves_out_the_last() {
    let cubes = vec![(block(DVec3::splat(10.0)), 6, OrientationRule::Free)];
    let cap = LayerAreaCap { layer_mm: 0.2, area_mm2: 105.0 };
    let instance = asked(DVec3::new(45.0, 45.0, 35.0), cubes).with_layer_cap(cap).expect("is a cap");
    let solution = nested(&instance, &NestingConfig::default(), 3_000);
    assert_eq!(
        solution.unplaced,
        [(0, 3), (0, 4), (0, 5)],
        "three cubes on top of each other are all there is room for"
    );
    assert!(measured(&instance, &solution).packing.layers.keeps_cap());
}

#[test]
fn the_first_layout_keeps_the_cap_too_when_there_is_no_time() {
    struct CancelledTieBreak;
    impl StopCondition for CancelledTieBreak {
        fn spent_share_at(&self, _: u64) -> f64 {
            f64::INFINITY
        }
    }
    let cubes = vec![(block(DVec3::splat(10.0)), 5, OrientationRule::Free)];
    let cap = LayerAreaCap { layer_mm: 0.1, area_mm2: 220.0 };
    let instance = asked(DVec3::new(60.0, 60.0, 60.0), cubes).with_layer_cap(cap).expect("is a cap");
    let solution =
        nest(&instance, &NestingConfig::default(), &[], &CancelledTieBreak, &mut |_: &NestingSolution, _: u64| {});
    let placed = solution.placements.iter().map(|p| (&*instance.items()[p.item].mesh, p.pose));
    assert!(LayerAreas::from_meshes(placed, cap).keeps_cap() && solution.unplaced.is_empty(), "{solution:?}");
}
