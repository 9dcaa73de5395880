//! Compression: repeatedly turns a valid layout into a lower one by lowering a height limit, until the budget is used
//! up.
//!
//! Tried in vain: parts that stand from the floor to the height limit were tipped before they were pushed, by the least angle
//! at which they fit, about one axis or each about its own, and in the last try spread over the base in their order. In 100,000
//! evaluations of one or two seeds, eight frames on edge stayed at 150 mm, and twelve rails ended between 214 and 230 mm (230
//! without). Where one attempt got through, the next ones took 40 evaluations each: the first one is missing, and more
//! attempts, as each takes hundreds of evaluations of every part.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    prepare::prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    problem::solution::BOUND_TOLERANCE_MM,
    separation::{
        relocation::random_pose,
        separation::{SeparationLimits, SeparationOutcome, separate_parts},
        working_layout::{CenterPose, WorkingLayout},
    },
};

/// Number of near-feasible layouts kept from failed height limits.
const POOL_SIZE: usize = 6;
/// Evaluations per part for one height limit, and the increase after each failure.
const LIMIT_EFFORT: (u64, u64) = (120, 60);
/// Greatest number of evaluations per part for one height limit.
const MAX_LIMIT_EFFORT: u64 = 900;
/// Number of times that a nearly reached height limit is raised half of the way back.
const MAX_LIMIT_RAISES: usize = 2;
/// Overlap of all parts, relative to one part's cross section, below which a height limit was nearly reached, mm.
const NEAR_OVERLAP_MM: f64 = 0.3;

/// Builds with at most this number of parts are sometimes restarted from random poses,
const SCATTER_MAX_PARTS: usize = 60;
/// after this number of failures.
const SCATTER_AFTER: u64 = 3;

/// What a descent has learnt about how far the height limit may fall at once. It goes on in the next round of a lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DescentPace {
    /// Relative step of the height limit.
    step: f64,
    /// Height limits that were not reached since the last lower layout.
    pub(crate) failures: u64,
}

impl Default for DescentPace {
    /// The pace at which a descent begins.
    fn default() -> Self {
        Self { step: 0.02, failures: 0 }
    }
}

/// The budget and the target of a compression run.
pub(crate) struct CompressionBudget<'a> {
    /// Share of the budget that is used up after a number of evaluations of this run.
    pub(crate) spent_share_at: &'a dyn Fn(u64) -> f64,
    /// The share at which this run pauses.
    pub(crate) until: f64,
    /// A height that no layout can beat, mm.
    pub(crate) lower_bound_mm: f64,
}

/// A layout whose height limit is lowered step by step. It can be paused and continued.
pub(crate) struct CompressionRun<'t> {
    layout: WorkingLayout<'t>,
    rng: ChaCha8Rng,
    /// The lowest valid layout so far.
    pub(crate) items: Vec<PlacedItem>,
    pub(crate) height_mm: f64,
    best_poses: Vec<CenterPose>,
    /// Overlap and poses of failed height limits, least overlap first.
    pool: Vec<(f32, Vec<CenterPose>)>,
    pub(crate) pace: DescentPace,
    near_overlap: f32,
}

impl<'t> CompressionRun<'t> {
    /// Starts a run from a valid layout.
    pub(crate) fn new(prepared: &'t PreparedInstance, start: &[PlacedItem], rng: ChaCha8Rng) -> Self {
        let height = height_mm(start);
        let layout = WorkingLayout::new(prepared, start, height);
        let section: f64 = layout.proxies.iter().map(|g| g.shape.radius_mm.powi(2)).sum();
        Self {
            best_poses: layout.poses.clone(),
            items: start.to_vec(),
            height_mm: height,
            pool: Vec::new(),
            pace: DescentPace::default(),
            near_overlap: (NEAR_OVERLAP_MM * section / start.len().max(1) as f64) as f32,
            layout,
            rng,
        }
    }

    /// Evaluations made.
    pub(crate) fn evaluations(&self) -> u64 {
        self.layout.evaluations
    }

    /// Lowers the height limit until the budget ends or the lower bound is reached. Every lower layout is passed to
    /// `found`.
    pub(crate) fn run(&mut self, clock: &CompressionBudget<'_>, found: &mut dyn FnMut(&[PlacedItem], u64)) {
        while (clock.spent_share_at)(self.layout.evaluations) < clock.until
            && self.height_mm > clock.lower_bound_mm + BOUND_TOLERANCE_MM
        {
            let (least, most) =
                if (clock.spent_share_at)(self.layout.evaluations) > 0.75 { (5e-4, 8e-3) } else { (2e-3, 5e-2) };
            self.pace.step = self.pace.step.clamp(least, most);
            let height_limit_mm = (self.height_mm * (1.0 - self.pace.step)).max(clock.lower_bound_mm);
            let again = self.start_attempt(height_limit_mm);
            match self.try_height_limit(height_limit_mm, clock) {
                Some(pieces) => {
                    self.accept_layout(pieces);
                    found(&self.items, self.layout.evaluations);
                }
                None => {
                    self.pace.failures = self.pace.failures.saturating_add(1);
                    if !again {
                        self.pace.step *= 0.6;
                    }
                }
            }
        }
    }

    /// Continues from a new valid layout.
    fn accept_layout(&mut self, pieces: Vec<PlacedItem>) {
        // A height limit that was reached only after it was raised again fell too fast.
        let wanted_mm = self.height_mm * (1.0 - self.pace.step);
        self.height_mm = height_mm(&pieces);
        self.pace.step *= if self.height_mm <= wanted_mm + 1e-6 { 1.3 } else { 0.7 };
        self.items = pieces;
        self.best_poses.clone_from(&self.layout.poses);
        self.pool.clear();
        self.pace.failures = 0;
    }

    /// Brings the parts below a height limit: from the best layout, from a modified failed layout, or from random
    /// poses. Returns whether it did not start from the best layout.
    fn start_attempt(&mut self, height_limit_mm: f64) -> bool {
        self.layout.age_memory();
        self.layout.height_limit_mm = height_limit_mm;
        let failed = self.layout.prepared.components.pool && self.pace.failures > 0 && !self.pool.is_empty();
        let few = self.layout.part_count() <= SCATTER_MAX_PARTS && self.pace.failures >= SCATTER_AFTER;
        let again = failed && self.rng.random_bool(0.5);
        if !again && failed && few && self.rng.random_bool(0.3) {
            scatter_parts(&mut self.layout, &mut self.rng);
            return true;
        }
        if again {
            let count = self.pool.len();
            let at = self.rng.random_range(0..count).min(self.rng.random_range(0..count));
            let poses = self.pool[at].1.clone();
            self.layout.load_poses(&poses);
            swap_similar_parts(&mut self.layout, &mut self.rng);
        } else {
            // Only what stands above the limit moves. To lower others with it costs more overlaps than it makes room.
            self.layout.load_poses(&self.best_poses);
        }
        again
    }

    /// Separates the parts below a height limit. A limit that is nearly reached is raised half of the way to the known
    /// height: a layout found below it is worth more than the last millimetres.
    fn try_height_limit(&mut self, mut height_limit_mm: f64, clock: &CompressionBudget<'_>) -> Option<Vec<PlacedItem>> {
        // The pace may come from another machine.
        let harder = LIMIT_EFFORT.1.saturating_mul(self.pace.failures).saturating_add(LIMIT_EFFORT.0);
        let mut effort = harder.min(MAX_LIMIT_EFFORT) * self.layout.part_count() as u64;
        for relents in 0..=MAX_LIMIT_RAISES {
            let limit = self.layout.evaluations + effort;
            let patience = SeparationLimits { idle_rounds: 40, failed_checks: 16, near_overlap: self.near_overlap };
            let over = |evaluations: u64| evaluations >= limit || (clock.spent_share_at)(evaluations) >= clock.until;
            match separate_parts(&mut self.layout, patience, &mut self.rng, over) {
                SeparationOutcome::Clear(pieces) if self.layout.prepared.keeps_cap(&pieces) => return Some(pieces),
                SeparationOutcome::Clear(_) => {
                    // One layer exceeds its cap: continue from this layout after swapping two parts.
                    self.pool.insert(0, (0.0, self.layout.poses.clone()));
                    self.pool.truncate(POOL_SIZE);
                    return None;
                }
                SeparationOutcome::Stuck(overlap, poses) => {
                    if poses.is_empty() || (clock.spent_share_at)(self.layout.evaluations) >= clock.until {
                        return None;
                    }
                    if overlap > self.near_overlap || relents == MAX_LIMIT_RAISES {
                        let at = self.pool.partition_point(|(known, _)| *known <= overlap);
                        self.pool.insert(at, (overlap, poses));
                        self.pool.truncate(POOL_SIZE);
                        return None;
                    }
                    height_limit_mm += 0.5 * (self.height_mm - height_limit_mm);
                    self.layout.height_limit_mm = height_limit_mm;
                    self.layout.load_poses(&poses);
                    effort /= 2;
                }
            }
        }
        None
    }
}

/// Gives every part a random pose: a restart may succeed where the old arrangement is stuck. Fixed parts stay.
fn scatter_parts(layout: &mut WorkingLayout<'_>, rng: &mut ChaCha8Rng) {
    for part in 0..layout.part_count() {
        let pose = random_pose(layout, part, rng);
        layout.move_part(part, pose);
    }
}

/// Swaps the positions of two parts of about the same size; each keeps its rotation.
fn swap_similar_parts(layout: &mut WorkingLayout<'_>, rng: &mut ChaCha8Rng) {
    let movable: Vec<usize> = (0..layout.part_count()).filter(|&part| !layout.parts.fixed[part]).collect();
    if movable.len() < 2 {
        return;
    }
    let one = movable[rng.random_range(0..movable.len())];
    let radius = |part: usize| layout.proxies[part].shape.radius_mm;
    let mut others: Vec<usize> =
        movable.into_iter().filter(|&part| layout.parts.copies[part].0 != layout.parts.copies[one].0).collect();
    others.sort_by(|&a, &b| (radius(a) - radius(one)).abs().total_cmp(&(radius(b) - radius(one)).abs()));
    others.truncate(5);
    if others.is_empty() {
        return;
    }
    let other = others[rng.random_range(0..others.len())];
    let (first, second) = (layout.poses[one], layout.poses[other]);
    layout.move_part(one, CenterPose { center: second.center, ..first });
    layout.move_part(other, CenterPose { center: first.center, ..second });
}
