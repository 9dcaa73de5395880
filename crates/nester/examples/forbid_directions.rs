//! Forbids orientations: some parts keep a side up, some faces must not face down, and no part may be locked into
//! others. Then prints the order in which the finished parts can be removed from the powder.
//!
//! `cargo run --release -p nester --example forbid_directions`
#![allow(clippy::print_stdout)] // an example prints what it does

use std::{error::Error, sync::Arc};

use nester::{
    BuildVolume, FaceNotDown, InterlockRule, NestingConfig, NestingInstance, NestingItem, OrientationLimits,
    OrientationRule, PlacedSolid, SearchBudget, TiltLimit, find_removal_order,
    glam::DVec3,
    nest, obeys_orientation,
    solids::{Mesh, MeshError},
};

fn main() -> Result<(), Box<dyn Error>> {
    // A cup must not be printed upside down, because it would hold powder: its z axis stays within 60 degrees of up.
    let cup_limits = OrientationLimits::new(OrientationRule::Free, &[TiltLimit::new(DVec3::Z, 60.0)?], &[]);
    // The upper face of a pulley is visible in use. It must not face down, because layers are visible as steps there.
    let pulley = OrientationLimits::new(OrientationRule::Free, &[], &[FaceNotDown::new(DVec3::Z, 45.0)?]);
    let items = vec![
        NestingItem::new("cup", Arc::new(cup(44.0, 18.0)?), 3).with_orientation(cup_limits),
        NestingItem::new("pulley", Arc::new(Mesh::tube(44.0, 8.0, 12.0)?), 3).with_orientation(pulley),
        // A lampshade stays upright and only turns about z.
        NestingItem::new("lampshade", Arc::new(Mesh::tube(50.0, 46.0, 36.0)?), 3)
            .with_orientation(OrientationRule::Upright),
        // Rings may have any orientation, but they must not form a chain.
        NestingItem::new("ring", Arc::new(Mesh::tube(36.0, 26.0, 5.0)?), 8),
    ];
    let machine = BuildVolume { size_mm: DVec3::new(110.0, 110.0, 160.0) };
    let instance = NestingInstance::new(machine, 1.5, items)?;
    let config = NestingConfig { interlock: InterlockRule::Forbid, ..NestingConfig::default() };
    let budget = SearchBudget::of_evaluations(100_000);
    let solution = nest(&instance, &config, &[], &budget, &mut ());

    let asked = |item: usize| &instance.items()[item].orientation;
    let obeying = solution.placements.iter().filter(|p| obeys_orientation(asked(p.item), &p.pose)).count();
    println!("{:.1} mm high; {obeying} of {} parts stand as they may", solution.height_mm, solution.placements.len());

    let bodies = PlacedSolid::of_layout(&instance, &solution.placements);
    let apart = find_removal_order(&bodies);
    println!("{} parts are locked into others; the rest is drawn out in this order:", apart.locked.len());
    for &(body, direction) in &apart.order {
        println!("  {:<14} {}", bodies[body].name, in_words(direction));
    }
    Ok(())
}

/// A cup with walls of 2 mm: one mesh of two solids that overlap, the wall and the bottom.
fn cup(outer_mm: f64, height_mm: f64) -> Result<Mesh, MeshError> {
    let (wall, bottom) = (Mesh::tube(outer_mm, outer_mm - 4.0, height_mm)?, Mesh::tube(outer_mm - 2.0, 0.0, 2.0)?);
    let first = wall.vertices().len() as u32;
    let vertices = [wall.vertices(), bottom.vertices()].concat();
    let of_bottom = bottom.triangles().iter().map(|corners| corners.map(|corner| first + corner));
    Mesh::new(vertices, wall.triangles().iter().copied().chain(of_bottom).collect())
}

/// A direction in words: `up`, `up and left`.
fn in_words(direction: DVec3) -> String {
    let word = |at: f64, below: &'static str, above: &'static str| match at {
        at if at > 0.1 => Some(above),
        at if at < -0.1 => Some(below),
        _ => None,
    };
    let words = [
        word(direction.z, "down", "up"),
        word(direction.x, "left", "right"),
        word(direction.y, "to the front", "to the back"),
    ];
    words.into_iter().flatten().collect::<Vec<_>>().join(" and ")
}
