//! The falling lid: from a valid layout to a lower one, again and again, until the budget is used up.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    layout::{Layout, Stand},
    piece::{Piece, Task, height_mm},
    separate::{Outcome, Patience, separate},
};

/// Near-feasible layouts that are remembered from failed lids.
const POOL: usize = 6;

/// Lowers a layout until `spent` (share of the budget after so many evaluations) reaches 1; every lower valid layout goes
/// to `found`. `floor_mm` is a height that no layout can beat.
pub(crate) fn compress(
    task: &Task,
    start: &[Piece],
    floor_mm: f64,
    rng: &mut ChaCha8Rng,
    spent: &dyn Fn(u64) -> f64,
    found: &mut dyn FnMut(Vec<Piece>, u64),
) -> u64 {
    let mut height = height_mm(start);
    let mut layout = Layout::new(task, start, height);
    let mut best = layout.stands.clone();
    let mut pool: Vec<(f32, Vec<Stand>)> = Vec::new();
    let begun = spent(0);
    // Many parts need longer for one lid; few are better off with another try.
    let patient = (0.04 + start.len() as f64 * 4e-4).min(0.12);
    let (mut step, mut failures) = (0.02_f64, 0);
    while spent(layout.evaluations) < 1.0 && height > floor_mm + 0.01 {
        let progress = ((spent(layout.evaluations) - begun) / (1.0 - begun).max(1e-9)).clamp(0.0, 1.0);
        let (least, most) = if progress > 0.75 { (0.0005, 0.008) } else { (0.002, 0.05) };
        step = step.clamp(least, most);
        let lid = (height * (1.0 - step)).max(floor_mm);
        layout.forget();
        let again = task.organs.pool && failures > 0 && !pool.is_empty() && rng.random_bool(0.5);
        layout.lid_mm = lid;
        if again {
            let at = rng.random_range(0..pool.len()).min(rng.random_range(0..pool.len()));
            let stands = pool[at].1.clone();
            layout.load(&stands);
            disturb(&mut layout, rng);
        } else {
            let stands = squeezed(&layout, &best, height - lid, rng);
            layout.load(&stands);
        }
        let limit = spent(layout.evaluations) + patient * (1.0 - begun);
        let patience = Patience { rounds: 40, repairs: 12 };
        let outcome = separate(&mut layout, patience, rng, |evaluations| {
            let now = spent(evaluations);
            now >= 1.0 || now >= limit
        });
        match outcome {
            Outcome::Clear(pieces) => {
                height = height_mm(&pieces);
                best = layout.stands.clone();
                pool.clear();
                failures = 0;
                step *= 1.3;
                found(pieces, layout.evaluations);
            }
            Outcome::Stuck(overlap, stands) => {
                failures += 1;
                if !stands.is_empty() {
                    let at = pool.partition_point(|(known, _)| *known <= overlap);
                    pool.insert(at, (overlap, stands));
                    pool.truncate(POOL);
                }
                if !again {
                    step *= 0.6;
                }
            }
        }
    }
    layout.evaluations
}

/// A layout brought under a lower lid: everything above a random height comes down by what is to be gained.
fn squeezed(layout: &Layout<'_>, stands: &[Stand], gain_mm: f64, rng: &mut ChaCha8Rng) -> Vec<Stand> {
    let cut = rng.random_range(0.2..1.0) * layout.lid_mm;
    let lower = |stand: &Stand| Stand { place: stand.place.with_z(stand.place.z - gain_mm), ..*stand };
    stands.iter().map(|stand| if stand.place.z > cut { lower(stand) } else { *stand }).collect()
}

/// Lets two parts of about the same size change places, keeping their turns.
fn disturb(layout: &mut Layout<'_>, rng: &mut ChaCha8Rng) {
    let movable: Vec<usize> = (0..layout.len()).filter(|&part| !layout.fixed[part]).collect();
    if movable.len() < 2 {
        return;
    }
    let one = movable[rng.random_range(0..movable.len())];
    let radius = |part: usize| layout.guides[part].shape.radius_mm;
    let mut others: Vec<usize> =
        movable.into_iter().filter(|&part| layout.copies[part].0 != layout.copies[one].0).collect();
    others.sort_by(|&a, &b| (radius(a) - radius(one)).abs().total_cmp(&(radius(b) - radius(one)).abs()));
    others.truncate(5);
    if others.is_empty() {
        return;
    }
    let other = others[rng.random_range(0..others.len())];
    let (first, second) = (layout.stands[one], layout.stands[other]);
    layout.set(one, Stand { place: second.place, ..first });
    layout.set(other, Stand { place: first.place, ..second });
}
