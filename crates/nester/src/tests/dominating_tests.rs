//! Tests of large parts that are searched alone first.

use std::sync::Arc;

use glam::DVec3;
use sample_parts::{SampleWorkload, workload_parts};

use crate::{
    BuildVolume, ItemPlacement, NestingConfig, NestingInstance, NestingItem, PlacedSolid, SearchBudget,
    find_removal_order, nest, prove_layout,
};

#[test]
fn wheels_that_set_the_height_lean_although_others_stand_around_them() {
    let parts = workload_parts(SampleWorkload::Wheels { wheels: 6 }).into_iter().enumerate();
    let items = parts.map(|(at, (mesh, copies))| NestingItem::new(format!("part {at}"), Arc::new(mesh), copies));
    let volume = BuildVolume { size_mm: DVec3::new(420.0, 220.0, 400.0) };
    let instance = NestingInstance::new(volume, 2.0, items.collect()).expect("it can be nested");
    let config = NestingConfig { threads: 1, ..NestingConfig::default() };
    let low = nest(&instance, &config, &[], &SearchBudget::of_evaluations(60_000), &mut ());
    // In one pile, the wheels alone are 6 x 25 + 5 x 2 = 160 mm high.
    assert!(low.unplaced.is_empty() && low.height_mm < 145.0, "{} mm", low.height_mm);
    assert!(prove_layout(&instance, &low.placements).is_proved());
    let body = |placement: &ItemPlacement| PlacedSolid {
        name: format!("{} {}", placement.item, placement.copy),
        mesh: instance.items()[placement.item].mesh.clone(),
        pose: placement.pose,
        clearance_mm: instance.clearance_mm(),
    };
    assert!(find_removal_order(&low.placements.iter().map(body).collect::<Vec<_>>()).locked.is_empty());
}
