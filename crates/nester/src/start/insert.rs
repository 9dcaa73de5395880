//! Inserts a copy into an existing layout: into a gap if there is one; otherwise the parts around the best position
//! make room. The layout is not rebuilt, and parts far from the new copy do not move.

use std::{collections::BTreeSet, sync::Arc};

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    box_stacker::BoxStacker, layout_builder::LayoutBuilder, nesting_run::NestingRun, precedence::InsertionEffort,
    recipe::PlacementRecipe, retained::retained_items,
};
use crate::{
    ItemPlacement, NestingConfig, NestingInstance, NestingSolution, PreparedMeshes, ProgressListener, StopCondition,
    prepare::prepared_instance::{PlacedItem, PreparedInstance, height_mm, solution_from_items},
    separation::{
        interlock_check::split_separable,
        overlap_depth_grid::OverlapDepthGrid,
        relocation::{RelocationEffort, relocate_part},
        separation::{SeparationLimits, SeparationOutcome, separate_parts},
        working_layout::WorkingLayout,
    },
};

/// Number of positions at which the neighbours make room before the copy is placed on top.
const MAX_PLACES: usize = 4;
/// Greatest number of part evaluations for each of those positions.
const MAX_EVALUATIONS_PER_PLACE: u64 = 1500;
/// Search effort for one position.
const EFFORT: RelocationEffort = RelocationEffort { grid_queries: 2000, coarse_checks: 48, separated: 3 };
/// Parts nearer to the copy than this share of its radius make room.
const MAKE_ROOM_SHARE: f64 = 0.5;
/// Overlap per cross section below which the exact test is tried, mm.
const NEAR_OVERLAP_MM: f32 = 0.02;
/// Height differences up to this count as equal, mm.
const SAME_MM: f64 = 1e-6;

/// Inserts the copies that `standing` lacks, each into the lowest gap. If there is no gap, the parts around the best
/// position make room; otherwise the copy is placed on top. Copies that the instance no longer contains are left out,
/// so this also removes copies. A typical copy takes a fraction of a second. `stop` limits the time for making room.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, PreparedMeshes, SearchBudget, insert_copies, nest_with_cache};
/// use solids::Mesh;
///
/// let clip = Arc::new(Mesh::tube(22.0, 17.0, 14.0)?);
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) };
/// let asked = |copies| NestingInstance::new(volume, 1.5, vec![NestingItem::new("clip", clip.clone(), copies)]);
/// let (config, prepared) = (NestingConfig::default(), PreparedMeshes::default());
/// let budget = || SearchBudget::of_evaluations(1000);
///
/// let five = nest_with_cache(&asked(5)?, &config, &[], &prepared, &budget(), &mut ());
/// let seven = insert_copies(&asked(7)?, &config, &five.placements, &prepared, &budget(), &mut ());
/// assert_eq!((five.placements.len(), seven.placements.len()), (5, 7));
///
/// let three = insert_copies(&asked(3)?, &config, &seven.placements, &prepared, &budget(), &mut ());
/// assert_eq!(three.placements, seven.placements[..3]); // nobody moved
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn insert_copies(
    instance: &NestingInstance,
    config: &NestingConfig,
    standing: &[ItemPlacement],
    prepared: &PreparedMeshes,
    stop: &dyn StopCondition,
    listener: &mut dyn ProgressListener,
) -> NestingSolution {
    NestingRun::new(instance, config, prepared, stop, listener).insert_only(standing)
}

impl NestingRun<'_> {
    /// Only inserts the missing copies.
    fn insert_only(mut self, start: &[ItemPlacement]) -> NestingSolution {
        let Some(task) = self.prepare_instance(Arc::new(self.outline_instance())) else {
            return solution_from_items(self.instance, &self.best_items, self.evaluations);
        };
        let standing = retained_items(&task, self.instance, start);
        self.offer_layout(standing.clone());
        self.insert_missing(&task, &standing, &missing_copies(&task, &standing));
        self.enforce_precedence(&task, InsertionEffort::MakeRoom);
        solution_from_items(self.instance, &self.best_items, self.evaluations)
    }

    /// Inserts copies into an existing layout, the largest first, and offers the result.
    pub(super) fn insert_missing(
        &mut self,
        task: &PreparedInstance,
        standing: &[PlacedItem],
        missing: &[(usize, u32)],
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let recipe = PlacementRecipe::FIRST[0];
        let mut builder = LayoutBuilder::new(task);
        let mut stack = builder.start_layout(standing);
        for copy in recipe.sort_copies(&task.outlined, missing, &mut rng) {
            let before_mm = height_mm(&stack.items);
            let placed = builder.place_copy(&recipe, copy, &mut stack);
            let grew = height_mm(&stack.items) > before_mm + SAME_MM && before_mm > 0.0;
            if placed && !grew || self.stop.spent_share_at(self.evaluations) >= 1.0 {
                continue;
            }
            // If the copy did not fit at all, the height limit is that of the machine.
            let height_limit_mm = if placed { before_mm } else { task.room.z };
            let mut pieces = stack.items.clone();
            if !placed {
                pieces.push(task.place_item(
                    copy,
                    task.outlined.outlined_item(copy.0).fitting_rotation,
                    0.5 * task.room,
                ));
            }
            let stop = self.stop;
            let is_over = |evaluations: u64| stop.spent_share_at(evaluations) >= 1.0;
            if let Some(pieces) = self.make_room(task, &pieces, height_limit_mm, &mut rng, &is_over) {
                stack = builder.start_layout(&pieces);
            }
        }
        // Copies that would be locked in are placed on top, from where they can always be lifted.
        let (free, locked) =
            if task.must_be_separable { split_separable(task, stack.items) } else { (stack.items, Vec::new()) };
        let locked: Vec<(usize, u32)> = locked.iter().map(|piece| (piece.item, piece.copy)).collect();
        self.offer_layout(BoxStacker::new(&task.outlined).stack_copies(&free, &locked));
    }

    /// Searches for a position of the last piece below a height limit where the parts around it can make room. Ends
    /// when `is_over` returns true for the evaluations made.
    pub(super) fn make_room(
        &mut self,
        task: &PreparedInstance,
        pieces: &[PlacedItem],
        height_limit_mm: f64,
        rng: &mut ChaCha8Rng,
        is_over: &dyn Fn(u64) -> bool,
    ) -> Option<Vec<PlacedItem>> {
        let mut layout = WorkingLayout::new(task, pieces, height_limit_mm);
        let (poses, proxies) = (layout.poses.clone(), layout.proxies.clone());
        let (promised, last) = (layout.parts.fixed.clone(), pieces.len() - 1);
        let radius = layout.proxies[last].shape.radius_mm as f32;
        let patience =
            SeparationLimits { idle_rounds: 25, failed_checks: 8, near_overlap: NEAR_OVERLAP_MM * radius * radius };
        for _ in 0..MAX_PLACES {
            let before = layout.evaluations;
            layout.parts.fixed.clone_from(&promised);
            layout.restore_parts(&poses, &proxies);
            layout.age_memory();
            let mut grid = OverlapDepthGrid::new(&layout);
            let energy = layout.energy_at(last, &layout.proxies[last], false, f32::INFINITY);
            relocate_part(&mut layout, &mut grid, last, EFFORT, energy, rng);
            let reach = (MAKE_ROOM_SHARE * layout.proxies[last].shape.radius_mm + task.max_clearance_mm) as f32;
            for (part, promised) in promised.iter().enumerate().take(last) {
                let (here, there) = (&layout.proxies[last], &layout.proxies[part]);
                layout.parts.fixed[part] = *promised || !here.is_near(there, reach);
            }
            let made = self.evaluations;
            let over = |looks: u64| looks > before + MAX_EVALUATIONS_PER_PLACE || is_over(made + looks - before);
            let outcome = separate_parts(&mut layout, patience, rng, over);
            self.evaluations += layout.evaluations - before;
            match outcome {
                SeparationOutcome::Clear(pieces) if task.keeps_cap(&pieces) => return Some(pieces),
                _ if is_over(self.evaluations) => return None,
                _ => {}
            }
        }
        None
    }
}

/// Whether the missing copies are few compared to the placed pieces: then they are inserted and nothing is rebuilt.
pub(super) fn are_few(missing: &[(usize, u32)], standing: &[PlacedItem]) -> bool {
    !standing.is_empty() && missing.len() <= 4 + standing.len() / 4
}

/// Copies that are neither placed nor fixed at a pose, in order of precedence.
pub(crate) fn missing_copies(task: &PreparedInstance, standing: &[PlacedItem]) -> Vec<(usize, u32)> {
    let taken: BTreeSet<(usize, u32)> = standing.iter().map(|p| (p.item, p.copy)).collect();
    let is_free = |copy: &&(usize, u32)| !taken.contains(copy) && !task.pinned.contains(copy);
    task.copies.iter().filter(is_free).copied().collect()
}
