//! The door: Instance -> Solution.

use std::sync::{Arc, mpsc};

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    Config, Instance, Listener, Method, Placement, PreparedMeshes, Solution, Stop,
    boxes::Boxes,
    construct::Builder,
    contest::contest,
    course::{COARSE_NODES, COARSE_POINTS, Course, WORTH_KEEPING},
    cut::is_hopeless,
    insert::{are_few, lacking},
    interlock::parted,
    lower_bound_mm,
    outline::Lineup,
    piece::{Piece, Task, height_mm, solution},
    recipe::Recipe,
    settle::{is_better, settle},
    standing::standing,
};
#[cfg(feature = "paper")]
use crate::paper::nest_paper;
use crate::pollination::{Pollination, Setup};

/// Nests. `start` is an earlier layout of (part of) the same instance to go on from; copies that it lacks are inserted.
/// Always returns a layout in which every placement is inside the volume and keeps its clearance on the triangles;
/// copies that found no place are in `unplaced`. There are no errors: an instance that was made can be nested.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, Config, Instance, Item, SearchBudget, Solution, nest, prove_layout};
///
/// let clip = Arc::new(sample_parts::clip(22.0, 2.4, 14.0));
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) };
/// let instance = Instance::new(volume, 1.5, vec![Item::new("clip", clip, 6)])?;
/// let budget = SearchBudget::of_evaluations(1500);
///
/// let mut heights_mm = Vec::new();
/// let mut listener = |better: &Solution, _evaluations: u64| heights_mm.push(better.height_mm);
/// let solution = nest(&instance, &Config::default(), &[], &budget, &mut listener);
///
/// assert!(solution.unplaced.is_empty() && prove_layout(&instance, &solution.placements).is_proved());
/// assert_eq!(heights_mm.last(), Some(&solution.height_mm));
///
/// // The same seed, threads and evaluations: the same placements.
/// let again = nest(&instance, &Config::default(), &[], &SearchBudget::of_evaluations(1500), &mut ());
/// assert_eq!(again.placements, solution.placements);
/// # Ok::<(), nester::InstanceError>(())
/// ```
pub fn nest(
    instance: &Instance,
    config: &Config,
    start: &[Placement],
    stop: &dyn Stop,
    listener: &mut dyn Listener,
) -> Solution {
    nest_with(instance, config, start, &PreparedMeshes::default(), stop, listener)
}

/// The same, with meshes that were prepared for an earlier search: see [`PreparedMeshes`]. What comes out does not depend on it.
pub fn nest_with(
    instance: &Instance,
    config: &Config,
    start: &[Placement],
    prepared: &PreparedMeshes,
    stop: &dyn Stop,
    listener: &mut dyn Listener,
) -> Solution {
    match config.method {
        #[cfg(feature = "paper")]
        Method::Paper => nest_paper(instance, config, stop, listener),
        Method::Nestd => Course::new(instance, config, prepared, stop, listener).run(start),
    }
}

/// Share of the budget for first layouts, after the first one.
const START_SHARE: f64 = 0.1;
/// Share of the budget for what comes after the height.
const SETTLE_SHARE: f64 = 0.02;
/// First layouts that are kept as places to begin from.
const MOST_STARTS: usize = 8;
/// From here on, boxes are stacked in one order only.
const MANY: usize = 300;
/// Nodes of all distance grids together, about: two bytes each.
const MOST_NODES: usize = 12_000_000;
/// Nodes of a finer distance grid. Few different ones, so that what is kept of a mesh serves again.
const FINER_NODES: [usize; 6] = [60_000, 75_000, 100_000, 150_000, 200_000, 300_000];
/// Share of the budget for finer guides.
const FINER_SHARE: f64 = 0.12;
/// Meshes of finer guides between two looks at the budget.
const FINER_AT_ONCE: usize = 8;

impl Course<'_> {
    fn run(mut self, start: &[Placement]) -> Solution {
        let lineup = Arc::new(self.lineup());
        if start.is_empty() && self.instance.pinned().is_empty() {
            self.stack_boxes(&lineup);
            if self.stop.spent(0) >= 1.0 {
                return solution(self.instance, &self.best, self.evaluations);
            }
        }
        let begun = self.stop.spent(0);
        let Some(task) = self.task(lineup.clone()) else {
            // What stands already cannot be judged without the meshes: boxes need none.
            if self.best.is_empty() {
                self.stack_boxes(&lineup);
            }
            return solution(self.instance, &self.best, self.evaluations);
        };
        let prepared = self.stop.spent(0) - begun;
        self.construct(&task, start);
        let task = self.refined(task, prepared);
        if self.best.len() < task.copies.len() {
            // What was too much may fit when the rest stands closer.
            self.search(&task, 0.6);
            self.insert_lacking(&task);
        }
        self.search(&task, 1.0 - SETTLE_SHARE);
        self.settle_down(&task);
        solution(self.instance, &self.best, self.evaluations)
    }

    /// Boxes on boxes, by several orders; where they do not all fit, in order of precedence.
    fn stack_boxes(&mut self, lineup: &Lineup) {
        let mut boxes = Boxes::new(lineup);
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let orders = if lineup.copies.len() > MANY { 1 } else { Recipe::FIRST.len() };
        for recipe in &Recipe::FIRST[..orders] {
            let order = recipe.sorted(lineup, &lineup.copies, &mut rng);
            let pieces = boxes.stack(&[], &order);
            if pieces.len() < lineup.copies.len() {
                return self.offer(boxes.stack(&[], &lineup.copies));
            }
            self.offer(pieces);
        }
    }

    /// The task with finer guides, as fine as an eighth of the budget allows (the first preparation took `prepared`).
    fn refined(&self, mut task: Task, prepared: f64) -> Task {
        let finer = (FINER_SHARE / prepared.max(1e-6)) as usize * COARSE_NODES;
        let distinct = task.kinds.iter().flatten().count().max(1);
        let most = finer.min((MOST_NODES / distinct).clamp(50_000, 300_000));
        let nodes = FINER_NODES.into_iter().rev().find(|&nodes| nodes <= most);
        let wanted = self.config.organs.fine_guides && !self.best.is_empty();
        let Some(nodes) = nodes.filter(|_| wanted) else { return task };
        let begun = self.stop.spent(self.evaluations);
        let points = COARSE_POINTS * if nodes > 100_000 { 3 } else { 2 };
        for first in (0..task.kinds.len()).step_by(FINER_AT_ONCE) {
            let last = (first + FINER_AT_ONCE).min(task.kinds.len());
            task.refine(first..last, &self.workshop, nodes, points);
            // What was kept coarse may be cheap and what is fine dear: the rest then stays coarse.
            if self.stop.spent(self.evaluations) > begun + FINER_SHARE {
                break;
            }
        }
        task
    }

    /// Offers a first layout, and keeps it as a place to begin from if it is not offered already.
    fn consider(&mut self, pieces: Vec<Piece>) {
        let height = height_mm(&pieces);
        if self.starts.iter().all(|known| height_mm(known) != height) {
            let at = self.starts.partition_point(|known| height_mm(known) <= height);
            self.starts.insert(at, pieces.clone());
            self.starts.truncate(MOST_STARTS);
        }
        self.offer(pieces);
    }

    /// The first layouts: what stands already, boxes, and bit columns by several recipes.
    fn construct(&mut self, task: &Task, start: &[Placement]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let standing = standing(task, self.instance, start);
        let lacking = lacking(task, &standing);
        if !standing.is_empty() {
            self.offer(Boxes::new(&task.lineup).stack(&standing, &lacking));
        }
        if lacking.is_empty() {
            return;
        }
        if are_few(&lacking, &standing) {
            self.insert_each(task, &standing, &lacking);
            if self.best.len() == standing.len() + lacking.len() {
                return;
            }
        }
        if is_hopeless(self.instance, &lacking) {
            return self.keep_precedence(task, &mut Builder::new(task), &standing, &lacking);
        }
        let mut builder = Builder::new(task);
        for (at, recipe) in Recipe::FIRST.iter().enumerate() {
            let order = recipe.sorted(&task.lineup, &lacking, &mut rng);
            let limit = if at == 0 { 1.0 } else { START_SHARE };
            if let Some(pieces) = self.build(&mut builder, recipe, &order, &standing, limit) {
                self.consider(pieces);
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
        let setup = Setup { population: 8, even: !self.config.organs.flowers_in_start, ..Setup::default() };
        let mut flowers: Pollination<f64> = Pollination::new(setup, Recipe::genes(), self.config.seed);
        for _ in 0..24 {
            if self.stop.spent(self.evaluations) >= START_SHARE {
                return;
            }
            let recipe = Recipe::of_genes(flowers.ask());
            let order = recipe.sorted(&task.lineup, lacking, &mut rng);
            let built = self.build(builder, &recipe, &order, standing, START_SHARE);
            let whole = built.filter(|pieces| pieces.len() == task.copies.len());
            flowers.tell(whole.as_ref().map_or(f64::INFINITY, |pieces| height_mm(pieces)));
            whole.into_iter().for_each(|pieces| self.consider(pieces));
        }
    }

    /// Lowers the lid over what has been found, until a share of the budget is used up.
    fn search(&mut self, task: &Task, until: f64) {
        if self.best.is_empty() || !self.config.organs.separation || self.stop.spent(self.evaluations) >= until {
            return;
        }
        let promised_mm = self.best.iter().filter(|p| task.is_fixed((p.item, p.copy))).map(|p| p.bounds.max.z);
        let floor_mm = promised_mm.fold(lower_bound_mm(self.instance), f64::max).min(height_mm(&self.best));
        let (stop, seed, before, starts) = (self.stop, self.config.seed, self.evaluations, self.places_to_begin());
        let threads = match self.config.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        // Every thread searches for itself with its own seed; the lowest layout wins, the first thread's among equals.
        let spent = |made: u64| stop.spent(before + made * threads as u64) / until;
        let lower = |thread: usize, found: &mut dyn FnMut(Vec<Piece>, u64)| {
            contest(task, &starts, floor_mm, (seed, thread), &spent, found)
        };
        if threads == 1 {
            let made = lower(0, &mut |pieces, made| {
                self.evaluations = before + made;
                self.offer(pieces);
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
                self.offer(pieces);
            }
            handles.into_iter().map(|h| h.join().expect("a search thread does not panic")).collect()
        });
        self.evaluations = before + ends.iter().map(|(_, made)| made).sum::<u64>();
        let lowest = ends.into_iter().filter_map(|(last, _)| last).min_by(|a, b| height_mm(a).total_cmp(&height_mm(b)));
        if let Some(pieces) = lowest.filter(|pieces| pieces.len() == self.best.len()) {
            self.best = pieces;
        }
    }

    /// Layouts to begin the search with: the best, and others of as many copies that are not much higher.
    fn places_to_begin(&self) -> Vec<Vec<Piece>> {
        let height = height_mm(&self.best);
        let is_other = |other: &&Vec<Piece>| {
            let there = height_mm(other);
            other.len() == self.best.len() && there != height && there <= WORTH_KEEPING * height
        };
        std::iter::once(&self.best).chain(self.starts.iter().filter(is_other)).cloned().collect()
    }

    /// What comes after the height: a denser packed box, nearer to the origin, more even layers.
    fn settle_down(&mut self, task: &Task) {
        if self.best.is_empty() || !self.config.organs.settling || self.stop.spent(self.evaluations) >= 1.0 {
            return;
        }
        let (stop, before) = (self.stop, self.evaluations);
        let mut pieces = self.best.clone();
        self.evaluations += settle(task, &mut pieces, |asked| stop.spent(before + asked) >= 1.0);
        let comes_apart = !task.separable || parted(task, pieces.clone()).1.is_empty();
        if comes_apart && is_better(task, &pieces, &self.best) {
            self.best = pieces;
        }
    }

    /// Copies that found no place are tried again around the best layout, in order of precedence.
    fn insert_lacking(&mut self, task: &Task) {
        let standing = self.best.clone();
        let lacking = lacking(task, &standing);
        let mut builder = Builder::new(task);
        if let Some(pieces) = self.build(&mut builder, &Recipe::FIRST[0], &lacking, &standing, 0.9) {
            self.offer(pieces);
        }
    }
}
