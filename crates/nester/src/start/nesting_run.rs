//! One run of our own search: its input, the best layout so far, and the evaluations made.

use std::{cell::OnceCell, cmp::Reverse, collections::BTreeSet, sync::Arc};

use super::layout_builder::LayoutBuilder;
use crate::{
    InterlockRule, NestingConfig, NestingInstance, PreparedMeshes, ProgressListener, StopCondition, lower_bound_mm,
    prepare::{
        preparation::MeshPreparation,
        prepared_instance::{PlacedItem, PreparedInstance, height_mm, solution_from_items},
    },
    problem::solution::BOUND_TOLERANCE_MM,
    shapes::outline::OutlinedInstance,
};

/// Share of the budget after which no more meshes are prepared; boxes are stacked instead. It is more than the whole
/// budget, so that a layout to continue from is not given up while its meshes are nearly prepared.
const PREPARING_SHARE: f64 = 2.0;
/// Steps of a layout builder that cost about as much CPU time as one evaluation of a descent: 2,900 to 7,400 on the
/// workloads of the benchmark, from fans to organic shapes.
const STEPS_PER_EVALUATION: u64 = 4096;
/// Nodes of a distance grid for the first layouts.
pub(crate) const COARSE_NODES: usize = 30_000;
/// Surface points for the first layouts.
pub(crate) const COARSE_POINTS: usize = 400;
/// Greatest ratio of a first layout's height to the lowest one at which it is kept.
pub(crate) const MAX_HEIGHT_RATIO: f64 = 1.15;

/// The better layout is less: it places more copies, or is lower.
pub(super) fn rank(pieces: &[PlacedItem]) -> (Reverse<usize>, f64) {
    (Reverse(pieces.len()), height_mm(pieces))
}

/// One run of our own search.
pub(crate) struct NestingRun<'a> {
    pub(crate) instance: &'a NestingInstance,
    pub(crate) config: &'a NestingConfig,
    pub(crate) preparation: MeshPreparation<'a>,
    pub(crate) stop: &'a dyn StopCondition,
    listener: &'a mut dyn ProgressListener,
    pub(crate) best_items: Vec<PlacedItem>,
    /// First layouts, the lowest first.
    pub(crate) first_layouts: Vec<Vec<PlacedItem>>,
    /// A first layout around dominating parts that were lowered alone.
    pub(crate) around_dominating: Option<Vec<PlacedItem>>,
    /// Where the descents of the last round ended.
    pub(crate) other_ends: Vec<Vec<PlacedItem>>,
    /// Layouts for which no room was found by insertion, by hash.
    pub(super) failed_insertions: BTreeSet<u64>,
    pub(crate) evaluations: u64,
    /// The lower bound, once it was asked for.
    bound_mm: OnceCell<f64>,
}

impl<'a> NestingRun<'a> {
    pub(crate) fn new(
        instance: &'a NestingInstance,
        config: &'a NestingConfig,
        prepared: &'a PreparedMeshes,
        stop: &'a dyn StopCondition,
        listener: &'a mut dyn ProgressListener,
    ) -> Self {
        let mut preparation = MeshPreparation::new(prepared, config.thread_count());
        if instance.pinned().is_empty() {
            preparation = preparation.with_deadline(stop, PREPARING_SHARE);
        }
        Self {
            instance,
            config,
            preparation,
            stop,
            listener,
            best_items: Vec::new(),
            first_layouts: Vec::new(),
            around_dominating: None,
            other_ends: Vec::new(),
            failed_insertions: BTreeSet::new(),
            evaluations: 0,
            bound_mm: OnceCell::new(),
        }
    }

    /// Prepares the outlines of all items.
    pub(crate) fn outline_instance(&self) -> OutlinedInstance {
        OutlinedInstance::new(self.instance, |meshes| self.preparation.prepare_outlines(meshes))
    }

    /// Prepares the instance coarsely; `None` when the time runs out first.
    pub(crate) fn prepare_instance(&self, outlined: Arc<OutlinedInstance>) -> Option<PreparedInstance> {
        let pins = self.instance.reserved_space().pinned_copies();
        let (components, preparation) = (self.config.components, &self.preparation);
        let mut task = PreparedInstance::new(outlined, pins, preparation, components, COARSE_NODES, COARSE_POINTS)?;
        task.must_be_separable = self.config.effective_interlock() == InterlockRule::Forbid;
        Some(task)
    }

    /// A height that no layout can beat, mm.
    pub(crate) fn floor_mm(&self, task: &PreparedInstance) -> f64 {
        let promised_mm = self.best_items.iter().filter(|p| task.is_fixed((p.item, p.copy))).map(|p| p.bounds.max.z);
        let bound_mm = *self.bound_mm.get_or_init(|| lower_bound_mm(self.instance));
        promised_mm.fold(bound_mm, f64::max).min(height_mm(&self.best_items))
    }

    /// Whether the best layout has all copies, and no lower one exists.
    pub(crate) fn is_lowest(&self, task: &PreparedInstance) -> bool {
        self.best_items.len() == task.copies.len()
            && height_mm(&self.best_items) <= self.floor_mm(task) + BOUND_TOLERANCE_MM
    }

    /// Accepts a layout if it places more copies or is lower, and reports it to the listener.
    pub(crate) fn offer_layout(&mut self, pieces: Vec<PlacedItem>) {
        if !pieces.is_empty() && rank(&pieces) < rank(&self.best_items) {
            self.best_items = pieces;
            self.listener
                .on_improved(&solution_from_items(self.instance, &self.best_items, self.evaluations), self.evaluations);
        }
    }

    /// Runs a builder, until a share of the budget at most, and counts its work. `build` is given what tells it to end.
    pub(crate) fn run_builder<'t, T>(
        &mut self,
        builder: &mut LayoutBuilder<'t>,
        until: f64,
        build: impl FnOnce(&mut LayoutBuilder<'t>, &mut dyn FnMut(u64) -> bool) -> T,
    ) -> T {
        let (stop, before) = (self.stop, self.evaluations);
        let built = build(builder, &mut |steps| stop.spent_share_at(before + steps / STEPS_PER_EVALUATION) >= until);
        self.count_steps(builder);
        built
    }

    /// Counts the work of a builder as evaluations.
    pub(super) fn count_steps(&mut self, builder: &mut LayoutBuilder<'_>) {
        self.evaluations += builder.steps / STEPS_PER_EVALUATION;
        builder.steps %= STEPS_PER_EVALUATION;
    }
}
