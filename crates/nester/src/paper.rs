//! The method of "Nesting of 3D irregular shaped objects applied to powder-based additive manufacturing" (Springer, 2021), section
//! 2.3: one part after the other by flower pollination, OBB trees as the collision test.
//!
//! Followed to the letter: OBBs by principal axes; the tree with its mid-axis split, reduction, and expansion by the
//! clearance; the sequence by the area of the box; the initial orientation with the smallest extent upright; the first
//! part in the corner; FPA over position and rotation for each further part; the objective is height first, closeness
//! to the origin second; whole layouts are repeated and the best one is kept; all four convergence conditions.
//!
//! The paper leaves these points open; this implementation does the following:
//! - Population and iterations are settings. If a first layout would not be ready within the budget, each part gets a
//!   share of the budget instead, so that there always is a layout.
//! - "Area" is the largest face of the box; "closeness" is the distance of the far upper corner of the part's bounds.
//! - Starts: two flowers on top of everything and two in the corner, so that a place is always found while there is
//!   room; the others are scattered, half of them in the initial orientation.
//! - Position genes are shares of the range in which the part fits within the walls, so no proposal is lost to the
//!   walls.
//! - An interfering proposal is redrawn a few times; then the flower keeps its place for this turn.
//! - The objective is evaluated before the interference test, which saves that test where a place is no better.
//! - Boxes do not detect a part inside another part's solid: a best place is checked for it. A finished layout is
//!   proved on its triangles before it is reported; an invalid placement would be removed.
//! - A part that cannot be placed is left out of this layout and tried again in the next; layouts with more parts win.

mod clearance_check;
mod layout;
mod shape;
mod zone_obstacles;

use clearance_check::keeps_clearance;
use layout::{PaperLayout, PlacementBudget};
use shape::{PaperShape, prepare_shapes};
use solids::Bounds;
use zone_obstacles::ZoneObstacles;

use super::{ItemPlacement, NestingConfig, NestingInstance, NestingSolution, ProgressListener, StopCondition};

/// Allowed excess of a placement over the walls, mm: within the proof's tolerance and that of fixed copies.
const WALL_SLACK_MM: f64 = 8e-7;
/// The share of the budget that a first layout may take.
const FIRST_LAYOUT_SHARE: f64 = 0.9;

/// Nests by the published method until `stop` or one of its own convergence conditions ends it. Searches with one thread.
pub(crate) fn nest_paper(
    instance: &NestingInstance,
    config: &NestingConfig,
    stop: &dyn StopCondition,
    listener: &mut dyn ProgressListener,
) -> NestingSolution {
    let shapes = prepare_shapes(instance, config.paper.reduce_tree);
    let sequence = placement_sequence(instance, &shapes);
    let zones = ZoneObstacles::new(instance);
    let mut evaluations = 0;
    let mut best: Option<NestingSolution> = None;
    let mut previous_mm: Option<f64> = None;
    for number in 0.. {
        let first = best.is_none();
        let run = PaperSearchRun { instance, config, shapes: &shapes, sequence: &sequence, zones: &zones, stop };
        let Some(placements) = run.build_layout(number, first, &mut evaluations) else { break };
        let found = proved_solution(instance, &shapes, &zones, placements, evaluations);
        let height_mm = found.height_mm;
        let complete = found.unplaced.is_empty();
        if best.as_ref().is_none_or(|best| is_better_solution(&found, best)) {
            listener.on_improved(&found, evaluations);
            best = Some(found);
        }
        if stop.spent_share_at(evaluations) >= 1.0
            || has_converged(config, number + 1, complete.then_some(height_mm), previous_mm)
        {
            break;
        }
        previous_mm = complete.then_some(height_mm);
    }
    best.unwrap_or_else(|| proved_solution(instance, &shapes, &zones, Vec::new(), evaluations))
}

/// Steps 1 and 6 of section 2.3.1; the computation time is limited by the caller's `StopCondition`.
fn has_converged(config: &NestingConfig, layouts: u64, height_mm: Option<f64>, previous_mm: Option<f64>) -> bool {
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
fn is_better_solution(one: &NestingSolution, two: &NestingSolution) -> bool {
    let (placed1, placed2) = (one.placements.len(), two.placements.len());
    placed1 > placed2 || placed1 == placed2 && one.height_mm < two.height_mm
}

/// All copies by the area of their boxes, the largest first (step 3).
fn placement_sequence(instance: &NestingInstance, shapes: &[PaperShape]) -> Vec<(usize, u32)> {
    let copies = instance.items().iter().enumerate().flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)));
    let pins = instance.reserved_space().pinned_copies();
    let mut sequence: Vec<(usize, u32)> = copies.filter(|copy| !pins.contains(copy)).collect();
    sequence.sort_by(|a, b| shapes[b.0].print_area_mm2.total_cmp(&shapes[a.0].print_area_mm2));
    sequence
}

/// The inputs that are the same for every layout.
struct PaperSearchRun<'a> {
    instance: &'a NestingInstance,
    config: &'a NestingConfig,
    shapes: &'a [PaperShape],
    sequence: &'a [(usize, u32)],
    zones: &'a ZoneObstacles,
    stop: &'a dyn StopCondition,
}

impl PaperSearchRun<'_> {
    /// Builds one layout (steps 4 and 5). Returns `None` when the budget ends during the layout and an earlier layout
    /// exists.
    fn build_layout(&self, number: u64, first: bool, evaluations: &mut u64) -> Option<Vec<ItemPlacement>> {
        let mut layout = PaperLayout::new(self.instance, self.shapes, self.zones);
        layout.add_pinned(self.instance.pinned());
        let start = self.stop.spent_share_at(*evaluations);
        for (index, &(item, copy)) in self.sequence.iter().enumerate() {
            let done = (index + 1) as f64 / self.sequence.len() as f64;
            let until = if first { start + (FIRST_LAYOUT_SHARE - start).max(0.0) * done } else { 1.0 };
            if !first && self.stop.spent_share_at(*evaluations) >= 1.0 {
                return None;
            }
            if index == 0 && layout.place_in_corner(item, copy) {
                continue;
            }
            let pace = PlacementBudget { stop: self.stop, until };
            let seed = part_seed(self.config.seed, number, index as u64);
            layout.place_copy((item, copy), &self.config.paper, &pace, seed, evaluations);
        }
        Some(layout.placements())
    }
}

/// A separate seed for every part of every layout (the mixing step of SplitMix64).
fn part_seed(seed: u64, layout: u64, part: u64) -> u64 {
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    mix(mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ layout).wrapping_add(part))
}

/// Proves a layout on its triangles and returns the solution: a placement that breaks a rule is left out.
fn proved_solution(
    instance: &NestingInstance,
    shapes: &[PaperShape],
    zones: &ZoneObstacles,
    placements: Vec<ItemPlacement>,
    evaluations: u64,
) -> NestingSolution {
    let mut kept: Vec<(ItemPlacement, Bounds)> = Vec::with_capacity(placements.len());
    for placement in placements {
        let bounds = shapes[placement.item].surface.bounds_at(&placement.pose);
        let inside =
            Bounds { min: glam::DVec3::ZERO, max: instance.volume().size_mm }.contains_bounds(&bounds, -WALL_SLACK_MM);
        if inside
            && !zones.intersect_part(&shapes[placement.item].surface, &placement.pose, &bounds)
            && super::obeys_orientation(&instance.items()[placement.item].orientation, &placement.pose)
            && kept.iter().all(|(other, near)| keeps_clearance(instance, shapes, (&placement, &bounds), (other, near)))
        {
            kept.push((placement, bounds));
        }
    }
    let unplaced = (instance.items().iter().enumerate())
        .flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)))
        .filter(|&(item, copy)| !kept.iter().any(|(p, _)| p.item == item && p.copy == copy));
    NestingSolution {
        unplaced: unplaced.collect(),
        height_mm: kept.iter().map(|(_, bounds)| bounds.max.z).fold(0.0, f64::max),
        placements: kept.into_iter().map(|(placement, _)| placement).collect(),
        evaluations,
    }
}

#[cfg(test)]
mod tests;
