//! Several descents from several starts: what a descent reaches depends much on where it begins, so some begin and the
//! lowest go on.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

use super::{
    compress::{Clock, Descent},
    piece::{Piece, Task},
};

/// Share of the budget that the first of all descents runs alone, to see how many the budget allows.
const FIRST_SHARE: f64 = 0.05;
/// Share of the budget after which one descent is left.
const CONTEST_SHARE: f64 = 0.45;
/// Evaluations per part, over the whole budget, from which on two, four and eight descents are worth it.
const WORTH: [f64; 3] = [8e3, 25e3, 60e3];

/// The seed of one descent of one thread.
fn rng(seed: u64, thread: usize, number: usize) -> ChaCha8Rng {
    let (thread, number) = (thread as u64, number as u64);
    let apart = thread.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number.wrapping_mul(0xd1b5_4a32_d192_ed03));
    let mixed = seed.wrapping_add(apart);
    ChaCha8Rng::seed_from_u64(mixed)
}

/// Lowers layouts until `spent` (share of the budget after so many evaluations) reaches 1; every layout lower than all
/// before goes to `found`. `starts` are valid layouts of the same copies, the lowest first. Returns the evaluations made.
pub(crate) fn contest(
    task: &Task,
    starts: &[Vec<Piece>],
    floor_mm: f64,
    (seed, thread): (u64, usize),
    spent: &dyn Fn(u64) -> f64,
    found: &mut dyn FnMut(Vec<Piece>, u64),
) -> u64 {
    let begin =
        |number: usize| Descent::new(task, &starts[(number + thread) % starts.len()], rng(seed, thread, number));
    let (begun, mut made, mut least_mm) = (spent(0), 0, f64::INFINITY);
    let mut run = |descent: &mut Descent<'_>, share: f64| {
        let others = made - descent.evaluations();
        let spent = |evaluations: u64| (spent(others + evaluations) - begun) / (1.0 - begun).max(1e-9);
        let until = if share >= 1.0 { 1.0 } else { spent(descent.evaluations()) + share };
        descent.run(&Clock { spent: &spent, until, floor_mm }, &mut |pieces, evaluations| {
            let height_mm = super::piece::height_mm(pieces);
            if height_mm < least_mm {
                least_mm = height_mm;
                found(pieces.to_vec(), others + evaluations);
            }
        });
        made = others + descent.evaluations();
    };
    let mut descents = vec![begin(0)];
    run(&mut descents[0], FIRST_SHARE);
    let affordable = descents[0].evaluations() as f64 / FIRST_SHARE / task.copies.len().max(1) as f64;
    let count = 1 << WORTH.iter().filter(|&&worth| affordable >= worth).count();
    descents.extend((1..count).map(begin));
    let rounds = (count as f64).log2();
    while descents.len() > 1 {
        let share = CONTEST_SHARE / rounds / descents.len() as f64;
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
        let seeds = (0..16).flat_map(|thread| (0..8).map(move |number| rng(u64::MAX, thread, number).get_seed()));
        let mut seeds: Vec<[u8; 32]> = seeds.collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 128);
    }
}
