//! The entry point of the search: `NestingInstance` -> `NestingSolution`.

use std::sync::Arc;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

#[cfg(feature = "paper")]
use crate::paper::nest_paper;
use crate::{
    ItemPlacement, NestingConfig, NestingInstance, NestingMethod, NestingSolution, PreparedMeshes, ProgressListener,
    StopCondition,
    finish::tie_break::{is_better_layout, pack_toward_origin},
    prepare::prepared_instance::{PreparedInstance, solution_from_items},
    separation::interlock_check::split_separable,
    shapes::outline::OutlinedInstance,
    start::{
        box_stacker::BoxStacker,
        insert::missing_copies,
        layout_builder::LayoutBuilder,
        nesting_run::{COARSE_NODES, COARSE_POINTS, NestingRun},
        precedence::InsertionEffort,
        recipe::PlacementRecipe,
    },
};

/// Nests an instance. `start` is an earlier layout to continue from, of the same instance or of a part of it; missing
/// copies are inserted. The returned layout is always valid: every placement is inside the volume and keeps its
/// clearance, checked on the triangles. Copies that could not be placed are in `unplaced`. Nesting cannot fail,
/// because an instance is checked when it is constructed.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, SearchBudget, NestingSolution, nest, prove_layout};
/// use solids::Mesh;
///
/// let clip = Arc::new(Mesh::tube(22.0, 17.0, 14.0)?);
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) };
/// let instance = NestingInstance::new(volume, 1.5, vec![NestingItem::new("clip", clip, 6)])?;
/// let budget = SearchBudget::of_evaluations(1500);
///
/// let mut heights_mm = Vec::new();
/// let mut listener = |better: &NestingSolution, _evaluations: u64| heights_mm.push(better.height_mm);
/// let solution = nest(&instance, &NestingConfig::default(), &[], &budget, &mut listener);
///
/// assert!(solution.unplaced.is_empty() && prove_layout(&instance, &solution.placements).is_proved());
/// assert_eq!(heights_mm.last(), Some(&solution.height_mm));
///
/// // The same seed, lanes and evaluations: the same placements.
/// let again = nest(&instance, &NestingConfig::default(), &[], &SearchBudget::of_evaluations(1500), &mut ());
/// assert_eq!(again.placements, solution.placements);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn nest(
    instance: &NestingInstance,
    config: &NestingConfig,
    start: &[ItemPlacement],
    stop: &dyn StopCondition,
    listener: &mut dyn ProgressListener,
) -> NestingSolution {
    nest_with_cache(instance, config, start, &PreparedMeshes::default(), stop, listener)
}

/// Like [`nest`], but reuses meshes prepared for an earlier search: see [`PreparedMeshes`]. If the search is limited
/// by evaluations, `prepared` does not change the result.
pub fn nest_with_cache(
    instance: &NestingInstance,
    config: &NestingConfig,
    start: &[ItemPlacement],
    prepared: &PreparedMeshes,
    stop: &dyn StopCondition,
    listener: &mut dyn ProgressListener,
) -> NestingSolution {
    match config.method {
        #[cfg(feature = "paper")]
        NestingMethod::Paper => nest_paper(instance, config, stop, listener),
        NestingMethod::Nestd => NestingRun::new(instance, config, prepared, stop, listener).run(start),
    }
}

/// Share of the budget for improving the tie-break criteria after the height search.
const TIE_BREAK_SHARE: f64 = 0.02;
/// Share of the budget after which a search that cannot place all copies only decides which of them are in.
const PRECEDENCE_FROM: f64 = 0.85;
/// Share of the budget for packing more closely what is in, where first layouts do not place all copies.
const OVERFULL_SHARE: f64 = 0.6;
/// From this number of copies on, boxes are stacked in one order only.
const MANY_COPIES: usize = 300;
/// Approximate number of nodes of all distance grids together, at two bytes each.
const MAX_TOTAL_NODES: usize = 12_000_000;
/// Node counts of a finer distance grid. There are only a few values, so that cached grids can be reused.
const FINER_NODES: [usize; 6] = [60_000, 75_000, 100_000, 150_000, 200_000, 300_000];
/// Share of the budget for finer collision proxies.
const FINER_SHARE: f64 = 0.12;
/// Number of meshes refined between two checks of the budget.
const FINER_BATCH: usize = 8;

impl NestingRun<'_> {
    fn run(mut self, start: &[ItemPlacement]) -> NestingSolution {
        self.search_layout(start);
        solution_from_items(self.instance, &self.best_items, self.evaluations)
    }

    /// Searches for the best layout. Returns the prepared instance, unless the budget ended before it was prepared.
    pub(crate) fn search_layout(&mut self, start: &[ItemPlacement]) -> Option<PreparedInstance> {
        let task = self.begin_search(start)?;
        let is_overfull = self.best_items.len() < task.copies.len();
        self.compress_layouts(&task, if is_overfull { PRECEDENCE_FROM } else { 1.0 - TIE_BREAK_SHARE });
        self.finish_layout(&task);
        Some(task)
    }

    /// Prepares the instance and builds first layouts. If they do not place all copies, decides which ones are in.
    fn begin_search(&mut self, start: &[ItemPlacement]) -> Option<PreparedInstance> {
        let outlined = Arc::new(self.outline_instance());
        if start.is_empty() && self.instance.pinned().is_empty() {
            self.stack_boxes(&outlined);
            if self.stop.spent_share_at(0) >= 1.0 {
                return None;
            }
        }
        let begun = self.stop.spent_share_at(0);
        let Some(task) = self.prepare_instance(outlined.clone()) else {
            // An existing layout cannot be checked without prepared meshes. Stacking boxes does not need them.
            if self.best_items.is_empty() {
                self.stack_boxes(&outlined);
            }
            return None;
        };
        let prepared = self.stop.spent_share_at(0) - begun;
        self.build_first_layouts(&task, start);
        let task = self.with_finer_proxies(task, prepared);
        if start.is_empty() {
            self.begin_from_dominating(&task);
        }
        if self.best_items.len() < task.copies.len() {
            // Copies that did not fit may fit after the others are packed more closely.
            self.compress_layouts(&task, OVERFULL_SHARE);
            self.retry_unplaced(&task);
        }
        self.enforce_precedence(&task, InsertionEffort::Gap);
        Some(task)
    }

    /// Improves what counts after the height, and the order of precedence.
    pub(super) fn finish_layout(&mut self, task: &PreparedInstance) {
        self.improve_tie_breaks(task);
        // Whatever moved since may have made room.
        self.enforce_precedence(task, InsertionEffort::Rebuild);
    }

    /// Stacks bounding boxes in several orders. If not all copies fit, uses the order of precedence.
    fn stack_boxes(&mut self, outlined: &OutlinedInstance) {
        let mut boxes = BoxStacker::new(outlined);
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let orders = if outlined.copies.len() > MANY_COPIES { 1 } else { PlacementRecipe::FIRST.len() };
        for recipe in &PlacementRecipe::FIRST[..orders] {
            let order = recipe.sort_copies(outlined, &outlined.copies, &mut rng);
            let pieces = boxes.stack_copies(&[], &order);
            if pieces.len() < outlined.copies.len() {
                return self.offer_layout(boxes.stack_copies(&[], &outlined.copies));
            }
            self.offer_layout(pieces);
        }
    }

    /// Returns the task with finer collision proxies, as fine as [`FINER_SHARE`] of the budget allows. The first
    /// preparation took the share `prepared`.
    pub(super) fn with_finer_proxies(&self, mut task: PreparedInstance, prepared: f64) -> PreparedInstance {
        let finer = (FINER_SHARE / prepared.max(1e-6)) as usize * COARSE_NODES;
        let distinct = task.prepared_items.iter().flatten().count().max(1);
        let most = finer.min((MAX_TOTAL_NODES / distinct).clamp(50_000, 300_000));
        let nodes = FINER_NODES.into_iter().rev().find(|&nodes| nodes <= most);
        let wanted = self.config.components.fine_proxies && !self.best_items.is_empty() && !self.is_lowest(&task);
        let Some(nodes) = nodes.filter(|_| wanted) else { return task };
        let begun = self.stop.spent_share_at(self.evaluations);
        let points = COARSE_POINTS * if nodes > 100_000 { 3 } else { 2 };
        for first in (0..task.prepared_items.len()).step_by(FINER_BATCH) {
            let last = (first + FINER_BATCH).min(task.prepared_items.len());
            task.refine_shapes(first..last, &self.preparation, nodes, points);
            // The coarse data may come quickly from the cache, while the fine data is expensive. In that case the
            // remaining meshes stay coarse.
            if self.stop.spent_share_at(self.evaluations) > begun + FINER_SHARE {
                break;
            }
        }
        task
    }

    /// Improves the criteria that count after the height: a denser packed box, a position nearer to the origin, more
    /// even layers.
    fn improve_tie_breaks(&mut self, task: &PreparedInstance) {
        if self.best_items.is_empty()
            || !self.config.components.tie_breaks
            || self.stop.spent_share_at(self.evaluations) >= 1.0
        {
            return;
        }
        let (stop, before) = (self.stop, self.evaluations);
        let mut pieces = self.best_items.clone();
        self.evaluations += pack_toward_origin(task, &mut pieces, |asked| stop.spent_share_at(before + asked) >= 1.0);
        let comes_apart = !task.must_be_separable || split_separable(task, pieces.clone()).1.is_empty();
        if comes_apart && is_better_layout(task, &pieces, &self.best_items) {
            self.best_items = pieces;
        }
    }

    /// Tries to insert the unplaced copies into the best layout, in order of precedence.
    fn retry_unplaced(&mut self, task: &PreparedInstance) {
        let standing = self.best_items.clone();
        let missing = missing_copies(task, &standing);
        let mut builder = LayoutBuilder::new(task);
        let recipe = &PlacementRecipe::FIRST[0];
        let built = self.run_builder(&mut builder, 0.9, |builder, enough| {
            builder.build_separable(recipe, &missing, &standing, enough)
        });
        if let Some(pieces) = built {
            self.offer_layout(pieces);
        }
    }
}
