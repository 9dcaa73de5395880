//! Compression: repeatedly turns a valid layout into a lower one by lowering a height limit, until the budget is used
//! up. Where no lower one is found, it goes on from another one that is hardly higher.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::{
    prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    relocation::random_pose,
    separation::{SeparationLimits, SeparationOutcome, separate_parts},
    working_layout::{CenterPose, WorkingLayout},
};

/// Evaluations per part for one height limit, and the increase after each failure.
const LIMIT_EFFORT: (u64, u64) = (120, 60);
/// Greatest number of evaluations per part for one height limit.
const MAX_LIMIT_EFFORT: u64 = 900;
/// Number of times that a nearly reached height limit is raised half of the way back.
const MAX_LIMIT_RAISES: usize = 2;
/// Overlap of all parts, relative to one part's cross section, below which a height limit was nearly reached, mm.
const NEAR_OVERLAP_MM: f64 = 0.3;

/// A descent stands still after this number of failures. Then
const STILL_AFTER: u64 = 2;
/// this share of its attempts is for another layout,
const TRAVEL_SHARE: f64 = 0.7;
/// higher than the lowest one by at most this share of its height,
const TRAVEL_RISE: f64 = 0.01;
/// with at most this number of evaluations per part. The next height limit is
const TRAVEL_EFFORT: u64 = 300;
/// lower than the lowest layout by at least this share of the height, but where the budget is nearly used up.
const TRAVEL_STEP: f64 = 0.003;

/// What a descent has learnt about how far the height limit may fall at once. It goes on in the next round of a lane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DescentPace {
    /// Relative step of the height limit.
    pub step: f64,
    /// Height limits that were not reached since the last success; half as many after another layout was found.
    pub failures: u64,
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
    /// The valid layout from which the next attempt begins: the lowest one, or one that is hardly higher.
    here_poses: Vec<CenterPose>,
    pub(crate) here_mm: f64,
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
            here_poses: layout.poses.clone(),
            here_mm: height,
            items: start.to_vec(),
            height_mm: height,
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
            && self.height_mm > clock.lower_bound_mm + 0.01
        {
            let stands_still = self.layout.prepared.components.travel && self.pace.failures >= STILL_AFTER;
            let next = if stands_still && self.rng.random_bool(TRAVEL_SHARE) {
                self.find_other_layout(clock)
            } else {
                self.find_lower_layout(clock)
            };
            if let Some(pieces) = next
                && self.accept_layout(pieces)
            {
                found(&self.items, self.layout.evaluations);
            }
        }
    }

    /// Continues from a new valid layout. Returns whether it is lower than all before.
    fn accept_layout(&mut self, pieces: Vec<PlacedItem>) -> bool {
        self.here_mm = height_mm(&pieces);
        self.here_poses.clone_from(&self.layout.poses);
        let is_lower = self.here_mm < self.height_mm;
        if is_lower {
            (self.items, self.height_mm) = (pieces, self.here_mm);
        }
        is_lower
    }

    /// Looks for a layout that is lower than the present one.
    fn find_lower_layout(&mut self, clock: &CompressionBudget<'_>) -> Option<Vec<PlacedItem>> {
        let (least, most) =
            if (clock.spent_share_at)(self.layout.evaluations) > 0.75 { (5e-4, 8e-3) } else { (2e-3, 5e-2) };
        self.pace.step = self.pace.step.clamp(least, most);
        let height_limit_mm = (self.here_mm * (1.0 - self.pace.step)).max(clock.lower_bound_mm);
        // Only what stands above the limit moves. To lower others with it costs more overlaps than it makes room.
        self.begin_attempt(height_limit_mm);
        let lower = self.try_height_limit(height_limit_mm, clock);
        self.pace.failures = if lower.is_some() { 0 } else { self.pace.failures + 1 };
        self.pace.step *= match &lower {
            Some(pieces) if height_mm(pieces) <= height_limit_mm + 1e-6 => 1.3,
            // A height limit that was reached only after it was raised again fell too fast.
            Some(_) => 0.7,
            None => 0.6,
        };
        lower
    }

    /// Looks for another layout that is hardly higher than the lowest one, with a part elsewhere or two parts swapped. From
    /// there the height limit can often fall again (record-to-record travel, Dueck 1993, J. Comput. Phys. 104, 86-92).
    fn find_other_layout(&mut self, clock: &CompressionBudget<'_>) -> Option<Vec<PlacedItem>> {
        self.begin_attempt((self.height_mm * (1.0 + TRAVEL_RISE)).min(self.layout.prepared.room.z));
        if self.rng.random_bool(0.5) || !swap_similar_parts(&mut self.layout, &mut self.rng) {
            throw_large_part(&mut self.layout, &mut self.rng);
        }
        let effort = TRAVEL_EFFORT * self.layout.part_count() as u64;
        match self.separate_within(effort, clock) {
            SeparationOutcome::Clear(pieces) if self.layout.prepared.keeps_cap(&pieces) => {
                let above = 1.0 - self.height_mm / height_mm(&pieces);
                self.pace.step = self.pace.step.max(above + TRAVEL_STEP);
                // With half of the effort, because it is another layout; not with the least, because it may be nearly the same.
                self.pace.failures /= 2;
                Some(pieces)
            }
            _ => None,
        }
    }

    /// Loads the present layout below a height limit.
    fn begin_attempt(&mut self, height_limit_mm: f64) {
        self.layout.age_memory();
        self.layout.height_limit_mm = height_limit_mm;
        self.layout.load_poses(&self.here_poses);
    }

    /// Separates the parts below a height limit. A limit that is nearly reached is raised half of the way to the present
    /// height: a layout found below it is worth more than the last millimetres.
    fn try_height_limit(&mut self, mut height_limit_mm: f64, clock: &CompressionBudget<'_>) -> Option<Vec<PlacedItem>> {
        let mut effort = (LIMIT_EFFORT.0 + LIMIT_EFFORT.1 * self.pace.failures).min(MAX_LIMIT_EFFORT)
            * self.layout.part_count() as u64;
        for raises in 0..=MAX_LIMIT_RAISES {
            match self.separate_within(effort, clock) {
                SeparationOutcome::Clear(pieces) => {
                    return Some(pieces).filter(|pieces| self.layout.prepared.keeps_cap(pieces));
                }
                SeparationOutcome::Stuck(overlap, poses) => {
                    let is_over = (clock.spent_share_at)(self.layout.evaluations) >= clock.until;
                    if is_over || poses.is_empty() || overlap > self.near_overlap || raises == MAX_LIMIT_RAISES {
                        return None;
                    }
                    height_limit_mm += 0.5 * (self.here_mm - height_limit_mm);
                    self.layout.height_limit_mm = height_limit_mm;
                    self.layout.load_poses(&poses);
                    effort /= 2;
                }
            }
        }
        None
    }

    /// Separates the parts with at most `effort` evaluations.
    fn separate_within(&mut self, effort: u64, clock: &CompressionBudget<'_>) -> SeparationOutcome {
        let limit = self.layout.evaluations + effort;
        let patience = SeparationLimits { idle_rounds: 40, failed_checks: 16, near_overlap: self.near_overlap };
        let over = |evaluations: u64| evaluations >= limit || (clock.spent_share_at)(evaluations) >= clock.until;
        separate_parts(&mut self.layout, patience, &mut self.rng, over)
    }
}

/// The parts that are not fixed.
fn movable_parts(layout: &WorkingLayout<'_>) -> Vec<usize> {
    (0..layout.part_count()).filter(|&part| !layout.parts.fixed[part]).collect()
}

/// Gives the largest of three parts a random pose: the others make room for it, or for what took its place.
fn throw_large_part(layout: &mut WorkingLayout<'_>, rng: &mut ChaCha8Rng) {
    let movable = movable_parts(layout);
    if movable.is_empty() {
        return;
    }
    let radius = |part: &usize| layout.proxies[*part].shape.radius_mm;
    let drawn: [usize; 3] = std::array::from_fn(|_| movable[rng.random_range(0..movable.len())]);
    if let Some(part) = drawn.into_iter().max_by(|one, other| radius(one).total_cmp(&radius(other))) {
        let pose = random_pose(layout, part, rng);
        layout.move_part(part, pose);
    }
}

/// Swaps the positions of two parts of about the same size; each keeps its rotation. Returns false if no part differs from
/// another one.
pub(crate) fn swap_similar_parts(layout: &mut WorkingLayout<'_>, rng: &mut ChaCha8Rng) -> bool {
    let movable = movable_parts(layout);
    if movable.len() < 2 {
        return false;
    }
    let one = movable[rng.random_range(0..movable.len())];
    let radius = |part: usize| layout.proxies[part].shape.radius_mm;
    let mut others: Vec<usize> =
        movable.into_iter().filter(|&part| layout.parts.copies[part].0 != layout.parts.copies[one].0).collect();
    others.sort_by(|&a, &b| (radius(a) - radius(one)).abs().total_cmp(&(radius(b) - radius(one)).abs()));
    others.truncate(5);
    if others.is_empty() {
        return false;
    }
    let other = others[rng.random_range(0..others.len())];
    let (first, second) = (layout.poses[one], layout.poses[other]);
    layout.move_part(one, CenterPose { center: second.center, ..first });
    layout.move_part(other, CenterPose { center: first.center, ..second });
    true
}
