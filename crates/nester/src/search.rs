//! How the outside world speaks with a running search: when to stop, and what has been found.

use super::Solution;

/// A budget. Implementations look at a clock, at an evaluation count, at a cancellation, or at all of them; [`SearchBudget`] is
/// one that is ready made.
///
/// ```
/// use std::sync::atomic::{AtomicU64, Ordering};
/// use nester::Stop;
///
/// /// Ends after so many evaluations; the limit may be changed while the search runs.
/// struct Adjustable(AtomicU64);
///
/// impl Stop for Adjustable {
///     fn spent(&self, evaluations: u64) -> f64 {
///         evaluations as f64 / self.0.load(Ordering::Relaxed).max(1) as f64
///     }
/// }
/// # assert_eq!(Adjustable(AtomicU64::new(50_000)).spent(50_000), 1.0);
/// ```
///
/// [`SearchBudget`]: crate::SearchBudget
pub trait Stop: Sync {
    /// The share of the budget that is used up after so many evaluations; the search ends at 1 or above. A cancelled
    /// search answers `f64::INFINITY`. Cheap enough to be asked every few hundred microseconds.
    fn spent(&self, evaluations: u64) -> f64;
}

/// Hears of every better layout, with the evaluations made so far. A closure is one, and so is `()`, which hears nothing.
///
/// ```
/// use nester::{Listener, Solution};
///
/// let mut heights_mm = Vec::new();
/// let mut listener = |better: &Solution, _evaluations: u64| heights_mm.push(better.height_mm);
/// let _: &mut dyn Listener = &mut listener;
/// let _: &mut dyn Listener = &mut ();
/// ```
pub trait Listener {
    /// `solution` is complete or places more copies than before, or is lower at the same copies.
    fn improved(&mut self, solution: &Solution, evaluations: u64);
}

impl<F: FnMut(&Solution, u64)> Listener for F {
    fn improved(&mut self, solution: &Solution, evaluations: u64) {
        self(solution, evaluations);
    }
}

impl Listener for () {
    fn improved(&mut self, _solution: &Solution, _evaluations: u64) {}
}
