//! Continues from an existing layout: a late order is added, and copies that are already promised must not move.
//!
//! `cargo run --release -p nester --example continue_layout`
#![allow(clippy::print_stdout)] // an example prints what it does

use std::{error::Error, sync::Arc};

use glam::DVec3;
use nester::{
    BuildVolume, InstanceError, ItemPlacement, NestingConfig, NestingInstance, NestingItem, NestingSolution,
    PreparedMeshes, SearchBudget, insert_copies, nest_with_cache,
};

fn main() -> Result<(), Box<dyn Error>> {
    let (knob, rail) =
        (Arc::new(sample_parts::knob(42.0, 20.0, 6)), Arc::new(sample_parts::rail(90.0, 35.0, 10.0, 2.5)));
    let machine = BuildVolume { size_mm: DVec3::new(110.0, 110.0, 160.0) };
    let asked = |knobs: u32, rails: u32| -> Result<NestingInstance, InstanceError> {
        let items = vec![NestingItem::new("knob", knob.clone(), knobs), NestingItem::new("rail", rail.clone(), rails)];
        NestingInstance::new(machine, 2.0, items)
    };
    // The meshes are prepared once for all searches below.
    let (config, prepared) = (NestingConfig::default(), PreparedMeshes::default());

    let monday = asked(8, 4)?;
    let first = nest_with_cache(&monday, &config, &[], &prepared, &SearchBudget::of_evaluations(60_000), &mut ());
    println!("Monday: {}", describe_layout(&monday, &first));

    // Three more knobs: they are placed into gaps, and other parts move to make room. The search does not start
    // again.
    let tuesday = asked(11, 4)?;
    let budget = SearchBudget::of_evaluations(20_000);
    let inserted = insert_copies(&tuesday, &config, &first.placements, &prepared, &budget, &mut ());
    println!("Tuesday, three knobs more: {}", describe_layout(&tuesday, &inserted));
    println!("  {} of the parts moved", moved(&first.placements, &inserted.placements));

    // Monday's knobs are promised to a customer and keep their poses; all other parts may still move.
    let promised: Vec<ItemPlacement> = first.placements.iter().filter(|p| p.item == 0).copied().collect();
    let reserved = asked(11, 6)?.with_pinned(promised.clone());
    let budget = SearchBudget::of_evaluations(60_000);
    let last = nest_with_cache(&reserved, &config, &first.placements, &prepared, &budget, &mut ());
    println!("Wednesday, two rails more and {} knobs promised: {}", promised.len(), describe_layout(&reserved, &last));
    println!("  {} of the promised parts moved", moved(&promised, &last.placements));
    Ok(())
}

fn describe_layout(instance: &NestingInstance, solution: &NestingSolution) -> String {
    let (placed, copies) = (solution.placements.len(), instance.copy_count());
    format!("{placed} of {copies} parts, {:.1} mm high", solution.height_mm)
}

/// Number of copies of an earlier layout that have another pose in a later one.
fn moved(before: &[ItemPlacement], after: &[ItemPlacement]) -> usize {
    before.iter().filter(|placement| !after.contains(placement)).count()
}
