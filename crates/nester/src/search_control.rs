//! The interface between the caller and a running search: when to stop, and which solutions were found.

use super::NestingSolution;

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
pub trait StopCondition: Sync {
    /// Returns the share of the budget that is used up after `evaluations` evaluations. The search ends at 1 or above.
    /// A cancelled search returns `f64::INFINITY`. This must be cheap: it is called every few hundred microseconds.
    fn spent_share_at(&self, evaluations: u64) -> f64;
}

/// Is called for every better layout, with the number of evaluations made so far. A closure is one, and so is `()`, which hears nothing.
///
/// ```
/// use nester::{Listener, Solution};
///
/// let mut heights_mm = Vec::new();
/// let mut listener = |better: &Solution, _evaluations: u64| heights_mm.push(better.height_mm);
/// let _: &mut dyn Listener = &mut listener;
/// let _: &mut dyn Listener = &mut ();
/// ```
pub trait ProgressListener {
    /// `solution` places all copies, or places more copies than before, or places the same copies at a lower height.
    fn on_improved(&mut self, solution: &NestingSolution, evaluations: u64);
}

impl<F: FnMut(&NestingSolution, u64)> ProgressListener for F {
    fn on_improved(&mut self, solution: &NestingSolution, evaluations: u64) {
        self(solution, evaluations);
    }
}

impl ProgressListener for () {
    fn on_improved(&mut self, _solution: &NestingSolution, _evaluations: u64) {}
}
