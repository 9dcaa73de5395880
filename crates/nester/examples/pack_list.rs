//! Packs a list of parts, and prints how the build height falls and what the build contains.
//!
//! `cargo run --release -p nester --example pack_list`
#![allow(clippy::print_stdout)] // an example prints what it does

use std::{error::Error, sync::Arc};

use nester::{
    BuildVolume, NestingInstance, NestingItem, NestingSearch, NestingSolution, SearchBudget, glam::DVec3,
    lower_bound_mm, prove_layout, solids::Mesh,
};

fn main() -> Result<(), Box<dyn Error>> {
    // The parts to print: name, mesh in mm, number of copies.
    let list = [
        ("plate", Mesh::cuboid(DVec3::new(60.0, 24.0, 4.0))?, 6),
        ("sleeve", Mesh::tube(22.0, 17.0, 14.0)?, 12),
        ("ring", Mesh::tube(40.0, 28.0, 8.0)?, 8),
        ("pulley", Mesh::tube(44.0, 8.0, 12.0)?, 4),
        ("bar", Mesh::cuboid(DVec3::new(60.0, 10.0, 8.0))?, 6),
    ];
    let items = list.map(|(name, mesh, copies)| NestingItem::new(name, Arc::new(mesh), copies));
    let machine = BuildVolume { size_mm: DVec3::new(120.0, 120.0, 200.0) };
    let clearance_mm = 2.0;
    let instance = NestingInstance::new(machine, clearance_mm, items.into())?;
    println!(
        "{} parts, at least {:.1} mm high whatever anybody does",
        instance.copy_count(),
        lower_bound_mm(&instance)
    );

    let mut printed_mm = f64::INFINITY;
    let mut listener = |better: &NestingSolution, evaluations: u64| {
        if better.unplaced.is_empty() && better.height_mm < 0.99 * printed_mm {
            printed_mm = better.height_mm;
            println!("{evaluations:>7} evaluations: {printed_mm:.1} mm");
        }
    };
    let budget = SearchBudget::of_evaluations(200_000);
    let solution = NestingSearch::new(&instance).with_listener(&mut listener).nest(&budget);

    let proof = prove_layout(&instance, &solution.placements);
    println!(
        "{:.1} mm high after {:.1} s, {:.0} % of the box is filled; {}",
        solution.height_mm,
        budget.elapsed_secs(),
        100.0 * solution.density(&instance),
        if proof.is_proved() { "proved on the triangles" } else { "NOT a valid layout" },
    );
    for (at, item) in instance.items().iter().enumerate() {
        let placed = solution.placements.iter().filter(|placement| placement.item == at).count();
        println!("{placed:>3} of {:>2} {}", item.copies, item.name);
    }
    Ok(())
}
