//! How the outside world speaks with a running search: when to stop, and what has been found.

use super::Solution;

/// A budget. Implementations look at a clock, at an evaluation count, at a cancellation, or at all of them.
pub trait Stop: Sync {
    /// The share of the budget that is used up after so many evaluations; the search ends at 1 or above. A cancelled
    /// search answers `f64::INFINITY`. Cheap enough to be asked every few hundred microseconds.
    fn spent(&self, evaluations: u64) -> f64;
}

/// Hears of every better layout, with the evaluations made so far.
pub trait Listener {
    /// `solution` is complete or places more copies than before, or is lower at the same copies.
    fn improved(&mut self, solution: &Solution, evaluations: u64);
}

impl<F: FnMut(&Solution, u64)> Listener for F {
    fn improved(&mut self, solution: &Solution, evaluations: u64) {
        self(solution, evaluations);
    }
}
