//! A tournament of compression runs from several starting layouts. The result of a run depends much on its start, so
//! several runs begin and only the lowest continue.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    compression::{CompressionBudget, CompressionRun},
    prepared_instance::{PlacedItem, PreparedInstance},
};

/// Share of the budget for the first run alone, which shows how many runs the budget allows.
const FIRST_RUN_SHARE: f64 = 0.05;
/// Share of the budget after which only one run is left.
const TOURNAMENT_SHARE: f64 = 0.45;
/// Evaluations per part, over the whole budget, from which on two, four and eight runs are worthwhile.
const EVALUATIONS_TO_DOUBLE: [f64; 3] = [8e3, 25e3, 60e3];

/// The random generator of one run of one thread.
fn run_rng(seed: u64, thread: usize, number: usize) -> ChaCha8Rng {
    let (thread, number) = (thread as u64, number as u64);
    let apart = thread.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number.wrapping_mul(0xd1b5_4a32_d192_ed03));
    let mixed = seed.wrapping_add(apart);
    ChaCha8Rng::seed_from_u64(mixed)
}

/// Lowers layouts until `spent` (share of the budget after a number of evaluations) reaches 1. Every layout lower than
/// all before is passed to `found`. `starts` are valid layouts of the same copies, the lowest first. Returns the number
/// of evaluations.
pub(crate) fn run_tournament(
    prepared: &PreparedInstance,
    starts: &[Vec<PlacedItem>],
    floor_mm: f64,
    (seed, thread): (u64, usize),
    spent: &dyn Fn(u64) -> f64,
    found: &mut dyn FnMut(Vec<PlacedItem>, u64),
) -> u64 {
    let begin = |number: usize| {
        CompressionRun::new(prepared, &starts[(number + thread) % starts.len()], run_rng(seed, thread, number))
    };
    let (begun, mut made, mut least_mm) = (spent(0), 0, f64::INFINITY);
    let mut run = |descent: &mut CompressionRun<'_>, share: f64| {
        let others = made - descent.evaluations();
        let spent = |evaluations: u64| (spent(others + evaluations) - begun) / (1.0 - begun).max(1e-9);
        let until = if share >= 1.0 { 1.0 } else { spent(descent.evaluations()) + share };
        descent.run(
            &CompressionBudget { spent_share_at: &spent, until, lower_bound_mm: floor_mm },
            &mut |pieces, evaluations| {
                let height_mm = super::prepared_instance::height_mm(pieces);
                if height_mm < least_mm {
                    least_mm = height_mm;
                    found(pieces.to_vec(), others + evaluations);
                }
            },
        );
        made = others + descent.evaluations();
    };
    let mut descents = vec![begin(0)];
    run(&mut descents[0], FIRST_RUN_SHARE);
    let affordable = descents[0].evaluations() as f64 / FIRST_RUN_SHARE / prepared.copies.len().max(1) as f64;
    let count = 1 << EVALUATIONS_TO_DOUBLE.iter().filter(|&&worth| affordable >= worth).count();
    descents.extend((1..count).map(begin));
    let rounds = (count as f64).log2();
    while descents.len() > 1 {
        let share = TOURNAMENT_SHARE / rounds / descents.len() as f64;
        descents.iter_mut().for_each(|descent| run(descent, share));
        descents.sort_by(|a, b| a.height_mm.total_cmp(&b.height_mm));
        descents.truncate(descents.len() / 2);
    }
    run(&mut descents[0], 1.0);
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_descent_of_every_thread_has_a_seed_of_its_own() {
        let seeds = (0..16).flat_map(|thread| (0..8).map(move |number| run_rng(u64::MAX, thread, number).get_seed()));
        let mut seeds: Vec<[u8; 32]> = seeds.collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 128);
    }
}
