//! The door: Instance -> Solution.

use std::{collections::BTreeSet, sync::mpsc};

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    Config, Instance, Interlock, Listener, Method, Placement, Solution, Stop,
    compress::compress,
    construct::{Builder, Recipe, boxes},
    interlock::parted,
    lower_bound_mm,
    paper::nest_paper,
    piece::{Piece, Task, height_mm},
};
use crate::pollination::{Pollination, Setup};

/// Nests. `start` is an earlier layout of (part of) the same instance to go on from; copies that it lacks are inserted.
/// Always returns a layout in which every placement is inside the volume and keeps its clearance on the triangles;
/// copies that found no place are in `unplaced`.
pub fn nest(
    instance: &Instance,
    config: &Config,
    start: &[Placement],
    stop: &dyn Stop,
    listener: &mut dyn Listener,
) -> Solution {
    match config.method {
        Method::Paper => nest_paper(instance, config, stop, listener),
        Method::Nestd => Course::new(instance, config, stop, listener).run(start),
    }
}

/// Share of the budget for first layouts, after the first one.
const START_SHARE: f64 = 0.1;
/// Placement tests that cost about as much as one evaluation of the search.
const TESTS_PER_EVALUATION: u64 = 64;
/// Nodes of a distance grid for the first layouts.
const COARSE_NODES: usize = 30_000;
/// Surface points for the first layouts.
const COARSE_POINTS: usize = 400;
/// Nodes of all distance grids together, about: two bytes each.
const MOST_NODES: usize = 12_000_000;

/// One run of our own search.
struct Course<'a> {
    instance: &'a Instance,
    config: &'a Config,
    stop: &'a dyn Stop,
    listener: &'a mut dyn Listener,
    best: Vec<Piece>,
    evaluations: u64,
}

impl<'a> Course<'a> {
    fn new(instance: &'a Instance, config: &'a Config, stop: &'a dyn Stop, listener: &'a mut dyn Listener) -> Self {
        Self { instance, config, stop, listener, best: Vec::new(), evaluations: 0 }
    }

    fn run(mut self, start: &[Placement]) -> Solution {
        let separable = self.config.interlock() == Interlock::Forbid;
        let task = Task { separable, ..Task::new(self.instance, COARSE_NODES, COARSE_POINTS) };
        let prepared = self.stop.spent(0);
        self.construct(&task, start);
        let task = self.refined(task, prepared);
        if self.best.len() < task.copies.len() {
            // What was too much may fit when the rest stands closer.
            self.search(&task, 0.6);
            self.insert_lacking(&task);
        }
        self.search(&task, 1.0);
        task.solution(self.instance, &self.best, self.evaluations)
    }

    /// The task with finer guides, as fine as an eighth of the budget allows (the first preparation took `prepared`).
    fn refined(&self, task: Task, prepared: f64) -> Task {
        let finer = (0.12 / prepared.max(1e-6)) as usize * COARSE_NODES;
        let distinct = task.kinds.iter().flatten().count().max(1);
        let nodes = finer.min((MOST_NODES / distinct).clamp(50_000, 300_000));
        if nodes < 2 * COARSE_NODES || self.best.is_empty() {
            return task;
        }
        let points = COARSE_POINTS * if nodes > 100_000 { 3 } else { 2 };
        Task { separable: task.separable, ..Task::new(self.instance, nodes, points) }
    }

    /// Takes a layout when it places more or is lower, and tells of it.
    fn offer(&mut self, task: &Task, pieces: Vec<Piece>) {
        let rank = |pieces: &[Piece]| (std::cmp::Reverse(pieces.len()), height_mm(pieces));
        if !pieces.is_empty() && rank(&pieces) < rank(&self.best) {
            self.best = pieces;
            self.listener.improved(&task.solution(self.instance, &self.best, self.evaluations), self.evaluations);
        }
    }

    /// The first layouts: what stands already, boxes, and bit columns by several recipes.
    fn construct(&mut self, task: &Task, start: &[Placement]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let standing = standing(task, start);
        let taken: BTreeSet<(usize, u32)> = standing.iter().map(|p| (p.item, p.copy)).collect();
        let lacking: Vec<(usize, u32)> = task.copies.iter().copied().filter(|c| !taken.contains(c)).collect();
        let sorted = Recipe::FIRST[0].sorted(task, &lacking, &mut rng);
        self.offer(task, boxes(task, &sorted, &standing));
        if lacking.is_empty() {
            return;
        }
        let mut builder = Builder::new(task);
        for (at, recipe) in Recipe::FIRST.iter().enumerate() {
            let order = recipe.sorted(task, &lacking, &mut rng);
            let limit = if at == 0 { 1.0 } else { START_SHARE };
            if let Some(pieces) = self.build(&mut builder, recipe, &order, &standing, limit) {
                self.offer(task, pieces);
            }
            if self.stop.spent(self.evaluations) >= START_SHARE {
                break;
            }
        }
        self.vary(task, &mut builder, &standing, &lacking);
        if self.best.len() < task.copies.len() {
            self.keep_precedence(task, &mut builder, &standing, &lacking);
        }
    }

    /// Tries other recipes by flower pollination: order, liking for low tops, pull and disorder.
    fn vary(&mut self, task: &Task, builder: &mut Builder<'_>, standing: &[Piece], lacking: &[(usize, u32)]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let setup = Setup { population: 8, ..Setup::default() };
        let mut flowers: Pollination<f64> = Pollination::new(setup, Recipe::genes(), self.config.seed);
        for _ in 0..24 {
            if self.stop.spent(self.evaluations) >= START_SHARE {
                return;
            }
            let recipe = Recipe::of_genes(flowers.ask());
            let order = recipe.sorted(task, lacking, &mut rng);
            let built = self.build(builder, &recipe, &order, standing, START_SHARE);
            let whole = built.filter(|pieces| pieces.len() == task.copies.len());
            flowers.tell(whole.as_ref().map_or(f64::INFINITY, |pieces| height_mm(pieces)));
            whole.into_iter().for_each(|pieces| self.offer(task, pieces));
        }
    }

    /// One run of the builder, ended when it gets higher than the best complete layout or at a share of the budget.
    fn build(
        &mut self,
        builder: &mut Builder<'_>,
        recipe: &Recipe,
        order: &[(usize, u32)],
        standing: &[Piece],
        limit: f64,
    ) -> Option<Vec<Piece>> {
        let whole = self.best.len() == standing.len() + order.len();
        let worst_mm = if whole { height_mm(&self.best) } else { f64::INFINITY };
        let (stop, before) = (self.stop, self.evaluations);
        let enough = |tests| stop.spent(before + tests / TESTS_PER_EVALUATION) >= limit;
        let built = builder.build(recipe, order, standing, worst_mm, enough);
        self.evaluations += std::mem::take(&mut builder.tests) / TESTS_PER_EVALUATION;
        built
    }

    /// Lowers the lid over what has been found, until a share of the budget is used up.
    fn search(&mut self, task: &Task, until: f64) {
        if self.best.is_empty() || self.stop.spent(self.evaluations) >= until {
            return;
        }
        let floor_mm = lower_bound_mm(self.instance).min(height_mm(&self.best));
        let (stop, seed, before, start) = (self.stop, self.config.seed, self.evaluations, self.best.clone());
        let threads = match self.config.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        // Every thread searches for itself with its own seed; the lowest layout wins, the first thread's among equals.
        let spent = |made: u64| stop.spent(before + made * threads as u64) / until;
        let lower = |thread: usize, found: &mut dyn FnMut(Vec<Piece>, u64)| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_add(thread as u64 * 0x9e37_79b9_7f4a_7c15));
            compress(task, &start, floor_mm, &mut rng, &spent, found)
        };
        if threads == 1 {
            let made = lower(0, &mut |pieces, made| {
                self.evaluations = before + made;
                self.offer(task, pieces);
            });
            self.evaluations = before + made;
            return;
        }
        let (send, found) = mpsc::channel::<(Vec<Piece>, u64)>();
        let run = |thread: usize, send: mpsc::Sender<(Vec<Piece>, u64)>| {
            let mut last = None;
            let made = lower(thread, &mut |pieces, made| {
                last = Some(pieces.clone());
                // The receiver lives as long as the scope: sending cannot fail.
                let _ = send.send((pieces, made));
            });
            (last, made)
        };
        let run = &run;
        let ends: Vec<(Option<Vec<Piece>>, u64)> = std::thread::scope(|scope| {
            let start = |thread: usize, send: mpsc::Sender<_>| scope.spawn(move || run(thread, send));
            let handles: Vec<_> = (0..threads).map(|thread| start(thread, send.clone())).collect();
            drop(send);
            for (pieces, made) in found {
                self.evaluations = before + made * threads as u64;
                self.offer(task, pieces);
            }
            handles.into_iter().map(|h| h.join().expect("a search thread does not panic")).collect()
        });
        self.evaluations = before + ends.iter().map(|(_, made)| made).sum::<u64>();
        let lowest = ends.into_iter().filter_map(|(last, _)| last).min_by(|a, b| height_mm(a).total_cmp(&height_mm(b)));
        if let Some(pieces) = lowest.filter(|pieces| pieces.len() == self.best.len()) {
            self.best = pieces;
        }
    }

    /// Copies that found no place are tried again around the best layout, in order of precedence.
    fn insert_lacking(&mut self, task: &Task) {
        let taken: BTreeSet<(usize, u32)> = self.best.iter().map(|p| (p.item, p.copy)).collect();
        let lacking: Vec<(usize, u32)> = task.copies.iter().copied().filter(|c| !taken.contains(c)).collect();
        let standing = self.best.clone();
        let mut builder = Builder::new(task);
        if let Some(pieces) = self.build(&mut builder, &Recipe::FIRST[0], &lacking, &standing, 0.9) {
            self.offer(task, pieces);
        }
    }

    /// Where not all fit, earlier copies come first: the longest beginning of the line that fits whole, then whoever
    /// still finds a gap.
    fn keep_precedence(
        &mut self,
        task: &Task,
        builder: &mut Builder<'_>,
        standing: &[Piece],
        lacking: &[(usize, u32)],
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let recipe = Recipe::FIRST[0];
        let (mut fits, mut fails) = (0, lacking.len() + 1);
        let mut chosen = standing.to_vec();
        while fails - fits > 1 + lacking.len() / 100 {
            let middle = fits.midpoint(fails);
            let order = recipe.sorted(task, &lacking[..middle], &mut rng);
            let stop = self.stop;
            let built = builder.build(&recipe, &order, standing, f64::INFINITY, |_| stop.spent(0) >= 1.0);
            match built {
                Some(pieces) if pieces.len() == standing.len() + middle => (fits, chosen) = (middle, pieces),
                Some(_) => fails = middle,
                None => break,
            }
        }
        let stop = self.stop;
        let rest = &lacking[fits..];
        let filled = builder.build(&recipe, rest, &chosen, f64::INFINITY, |_| stop.spent(0) >= 1.0);
        let kept = filled.unwrap_or(chosen);
        // Where the budget ended first, a far fuller layout in another order is worth more than a short beginning.
        if 10 * kept.len() < 9 * self.best.len() && self.stop.spent(0) >= 1.0 {
            return;
        }
        self.best = kept;
        self.listener.improved(&task.solution(self.instance, &self.best, self.evaluations), self.evaluations);
    }
}

/// The pieces of an earlier layout that still hold: inside the walls, clear of each other and, where it is asked, not locked
/// into each other. Others are placed anew.
fn standing(task: &Task, start: &[Placement]) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    for placement in start {
        let Some(kind) = task.kinds.get(placement.item).and_then(Option::as_ref) else { continue };
        let place = kind.shape.place(&placement.pose);
        let piece = task.piece((placement.item, placement.copy), placement.pose.rotation, place);
        let known = task.copies.contains(&(placement.item, placement.copy));
        let twice = pieces.iter().any(|p| (p.item, p.copy) == (piece.item, piece.copy));
        if known
            && !twice
            && task.is_inside(&piece, task.room.z)
            && super::rotation_obeys(kind.rule, &piece.pose)
            && pieces.iter().all(|other| task.is_clear(&piece, other))
        {
            pieces.push(piece);
        }
    }
    if task.separable { parted(task, pieces).0 } else { pieces }
}
