//! Separation below a height limit: all parts make room together, overlapping parts are pushed apart or relocated, and
//! pair weights grow. It ends when nothing overlaps and the exact test confirms it, or when there is no more progress.

use rand::{RngExt, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::{
    interlock_check::resolve_interlocks,
    overlap_depth_grid::OverlapDepthGrid,
    relocation::{RelocationEffort, relocate_part},
    working_layout::{CenterPose, WorkingLayout},
};
use crate::prepare::prepared_instance::PlacedItem;

/// Limits of one separation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeparationLimits {
    /// Rounds without progress.
    pub(crate) idle_rounds: usize,
    /// Failed exact tests.
    pub(crate) failed_checks: usize,
    /// Overlap below which the exact test is tried now and then, although the proxies still overlap.
    pub(crate) near_overlap: f32,
}

/// How a separation ended.
pub(crate) enum SeparationOutcome {
    /// Every pair is exactly clear and, if required, no part is locked.
    Clear(Vec<PlacedItem>),
    /// The least total overlap that was reached, and the poses of all parts at that time.
    Stuck(f32, Vec<CenterPose>),
}

/// Share of rounds in which an overlapping part is relocated.
const RELOCATE_SHARE: f64 = 0.5;
/// Rounds between two exact tests while the overlap is small.
const CHECK_ROUNDS: usize = 6;
/// Gauss-Newton steps per part and round.
const STEPS: usize = 3;

/// Separates the parts; `over` returns whether the budget is used up.
pub(crate) fn separate_parts(
    layout: &mut WorkingLayout<'_>,
    patience: SeparationLimits,
    rng: &mut ChaCha8Rng,
    mut over: impl FnMut(u64) -> bool,
) -> SeparationOutcome {
    let mut grid = OverlapDepthGrid::new(layout);
    let mut energies = Vec::new();
    let mut total = layout.weigh_overlaps(&mut energies);
    let mut least = (f32::INFINITY, Vec::new());
    let (mut idle, mut repairs, mut rounds) = (0, 0, 0);
    loop {
        let content = total <= 0.0;
        if content || (total < patience.near_overlap && rounds % CHECK_ROUNDS == 0) {
            if let Some(pieces) =
                layout.confirm_clear().filter(|pieces| resolve_interlocks(layout, pieces, &mut grid, rng))
            {
                return SeparationOutcome::Clear(pieces);
            }
            total = layout.weigh_overlaps(&mut energies);
        }
        rounds += 1;
        if content {
            repairs += 1;
            if repairs > patience.failed_checks || over(layout.evaluations) {
                return SeparationOutcome::Stuck(total, layout.poses.clone());
            }
            (idle, least) = (0, (f32::INFINITY, Vec::new()));
            if total <= 0.0 {
                continue;
            }
        }
        idle += 1;
        if total < 0.97 * least.0 {
            idle = 0;
        }
        if total < least.0 {
            least = (total, layout.poses.clone());
        }
        if idle > patience.idle_rounds || over(layout.evaluations) {
            return SeparationOutcome::Stuck(least.0, least.1);
        }
        if layout.prepared.components.joint_steps {
            layout.take_joint_step();
            if over(layout.evaluations) {
                return SeparationOutcome::Stuck(least.0, least.1);
            }
        }
        if !run_round(layout, &mut grid, &energies, rng, &mut over) {
            return SeparationOutcome::Stuck(least.0, least.1);
        }
        total = layout.weigh_overlaps(&mut energies);
    }
}

/// Runs one round over all parts that overlapped when their overlaps were weighed, in random order. Returns false when the
/// budget ended during the round.
fn run_round(
    layout: &mut WorkingLayout<'_>,
    grid: &mut OverlapDepthGrid,
    energies: &[f32],
    rng: &mut ChaCha8Rng,
    over: &mut impl FnMut(u64) -> bool,
) -> bool {
    let mut parts: Vec<usize> =
        (0..layout.part_count()).filter(|&part| energies[part] > 0.0 && !layout.parts.fixed[part]).collect();
    parts.shuffle(rng);
    let share = RELOCATE_SHARE.min(15.0 / parts.len().max(1) as f64).max(0.1);
    for part in parts {
        let mut energy = 1.0;
        for _ in 0..STEPS {
            energy = layout.take_separation_step(part);
            if energy <= 0.0 {
                break;
            }
        }
        if energy > 0.0 && layout.prepared.components.relocation && rng.random_bool(share) {
            let still = layout.energy_at(part, &layout.proxies[part], false, f32::INFINITY);
            if still > 0.0 {
                let effort = RelocationEffort { grid_queries: 800, coarse_checks: 24, separated: 3 };
                relocate_part(layout, grid, part, effort, still, rng);
            }
        }
        if over(layout.evaluations) {
            return false;
        }
    }
    true
}
