//! The entry point of the search: `NestingInstance` -> `NestingSolution`.

use std::sync::Arc;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    DescentPace, ItemPlacement, LaneTask, NestingConfig, NestingInstance, NestingMethod, NestingSolution,
    PreparedMeshes, ProgressListener, StopCondition,
    box_stacker::BoxStacker,
    insert::{are_few, missing_copies},
    interlock_check::split_separable,
    layout_builder::LayoutBuilder,
    nesting_run::{COARSE_NODES, COARSE_POINTS, NestingRun},
    outline::OutlinedInstance,
    precedence::InsertionEffort,
    prepared_instance::{PlacedItem, PreparedInstance, height_mm, solution_from_items},
    recipe::PlacementRecipe,
    retained::retained_items,
    tie_break::{is_better_layout, pack_toward_origin},
    truncate_queue::exceeds_capacity,
};
#[cfg(feature = "paper")]
use crate::paper::nest_paper;
use crate::pollination::{FlowerPollination, PollinationSettings};

/// Nests an instance. `start` is an earlier layout to continue from, of the same instance or of a part of it; missing
/// copies are inserted. The returned layout is always valid: every placement is inside the volume and keeps its
/// clearance, checked on the triangles. Copies that could not be placed are in `unplaced`. Nesting cannot fail,
/// because an instance is checked when it is constructed.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, SearchBudget, NestingSolution, nest, prove_layout};
///
/// let clip = Arc::new(sample_parts::clip(22.0, 2.4, 14.0));
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
/// # Ok::<(), nester::InstanceError>(())
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

/// Share of the budget for the first layouts, after the very first one,
const START_SHARE: f64 = 0.1;
/// and the share that recipes may use. The rest is for the best recipe in finer voxels.
const RECIPE_SHARE: f64 = 0.04;
/// How much finer these voxels are, at least and at most.
const FINER_VOXELS: (f64, f64) = (1.15, 2.0);
/// The power of the fineness with which the cost of a first layout grows: 2.3 measured, and a margin.
const FINENESS_COST: f64 = 2.5;
/// Share of the budget for improving the tie-break criteria after the height search.
const TIE_BREAK_SHARE: f64 = 0.02;
/// Share of the budget after which a search that cannot place all copies only decides which of them are in.
const PRECEDENCE_FROM: f64 = 0.85;
/// Number of first layouts that are kept as starting points.
const MAX_FIRST_LAYOUTS: usize = 8;
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

/// The order that gave the lowest first layout so far.
struct BuiltOrder {
    recipe: PlacementRecipe,
    order: Vec<(usize, u32)>,
    height_mm: f64,
}

impl BuiltOrder {
    /// Keeps the recipe and the order of a layout of all copies if it is lower than the best before.
    fn keep_lower(
        best: &mut Option<Self>,
        task: &PreparedInstance,
        (recipe, order): (PlacementRecipe, Vec<(usize, u32)>),
        pieces: &[PlacedItem],
    ) {
        let height_mm = height_mm(pieces);
        if pieces.len() == task.copies.len() && best.as_ref().is_none_or(|best| height_mm < best.height_mm) {
            *best = Some(Self { recipe, order, height_mm });
        }
    }
}

/// How much finer voxels may be for a first layout within the share `left` of the budget, when one in the usual voxels takes
/// the share `cost`; `None` when that is too little to be worth a layout.
pub(super) fn finer_voxels(left: f64, cost: f64) -> Option<f64> {
    let factor = (left.max(0.0) / cost.max(1e-9)).powf(1.0 / FINENESS_COST);
    (factor >= FINER_VOXELS.0).then_some(factor.min(FINER_VOXELS.1))
}

impl NestingRun<'_> {
    fn run(mut self, start: &[ItemPlacement]) -> NestingSolution {
        self.search_layout(start);
        solution_from_items(self.instance, &self.best_items, self.evaluations)
    }

    /// Searches for the best layout. Returns the prepared instance, unless the budget ended before it was prepared.
    pub(super) fn search_layout(&mut self, start: &[ItemPlacement]) -> Option<PreparedInstance> {
        let task = self.begin_search(start, 1.0)?;
        let is_overfull = self.best_items.len() < task.copies.len();
        self.compress_layouts(&task, if is_overfull { PRECEDENCE_FROM } else { 1.0 - TIE_BREAK_SHARE });
        self.finish_layout(&task);
        Some(task)
    }

    /// Runs a round of a lane: everything but what comes after the height. In the first round, builds what first layouts
    /// are wanted; later, the copies that are in stay in, and no other copy is inserted. Returns the pace to go on with.
    pub(super) fn search_lane_round(&mut self, lane_task: &LaneTask) -> DescentPace {
        let mut shares = lane_task.round_shares();
        let task = if lane_task.round == 0 {
            let task = self.begin_search(&lane_task.start, shares.until);
            shares.begun = self.stop.spent_share_at(self.evaluations);
            task
        } else {
            self.prepare_instance(Arc::new(self.outline_instance())).map(|task| {
                self.offer_layout(retained_items(&task, self.instance, &lane_task.start));
                self.with_finer_proxies(task, 0.0)
            })
        };
        task.map_or(lane_task.pace, |task| self.compress_in_lane(&task, lane_task, shares))
    }

    /// What comes after the last round of all lanes.
    pub(super) fn finish_search(&mut self, start: &[ItemPlacement]) {
        let Some(task) = self.prepare_instance(Arc::new(self.outline_instance())) else { return };
        self.offer_layout(retained_items(&task, self.instance, start));
        self.finish_layout(&task);
    }

    /// Prepares the instance and builds first layouts. If they do not place all copies, decides which ones are in, within
    /// the share `until` of the budget.
    fn begin_search(&mut self, start: &[ItemPlacement], until: f64) -> Option<PreparedInstance> {
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
        if self.best_items.len() < task.copies.len() {
            // Copies that did not fit may fit after the others are packed more closely.
            self.compress_layouts(&task, 0.6 * until);
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
        let wanted = self.config.components.fine_proxies && !self.best_items.is_empty();
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

    /// Offers a first layout, and keeps it as a starting point unless a first layout of the same height exists.
    pub(super) fn offer_first_layout(&mut self, pieces: Vec<PlacedItem>) {
        let height = height_mm(&pieces);
        if self.first_layouts.iter().all(|known| height_mm(known) != height) {
            let at = self.first_layouts.partition_point(|known| height_mm(known) <= height);
            self.first_layouts.insert(at, pieces.clone());
            self.first_layouts.truncate(MAX_FIRST_LAYOUTS);
        }
        self.offer_layout(pieces);
    }

    /// Builds the first layouts: retained placements, stacked boxes, and voxel placement with several recipes.
    pub(super) fn build_first_layouts(&mut self, task: &PreparedInstance, start: &[ItemPlacement]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let standing = retained_items(task, self.instance, start);
        let missing = missing_copies(task, &standing);
        if !standing.is_empty() {
            self.offer_layout(BoxStacker::new(&task.outlined).stack_copies(&standing, &missing));
        }
        if missing.is_empty() {
            return;
        }
        if are_few(&missing, &standing) {
            self.insert_missing(task, &standing, &missing);
            if self.best_items.len() == standing.len() + missing.len() {
                return;
            }
        }
        if exceeds_capacity(self.instance, &missing) {
            return self.place_by_precedence(task, &mut LayoutBuilder::new(task), &standing, &missing);
        }
        let mut builder = LayoutBuilder::new(task);
        let begun = self.stop.spent_share_at(self.evaluations);
        let (mut cost, mut best) = (0.0, None);
        for (at, recipe) in PlacementRecipe::FIRST.iter().enumerate() {
            let order = recipe.sort_copies(&task.outlined, &missing, &mut rng);
            let limit = if at == 0 { 1.0 } else { START_SHARE };
            if let Some(pieces) = self.build_layout(&mut builder, recipe, &order, &standing, limit) {
                BuiltOrder::keep_lower(&mut best, task, (*recipe, order), &pieces);
                self.offer_first_layout(pieces);
            }
            if at == 0 {
                cost = self.stop.spent_share_at(self.evaluations) - begun;
            }
            if self.stop.spent_share_at(self.evaluations) + cost > RECIPE_SHARE {
                break;
            }
        }
        self.vary_recipes(task, &mut builder, &standing, &missing, (&mut best, cost));
        self.build_finer(task, &standing, best, cost);
        if self.best_items.len() < task.copies.len() {
            self.place_by_precedence(task, &mut builder, &standing, &missing);
        }
    }

    /// Tries more recipes, chosen by flower pollination: order, weight of the part's height, direction of the pull,
    /// and random variation.
    fn vary_recipes(
        &mut self,
        task: &PreparedInstance,
        builder: &mut LayoutBuilder<'_>,
        standing: &[PlacedItem],
        missing: &[(usize, u32)],
        (best, cost): (&mut Option<BuiltOrder>, f64),
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let setup = PollinationSettings {
            population: 8,
            even: !self.config.components.flowers_in_start,
            ..PollinationSettings::default()
        };
        let mut flowers: FlowerPollination<f64> =
            FlowerPollination::new(setup, PlacementRecipe::gene_ranges(), self.config.seed);
        for _ in 0..24 {
            if self.stop.spent_share_at(self.evaluations) + cost > RECIPE_SHARE {
                return;
            }
            let recipe = PlacementRecipe::from_genes(flowers.ask());
            let order = recipe.sort_copies(&task.outlined, missing, &mut rng);
            let built = self.build_layout(builder, &recipe, &order, standing, START_SHARE);
            let whole = built.filter(|pieces| pieces.len() == task.copies.len());
            flowers.tell(whole.as_ref().map_or(f64::INFINITY, |pieces| height_mm(pieces)));
            if let Some(pieces) = whole {
                BuiltOrder::keep_lower(best, task, (recipe, order), &pieces);
                self.offer_first_layout(pieces);
            }
        }
    }

    /// Builds the best order once more, in voxels as fine as what is left of [`START_SHARE`] allows; a layout in the usual
    /// ones took the share `cost`.
    fn build_finer(&mut self, task: &PreparedInstance, standing: &[PlacedItem], best: Option<BuiltOrder>, cost: f64) {
        let left = START_SHARE - self.stop.spent_share_at(self.evaluations);
        let (Some(BuiltOrder { recipe, order, .. }), Some(factor)) = (best, finer_voxels(left, cost)) else { return };
        let mut builder = LayoutBuilder::finer_by(task, factor);
        if let Some(pieces) = self.build_layout(&mut builder, &recipe, &order, standing, START_SHARE) {
            self.offer_first_layout(pieces);
        }
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
        if let Some(pieces) = self.build_layout(&mut builder, &PlacementRecipe::FIRST[0], &missing, &standing, 0.9) {
            self.offer_layout(pieces);
        }
    }
}
