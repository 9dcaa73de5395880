//! Continues from an existing layout: a late order is added, and copies that are already promised must not move.
//!
//! `cargo run --release -p nester --example continue_layout`
#![allow(clippy::print_stdout)] // an example prints what it does

use std::{error::Error, sync::Arc};

use nester::{
    BuildVolume, InstanceError, ItemPlacement, NestingInstance, NestingItem, NestingSearch, NestingSolution,
    PreparedMeshes, SearchBudget, glam::DVec3, solids::Mesh,
};

fn main() -> Result<(), Box<dyn Error>> {
    let knob = Arc::new(Mesh::tube(42.0, 8.0, 20.0)?);
    let rail = Arc::new(Mesh::cuboid(DVec3::new(90.0, 35.0, 10.0))?);
    let machine = BuildVolume { size_mm: DVec3::new(110.0, 110.0, 160.0) };
    let asked = |knobs: u32, rails: u32| -> Result<NestingInstance, InstanceError> {
        let items = vec![NestingItem::new("knob", knob.clone(), knobs), NestingItem::new("rail", rail.clone(), rails)];
        NestingInstance::new(machine, 2.0, items)
    };
    // The meshes are prepared once for all searches below.
    let prepared = PreparedMeshes::default();

    let monday = asked(8, 4)?;
    let first = NestingSearch::new(&monday).with_prepared(&prepared).nest(&SearchBudget::of_evaluations(60_000));
    println!("Monday: {}", describe_layout(&monday, &first));

    // Three more knobs: they are placed into gaps, and other parts move to make room. The search does not start
    // again.
    let tuesday = asked(11, 4)?;
    let budget = SearchBudget::of_evaluations(20_000);
    let inserted = NestingSearch::new(&tuesday).with_prepared(&prepared).insert_copies(&first.placements, &budget);
    println!("Tuesday, three knobs more: {}", describe_layout(&tuesday, &inserted));
    println!("  {} of the parts moved", moved(&first.placements, &inserted.placements));

    // Monday's knobs are promised to a customer and keep their poses; all other parts may still move.
    let promised: Vec<ItemPlacement> = first.placements.iter().filter(|p| p.item == 0).copied().collect();
    let reserved = asked(11, 6)?.with_pinned(promised.clone());
    let budget = SearchBudget::of_evaluations(60_000);
    let last = NestingSearch::new(&reserved).with_prepared(&prepared).continue_from(&first.placements, &budget);
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
