//! The method of "Nesting of 3D irregular shaped objects applied to powder-based additive manufacturing" (Springer, 2021), section
//! 2.3: one part after the other by flower pollination, OBB trees as the collision test.
//!
//! Followed to the letter: OBBs by principal axes, the tree with its mid-axis split, reduction and expansion by the
//! clearance; the sequence by the area of the box; the initial orientation with the smallest extent upright; the first part
//! in the corner; FPA over position and rotation for each next one; height first, closeness to the origin second; whole
//! layouts again and again, the best one kept; all four convergence conditions.
//!
//! What the paper leaves open, and what is done here:
//! - Population and iterations: settings. A first layout that would not be ready within the budget gets a part of the budget
//!   for each part instead, so that there always is a layout.
//! - "Area" is the largest face of the box; "closeness" is the distance of the far upper corner of the part's bounds.
//! - Starts: two flowers on top of everything and two in the corner, so that with room left a place is always found; the
//!   others scattered, half of them in the initial orientation.
//! - Positions are shares of the way that a part has within the walls, so that no proposal is lost to the walls.
//! - An interfering proposal is drawn anew a few times, then the flower keeps its place for this turn.
//! - The objective is asked before the interference test, which it saves where a place is no better.
//! - Boxes do not see a part inside another's solid: a best place is checked for it. A finished layout is proved on its
//!   triangles before anybody hears of it; an offender would be taken out.
//! - A part that finds no place is left out of this layout and tried again in the next; layouts with more parts win.

mod clear;
mod layout;
mod paper_config;
mod shape;
mod zones;

use clear::keeps_clear;
use layout::{Layout, Pace};
pub use paper_config::PaperConfig;
use shape::{Shape, shapes};
use solids::Bounds;
use zones::Zones;

use super::{Config, Instance, Listener, Placement, Solution, Stop};

/// What a placement may stand out of the walls, mm: within the judge's tolerance, and what a promised one may.
const WALL_SLACK_MM: f64 = 8e-7;
/// The share of the budget that a first layout may take.
const FIRST_LAYOUT_SHARE: f64 = 0.9;

/// Nests by the published method until `stop` or one of its own convergence conditions ends it. Searches with one thread.
pub(crate) fn nest_paper(
    instance: &Instance,
    config: &Config,
    stop: &dyn Stop,
    listener: &mut dyn Listener,
) -> Solution {
    let shapes = shapes(instance, config.paper.reduce_tree);
    let sequence = sequence(instance, &shapes);
    let zones = Zones::new(instance);
    let mut evaluations = 0;
    let mut best: Option<Solution> = None;
    let mut previous_mm: Option<f64> = None;
    for number in 0.. {
        let first = best.is_none();
        let run = Run { instance, config, shapes: &shapes, sequence: &sequence, zones: &zones, stop };
        let Some(placements) = run.layout(number, first, &mut evaluations) else { break };
        let found = solution(instance, &shapes, &zones, placements, evaluations);
        let height_mm = found.height_mm;
        let complete = found.unplaced.is_empty();
        if best.as_ref().is_none_or(|best| is_better(&found, best)) {
            listener.improved(&found, evaluations);
            best = Some(found);
        }
        if stop.spent(evaluations) >= 1.0 || converged(config, number + 1, complete.then_some(height_mm), previous_mm) {
            break;
        }
        previous_mm = complete.then_some(height_mm);
    }
    best.unwrap_or_else(|| solution(instance, &shapes, &zones, Vec::new(), evaluations))
}

/// Steps 1 and 6 of section 2.3.1; the computation time is the caller's `Stop`.
fn converged(config: &Config, layouts: u64, height_mm: Option<f64>, previous_mm: Option<f64>) -> bool {
    let paper = &config.paper;
    if paper.max_layouts > 0 && layouts >= paper.max_layouts {
        return true;
    }
    let Some(height_mm) = height_mm else { return false };
    // Equation (10).
    let error = previous_mm.map(|previous_mm| (height_mm - previous_mm).abs() / height_mm);
    height_mm <= paper.target_height_mm
        || paper.relative_height_error > 0.0 && error.is_some_and(|e| e <= paper.relative_height_error)
}

/// More copies first, then the lower height (step 5).
fn is_better(one: &Solution, two: &Solution) -> bool {
    let (placed1, placed2) = (one.placements.len(), two.placements.len());
    placed1 > placed2 || placed1 == placed2 && one.height_mm < two.height_mm
}

/// All copies by the area of their boxes, the largest first (step 3).
fn sequence(instance: &Instance, shapes: &[Shape]) -> Vec<(usize, u32)> {
    let copies = instance.items().iter().enumerate().flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)));
    let pins = instance.reserved().pins();
    let mut sequence: Vec<(usize, u32)> = copies.filter(|copy| !pins.contains(copy)).collect();
    sequence.sort_by(|a, b| shapes[b.0].print_area_mm2.total_cmp(&shapes[a.0].print_area_mm2));
    sequence
}

/// What stays the same from layout to layout.
struct Run<'a> {
    instance: &'a Instance,
    config: &'a Config,
    shapes: &'a [Shape],
    sequence: &'a [(usize, u32)],
    zones: &'a Zones,
    stop: &'a dyn Stop,
}

impl Run<'_> {
    /// One layout (steps 4 and 5); `None` when the budget ended on the way and there is an earlier one.
    fn layout(&self, number: u64, first: bool, evaluations: &mut u64) -> Option<Vec<Placement>> {
        let mut layout = Layout::new(self.instance, self.shapes, self.zones);
        layout.pin(self.instance.pinned());
        let start = self.stop.spent(*evaluations);
        for (index, &(item, copy)) in self.sequence.iter().enumerate() {
            let done = (index + 1) as f64 / self.sequence.len() as f64;
            let until = if first { start + (FIRST_LAYOUT_SHARE - start).max(0.0) * done } else { 1.0 };
            if !first && self.stop.spent(*evaluations) >= 1.0 {
                return None;
            }
            if index == 0 && layout.place_in_corner(item, copy) {
                continue;
            }
            let pace = Pace { stop: self.stop, until };
            let seed = seed(self.config.seed, number, index as u64);
            layout.place((item, copy), &self.config.paper, &pace, seed, evaluations);
        }
        Some(layout.placements())
    }
}

/// A seed of its own for every part of every layout (the mixing step of SplitMix64).
fn seed(seed: u64, layout: u64, part: u64) -> u64 {
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    mix(mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ layout).wrapping_add(part))
}

/// Freezes a layout after proving it on its triangles: a placement that breaks a rule is left out.
fn solution(
    instance: &Instance,
    shapes: &[Shape],
    zones: &Zones,
    placements: Vec<Placement>,
    evaluations: u64,
) -> Solution {
    let mut kept: Vec<(Placement, Bounds)> = Vec::with_capacity(placements.len());
    for placement in placements {
        let bounds = shapes[placement.item].surface.bounds_at(&placement.pose);
        let inside = Bounds { min: glam::DVec3::ZERO, max: instance.volume().size_mm }.holds(&bounds, -WALL_SLACK_MM);
        if inside
            && !zones.meet(&shapes[placement.item].surface, &placement.pose, &bounds)
            && super::rotation_obeys(&instance.items()[placement.item].orientation, &placement.pose)
            && kept.iter().all(|(other, near)| keeps_clear(instance, shapes, (&placement, &bounds), (other, near)))
        {
            kept.push((placement, bounds));
        }
    }
    let unplaced = (instance.items().iter().enumerate())
        .flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)))
        .filter(|&(item, copy)| !kept.iter().any(|(p, _)| p.item == item && p.copy == copy));
    Solution {
        unplaced: unplaced.collect(),
        height_mm: kept.iter().map(|(_, bounds)| bounds.max.z).fold(0.0, f64::max),
        placements: kept.into_iter().map(|(placement, _)| placement).collect(),
        evaluations,
    }
}

#[cfg(test)]
mod tests;
