//! One run of our own search: what is asked, what has been found and what was spent for it.

use std::sync::Arc;

use super::{
    Config, Instance, Interlock, Listener, PreparedMeshes, Stop,
    construct::Builder,
    outline::Lineup,
    piece::{Piece, Task, height_mm, solution},
    recipe::Recipe,
    workshop::Workshop,
};

/// Share of the budget after which no mesh is prepared any more: boxes on boxes it is then. More than all of it, so that a
/// layout to go on from is not given up for meshes that are nearly prepared.
const PREPARING_SHARE: f64 = 2.0;
/// Placement tests that cost about as much as one evaluation of the search.
pub(super) const TESTS_PER_EVALUATION: u64 = 64;
/// Nodes of a distance grid for the first layouts.
pub(super) const COARSE_NODES: usize = 30_000;
/// Surface points for the first layouts.
pub(super) const COARSE_POINTS: usize = 400;
/// How much higher than the lowest a first layout may be to be worth keeping.
pub(super) const WORTH_KEEPING: f64 = 1.15;

/// One run of our own search.
pub(super) struct Course<'a> {
    pub(super) instance: &'a Instance,
    pub(super) config: &'a Config,
    pub(super) workshop: Workshop<'a>,
    pub(super) stop: &'a dyn Stop,
    listener: &'a mut dyn Listener,
    pub(super) best: Vec<Piece>,
    /// First layouts, the lowest first.
    pub(super) starts: Vec<Vec<Piece>>,
    pub(super) evaluations: u64,
}

impl<'a> Course<'a> {
    pub(super) fn new(
        instance: &'a Instance,
        config: &'a Config,
        prepared: &'a PreparedMeshes,
        stop: &'a dyn Stop,
        listener: &'a mut dyn Listener,
    ) -> Self {
        let mut workshop = Workshop::new(prepared, config.threads);
        if instance.pinned().is_empty() {
            workshop = workshop.until(stop, PREPARING_SHARE);
        }
        Self { instance, config, workshop, stop, listener, best: Vec::new(), starts: Vec::new(), evaluations: 0 }
    }

    /// The items from outside.
    pub(super) fn lineup(&self) -> Lineup {
        Lineup::new(self.instance, |meshes| self.workshop.outlines(meshes))
    }

    /// The instance, prepared coarsely; `None` when the time is over before.
    pub(super) fn task(&self, lineup: Arc<Lineup>) -> Option<Task> {
        let pins = self.instance.reserved().pins();
        let (organs, workshop) = (self.config.organs, &self.workshop);
        let mut task = Task::new(lineup, pins, workshop, organs, COARSE_NODES, COARSE_POINTS)?;
        task.separable = self.config.interlock() == Interlock::Forbid;
        Some(task)
    }

    /// Takes a layout when it places more or is lower, and tells of it.
    pub(super) fn offer(&mut self, pieces: Vec<Piece>) {
        let rank = |pieces: &[Piece]| (std::cmp::Reverse(pieces.len()), height_mm(pieces));
        if !pieces.is_empty() && rank(&pieces) < rank(&self.best) {
            self.best = pieces;
            self.listener.improved(&solution(self.instance, &self.best, self.evaluations), self.evaluations);
        }
    }

    /// One run of the builder, ended when it gets higher than the best complete layout or at a share of the budget.
    pub(super) fn build(
        &mut self,
        builder: &mut Builder<'_>,
        recipe: &Recipe,
        order: &[(usize, u32)],
        standing: &[Piece],
        limit: f64,
    ) -> Option<Vec<Piece>> {
        let whole = self.best.len() == standing.len() + order.len();
        let worst_mm = if whole { WORTH_KEEPING * height_mm(&self.best) } else { f64::INFINITY };
        let (stop, before) = (self.stop, self.evaluations);
        let enough = |tests| stop.spent(before + tests / TESTS_PER_EVALUATION) >= limit;
        let built = builder.build(recipe, order, standing, worst_mm, enough);
        self.evaluations += builder.tests / TESTS_PER_EVALUATION;
        builder.tests %= TESTS_PER_EVALUATION;
        built
    }
}
