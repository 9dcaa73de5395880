//! The falling lid: from a valid layout to a lower one, again and again, until the budget is used up.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    layout::{Layout, Stand},
    piece::{Piece, Task, height_mm},
    relocate::anywhere,
    separate::{Outcome, Patience, separate},
};

/// Near-feasible layouts that are remembered from failed lids.
const POOL: usize = 6;
/// Evaluations per part that a lid may cost, and how many more after each failure.
const EFFORT: (u64, u64) = (120, 60);
/// Evaluations per part that a lid may cost at most.
const MOST_EFFORT: u64 = 900;
/// How often a lid that nearly came down is raised by half of the way back.
const RELENTS: usize = 2;
/// A lid that leaves all parts together no deeper in each other than this nearly came down, mm over one part's section.
const NEARLY_MM: f64 = 0.3;

/// Builds of no more parts than this are now and then begun from nowhere,
const FEW_PARTS: usize = 60;
/// after so many failures.
const SCATTER_AFTER: u64 = 3;

/// How far the whole search is.
pub(crate) struct Clock<'a> {
    /// Share of the budget that is spent after so many evaluations of this descent.
    pub(crate) spent: &'a dyn Fn(u64) -> f64,
    /// The share at which this descent pauses.
    pub(crate) until: f64,
    /// A height that no layout can beat, mm.
    pub(crate) floor_mm: f64,
}

/// A layout whose lid is lowered; it can be paused and gone on with.
pub(crate) struct Descent<'t> {
    layout: Layout<'t>,
    rng: ChaCha8Rng,
    /// The lowest valid layout so far.
    pub(crate) pieces: Vec<Piece>,
    pub(crate) height_mm: f64,
    best: Vec<Stand>,
    /// Overlap and stands of failed lids, least overlap first.
    pool: Vec<(f32, Vec<Stand>)>,
    step: f64,
    failures: u64,
    nearly: f32,
}

impl<'t> Descent<'t> {
    /// A descent from a valid layout.
    pub(crate) fn new(task: &'t Task, start: &[Piece], rng: ChaCha8Rng) -> Self {
        let height = height_mm(start);
        let layout = Layout::new(task, start, height);
        let section: f64 = layout.guides.iter().map(|g| g.shape.radius_mm.powi(2)).sum();
        Self {
            best: layout.stands.clone(),
            pieces: start.to_vec(),
            height_mm: height,
            pool: Vec::new(),
            step: 0.02,
            failures: 0,
            nearly: (NEARLY_MM * section / start.len().max(1) as f64) as f32,
            layout,
            rng,
        }
    }

    /// Evaluations made.
    pub(crate) fn evaluations(&self) -> u64 {
        self.layout.evaluations
    }

    /// Lowers the lid until the clock says enough or nothing lower can be; every lower layout goes to `found`.
    pub(crate) fn run(&mut self, clock: &Clock<'_>, found: &mut dyn FnMut(&[Piece], u64)) {
        while (clock.spent)(self.layout.evaluations) < clock.until && self.height_mm > clock.floor_mm + 0.01 {
            let (least, most) = if (clock.spent)(self.layout.evaluations) > 0.75 { (5e-4, 8e-3) } else { (2e-3, 5e-2) };
            self.step = self.step.clamp(least, most);
            let lid_mm = (self.height_mm * (1.0 - self.step)).max(clock.floor_mm);
            let again = self.begin(lid_mm);
            match self.lower(lid_mm, clock) {
                Some(pieces) => {
                    self.take(pieces);
                    found(&self.pieces, self.layout.evaluations);
                }
                None => {
                    self.failures += 1;
                    if !again {
                        self.step *= 0.6;
                    }
                }
            }
        }
    }

    /// A valid layout becomes the one to go on from.
    fn take(&mut self, pieces: Vec<Piece>) {
        // A lid that came down only after relenting fell too fast.
        let wanted_mm = self.height_mm * (1.0 - self.step);
        self.height_mm = height_mm(&pieces);
        self.step *= if self.height_mm <= wanted_mm + 1e-6 { 1.3 } else { 0.7 };
        self.pieces = pieces;
        self.best.clone_from(&self.layout.stands);
        self.pool.clear();
        self.failures = 0;
    }

    /// Brings the parts under a lid: from the best layout, or from a failed one disturbed, or from nowhere. Returns
    /// whether it was not the best.
    fn begin(&mut self, lid_mm: f64) -> bool {
        self.layout.forget();
        self.layout.lid_mm = lid_mm;
        let failed = self.layout.task.organs.pool && self.failures > 0 && !self.pool.is_empty();
        let few = self.layout.len() <= FEW_PARTS && self.failures >= SCATTER_AFTER;
        let again = failed && self.rng.random_bool(0.5);
        if !again && failed && few && self.rng.random_bool(0.3) {
            scatter(&mut self.layout, &mut self.rng);
            return true;
        }
        if again {
            let count = self.pool.len();
            let at = self.rng.random_range(0..count).min(self.rng.random_range(0..count));
            let stands = self.pool[at].1.clone();
            self.layout.load(&stands);
            disturb(&mut self.layout, &mut self.rng);
        } else {
            let stands = squeezed(&self.layout, &self.best, self.height_mm - lid_mm, &mut self.rng);
            self.layout.load(&stands);
        }
        again
    }

    /// Separates under the lid. A lid that nearly comes down is raised by half of the way to the known height: what was
    /// found under it is worth more than the last of its millimetres.
    fn lower(&mut self, mut lid_mm: f64, clock: &Clock<'_>) -> Option<Vec<Piece>> {
        let mut effort = (EFFORT.0 + EFFORT.1 * self.failures).min(MOST_EFFORT) * self.layout.len() as u64;
        for relents in 0..=RELENTS {
            let limit = self.layout.evaluations + effort;
            let patience = Patience { rounds: 40, repairs: 16, nearly: self.nearly };
            let over = |evaluations: u64| evaluations >= limit || (clock.spent)(evaluations) >= clock.until;
            match separate(&mut self.layout, patience, &mut self.rng, over) {
                Outcome::Clear(pieces) if self.layout.task.keeps_cap(&pieces) => return Some(pieces),
                Outcome::Clear(_) => {
                    // Too much in one layer: worth to go on from, but for two parts that change places.
                    self.pool.insert(0, (0.0, self.layout.stands.clone()));
                    self.pool.truncate(POOL);
                    return None;
                }
                Outcome::Stuck(overlap, stands) => {
                    if stands.is_empty() || (clock.spent)(self.layout.evaluations) >= clock.until {
                        return None;
                    }
                    if overlap > self.nearly || relents == RELENTS {
                        let at = self.pool.partition_point(|(known, _)| *known <= overlap);
                        self.pool.insert(at, (overlap, stands));
                        self.pool.truncate(POOL);
                        return None;
                    }
                    lid_mm += 0.5 * (self.height_mm - lid_mm);
                    self.layout.lid_mm = lid_mm;
                    self.layout.load(&stands);
                    effort /= 2;
                }
            }
        }
        None
    }
}

/// A layout brought under a lower lid: everything above a random height comes down by what is to be gained.
fn squeezed(layout: &Layout<'_>, stands: &[Stand], gain_mm: f64, rng: &mut ChaCha8Rng) -> Vec<Stand> {
    let cut = rng.random_range(0.2..1.0) * layout.lid_mm;
    let lower = |stand: &Stand| Stand { place: stand.place.with_z(stand.place.z - gain_mm), ..*stand };
    stands.iter().map(|stand| if stand.place.z > cut { lower(stand) } else { *stand }).collect()
}

/// Puts every part anywhere: what finds no way out of the old order may find one from nowhere. Fixed parts stay.
fn scatter(layout: &mut Layout<'_>, rng: &mut ChaCha8Rng) {
    for part in 0..layout.len() {
        let stand = anywhere(layout, part, rng);
        layout.set(part, stand);
    }
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
