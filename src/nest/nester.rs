//! The door: Instance -> Solution.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    Config, Instance, Listener, Method, Placement, Solution, Stop,
    compress::compress,
    construct::{Builder, Recipe, boxes},
    lower_bound_mm,
    paper::nest_paper,
    piece::{Piece, Task, height_mm},
};

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
        let task = Task::new(self.instance, COARSE_NODES, COARSE_POINTS);
        let prepared = self.stop.spent(0);
        self.construct(&task, start);
        let task = self.refined(task, prepared);
        self.search(&task);
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
        Task::new(self.instance, nodes, COARSE_POINTS * if nodes > 100_000 { 3 } else { 2 })
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
        let taken: std::collections::BTreeSet<(usize, u32)> = standing.iter().map(|p| (p.item, p.copy)).collect();
        let lacking: Vec<(usize, u32)> = task.copies.iter().copied().filter(|c| !taken.contains(c)).collect();
        let sorted = Recipe::FIRST[0].sorted(task, &lacking, &mut rng);
        self.offer(task, boxes(task, &sorted, &standing));
        if lacking.is_empty() {
            return;
        }
        let mut builder = Builder::new(task);
        for (at, recipe) in Recipe::FIRST.iter().enumerate() {
            let order = recipe.sorted(task, &lacking, &mut rng);
            let whole = self.best.len() == task.copies.len();
            let worst = if whole { height_mm(&self.best) } else { f64::INFINITY };
            let (stop, before) = (self.stop, self.evaluations);
            let limit = if at == 0 { 1.0 } else { 0.1 };
            let built =
                builder.build(recipe, &order, &standing, worst, |tests| stop.spent(before + tests / 64) >= limit);
            self.evaluations = before + std::mem::take(&mut builder.tests) / 64;
            if let Some(pieces) = built {
                self.offer(task, pieces);
            }
            if self.stop.spent(self.evaluations) >= 0.1 {
                break;
            }
        }
        if self.best.len() < task.copies.len() {
            self.keep_precedence(task, &mut builder, &standing, &lacking);
        }
    }

    /// Lowers the lid over what has been found, until the budget is used up.
    fn search(&mut self, task: &Task) {
        if self.best.is_empty() || self.stop.spent(self.evaluations) >= 1.0 {
            return;
        }
        let floor_mm = lower_bound_mm(self.instance).min(height_mm(&self.best));
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let (stop, before, start) = (self.stop, self.evaluations, self.best.clone());
        let spent = |evaluations: u64| stop.spent(before + evaluations);
        let made = compress(task, &start, floor_mm, &mut rng, &spent, &mut |pieces, evaluations| {
            self.evaluations = before + evaluations;
            self.offer(task, pieces);
        });
        self.evaluations = before + made;
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
        self.best = filled.unwrap_or(chosen);
        self.listener.improved(&task.solution(self.instance, &self.best, self.evaluations), self.evaluations);
    }
}

/// The pieces of an earlier layout that still hold: inside the walls and clear of each other. Others are placed anew.
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
    pieces
}
