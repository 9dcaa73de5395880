//! Separation under a lid: overlapping parts are pushed out or relocated, pair weights grow, until nothing overlaps and
//! the triangles confirm it, or nothing helps any more.

use rand::{RngExt, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::{
    interlock::is_settled,
    layout::{Layout, Stand},
    piece::Piece,
    relocate::{DepthGrid, Effort, relocate},
};

/// How long a separation may go on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patience {
    /// Rounds without less overlap.
    pub(crate) rounds: usize,
    /// Failed confirmations.
    pub(crate) repairs: usize,
    /// Overlap below which the triangles are asked now and then, though the guides are not content yet.
    pub(crate) nearly: f32,
}

/// How a separation ended.
pub(crate) enum Outcome {
    /// Every pair is exactly clear, and where it is asked no part is locked into others.
    Clear(Vec<Piece>),
    /// The least total overlap that was reached, and where all parts stood.
    Stuck(f32, Vec<Stand>),
}

/// Share of an overlapping part's rounds in which it looks for another place.
const RELOCATE_SHARE: f64 = 0.5;
/// Rounds between two looks at the triangles while little overlaps.
const LOOK_ROUNDS: usize = 6;
/// Gauss-Newton steps per part and round.
const STEPS: usize = 3;

/// Separates; `over` says when the budget for it is used up.
pub(crate) fn separate(
    layout: &mut Layout<'_>,
    patience: Patience,
    rng: &mut ChaCha8Rng,
    mut over: impl FnMut(u64) -> bool,
) -> Outcome {
    let mut grid = DepthGrid::new(layout);
    let mut energies = Vec::new();
    let mut total = layout.weigh(&mut energies);
    let mut least = (f32::INFINITY, Vec::new());
    let (mut idle, mut repairs, mut rounds) = (0, 0, 0);
    loop {
        let content = total <= 0.0;
        if content || (total < patience.nearly && rounds % LOOK_ROUNDS == 0) {
            if let Some(pieces) = layout.confirm().filter(|pieces| is_settled(layout, pieces, &mut grid, rng)) {
                return Outcome::Clear(pieces);
            }
            total = layout.weigh(&mut energies);
        }
        rounds += 1;
        if content {
            repairs += 1;
            if repairs > patience.repairs {
                return Outcome::Stuck(total, layout.stands.clone());
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
            least = (total, layout.stands.clone());
        }
        if idle > patience.rounds || over(layout.evaluations) {
            return Outcome::Stuck(least.0, least.1);
        }
        if !round(layout, &mut grid, &energies, rng, &mut over) {
            return Outcome::Stuck(least.0, least.1);
        }
        total = layout.weigh(&mut energies);
    }
}

/// One round over all overlapping parts in random order; false when the budget ended in it.
fn round(
    layout: &mut Layout<'_>,
    grid: &mut DepthGrid,
    energies: &[f32],
    rng: &mut ChaCha8Rng,
    over: &mut impl FnMut(u64) -> bool,
) -> bool {
    let mut parts: Vec<usize> = (0..layout.len()).filter(|&part| energies[part] > 0.0 && !layout.fixed[part]).collect();
    parts.shuffle(rng);
    let share = RELOCATE_SHARE.min(15.0 / parts.len().max(1) as f64).max(0.1);
    for part in parts {
        let mut energy = 1.0;
        for _ in 0..STEPS {
            energy = layout.step(part);
            if energy <= 0.0 {
                break;
            }
        }
        if energy > 0.0 && layout.task.organs.relocation && rng.random_bool(share) {
            let still = layout.energy_at(part, &layout.guides[part], false, f32::INFINITY);
            if still > 0.0 {
                let effort = Effort { asked: 800, looked_at: 24, pushed: 3 };
                relocate(layout, grid, part, effort, rng);
            }
        }
        if over(layout.evaluations) {
            return false;
        }
    }
    true
}
