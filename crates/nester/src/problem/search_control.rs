//! The interface between the caller and a running search: when to stop, and which solutions are found.

use crate::NestingSolution;

/// Decides when a search ends. Implementations may use a clock, an evaluation count, a cancellation flag, or all of
/// them. [`SearchBudget`] is a ready-made implementation.
///
/// ```
/// use std::sync::atomic::{AtomicU64, Ordering};
/// use nester::StopCondition;
///
/// /// Ends after this number of evaluations; the limit may be changed while the search runs.
/// struct Adjustable(AtomicU64);
///
/// impl StopCondition for Adjustable {
///     fn spent_share_at(&self, evaluations: u64) -> f64 {
///         evaluations as f64 / self.0.load(Ordering::Relaxed).max(1) as f64
///     }
/// }
/// # assert_eq!(Adjustable(AtomicU64::new(50_000)).spent_share_at(50_000), 1.0);
/// ```
///
/// [`SearchBudget`]: crate::SearchBudget
pub trait StopCondition: Sync {
    /// Returns the share of the budget that is used up after `evaluations` evaluations. The search ends at 1 or
    /// above. Return `f64::INFINITY` to cancel the search. This must be fast: it is called every few hundred
    /// microseconds.
    fn spent_share_at(&self, evaluations: u64) -> f64;
}

/// Receives every better layout, with the number of evaluations made so far. Closures implement this trait. `()`
/// implements it too and ignores all calls.
///
/// ```
/// use nester::{ProgressListener, NestingSolution};
///
/// let mut heights_mm = Vec::new();
/// let mut listener = |better: &NestingSolution, _evaluations: u64| heights_mm.push(better.height_mm);
/// let _: &mut dyn ProgressListener = &mut listener;
/// let _: &mut dyn ProgressListener = &mut ();
/// ```
pub trait ProgressListener {
    /// Called for every better layout: `solution` places all copies, or more copies than before, or the same copies
    /// at a lower height. If not all copies fit, the last layouts may place fewer copies than before, but those of
    /// higher precedence.
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
