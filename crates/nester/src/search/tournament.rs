//! A tournament of compression runs from several starting layouts. The result of a run depends much on its start, so
//! several runs begin and only the lowest continue.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::compression::{CompressionBudget, CompressionRun, DescentPace};
use crate::{
    prepare::prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    problem::solution::BOUND_TOLERANCE_MM,
};

/// Share of the budget for the first run alone, which shows how many runs the budget allows.
const FIRST_RUN_SHARE: f64 = 0.05;
/// Share of the budget after which only one run is left.
const TOURNAMENT_SHARE: f64 = 0.45;
/// Evaluations per part, over the whole budget, from which on two, four and eight runs are worthwhile.
const EVALUATIONS_TO_DOUBLE: [f64; 3] = [8e3, 25e3, 60e3];

/// What a descent begins with.
#[derive(Clone, Copy)]
pub(crate) struct DescentStart<'a> {
    pub(crate) prepared: &'a PreparedInstance,
    /// Valid layouts of the same copies, one or more. The first run begins from the first one, and so on.
    pub(crate) layouts: &'a [Vec<PlacedItem>],
    /// A height that no layout can beat, mm.
    pub(crate) floor_mm: f64,
    /// Seed of every random choice.
    pub(crate) seed: u64,
    /// The pace to go on with, unless there are several runs.
    pub(crate) pace: DescentPace,
    /// Least number of runs of a tournament, a power of two.
    pub(crate) least_runs: usize,
}

impl DescentStart<'_> {
    /// Whether no layout is lower than this one.
    pub(crate) fn is_lowest(&self, items: &[PlacedItem]) -> bool {
        height_mm(items) <= self.floor_mm + BOUND_TOLERANCE_MM
    }
}

/// How a descent ended.
pub(crate) struct DescentEnd {
    /// The lowest layout.
    pub(crate) items: Vec<PlacedItem>,
    /// Where the runs ended that did not go on.
    pub(crate) others: Vec<Vec<PlacedItem>>,
    pub(crate) pace: DescentPace,
    /// Evaluations made.
    pub(crate) made: u64,
}

/// The random generator of one run.
fn run_rng(seed: u64, number: usize) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed.wrapping_add((number as u64).wrapping_mul(0xd1b5_4a32_d192_ed03)))
}

/// Lowers the first layout in a single run until `spent` (share of the budget after a number of evaluations) reaches
/// `until`. Every lower layout is passed to `found`.
pub(crate) fn run_descent(
    start: &DescentStart<'_>,
    until: f64,
    spent: &dyn Fn(u64) -> f64,
    found: &mut dyn FnMut(&[PlacedItem], u64),
) -> DescentEnd {
    let mut descent = CompressionRun::new(start.prepared, &start.layouts[0], run_rng(start.seed, 0));
    descent.pace = start.pace;
    descent.run(&CompressionBudget { spent_share_at: spent, until, lower_bound_mm: start.floor_mm }, found);
    DescentEnd { pace: descent.pace, made: descent.evaluations(), items: descent.items, others: Vec::new() }
}

/// Lowers layouts until `spent` (share of the budget after a number of evaluations) reaches 1. Every layout lower than
/// all before is passed to `found`.
pub(crate) fn run_tournament(
    start: &DescentStart<'_>,
    spent: &dyn Fn(u64) -> f64,
    found: &mut dyn FnMut(&[PlacedItem], u64),
) -> DescentEnd {
    let DescentStart { prepared, layouts, floor_mm, seed, .. } = *start;
    let begin = |number: usize| CompressionRun::new(prepared, &layouts[number % layouts.len()], run_rng(seed, number));
    let (begun, mut made, mut lowest) = (spent(0), 0, layouts[0].clone());
    let mut run = |descent: &mut CompressionRun<'_>, share: f64| {
        if start.is_lowest(&lowest) {
            return;
        }
        let others = made - descent.evaluations();
        let spent = |evaluations: u64| (spent(others + evaluations) - begun) / (1.0 - begun).max(1e-9);
        let until = if share >= 1.0 { 1.0 } else { spent(descent.evaluations()) + share };
        descent.run(
            &CompressionBudget { spent_share_at: &spent, until, lower_bound_mm: floor_mm },
            &mut |pieces, evaluations| {
                if height_mm(pieces) < height_mm(&lowest) {
                    lowest = pieces.to_vec();
                    found(pieces, others + evaluations);
                }
            },
        );
        made = others + descent.evaluations();
    };
    let mut descents = vec![begin(0)];
    run(&mut descents[0], FIRST_RUN_SHARE);
    let affordable = descents[0].evaluations() as f64 / FIRST_RUN_SHARE / layouts[0].len().max(1) as f64;
    let count = start.least_runs.max(1 << EVALUATIONS_TO_DOUBLE.iter().filter(|&&worth| affordable >= worth).count());
    descents.extend((1..count).map(begin));
    let (rounds, mut others) = ((count as f64).log2(), Vec::new());
    while descents.len() > 1 {
        let share = TOURNAMENT_SHARE / rounds / descents.len() as f64;
        descents.iter_mut().for_each(|descent| run(descent, share));
        descents.sort_by(|a, b| a.height_mm.total_cmp(&b.height_mm));
        others.extend(descents.split_off(descents.len() / 2).into_iter().map(|descent| descent.items));
    }
    run(&mut descents[0], 1.0);
    DescentEnd { items: lowest, others, pace: descents[0].pace, made }
}

#[cfg(test)]
mod tests {
    use super::{super::lane_rounds::lane_seed, *};

    #[test]
    fn every_descent_of_every_round_of_every_lane_has_a_seed_of_its_own() {
        let of_lane = |round: u32, lane: u32| {
            (0..8).map(move |number| run_rng(lane_seed(u64::MAX, round, lane), number).get_seed())
        };
        let lanes = (0..16).flat_map(|round| (0..16).map(move |lane| (round, lane)));
        let mut seeds: Vec<[u8; 32]> = lanes.flat_map(|(round, lane)| of_lane(round, lane)).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 16 * 16 * 8);
    }
}
