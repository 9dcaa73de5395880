//! A ready-made stop condition: it ends a search after a time, after a number of evaluations, or on cancellation. It
//! contains the only clock in the crate, which ends a search only if the caller sets a time limit. The search itself
//! never reads a clock.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use crate::StopCondition;

/// The limits of a search: wall time, evaluations, or both (the first one reached ends the search). Time counts from
/// the construction of the budget. Clones share one budget: another thread can use a clone to cancel the search or to
/// read its progress.
///
/// A limit on evaluations gives the same placements on every run. A limit on time does not.
///
/// ```
/// use nester::{SearchBudget, StopCondition};
///
/// let budget = SearchBudget::of_evaluations(2000).with_secs(3600.0);
/// assert_eq!(budget.spent_share_at(500), 0.25);
/// assert_eq!(budget.spent_share(), 0.25);
///
/// let from_elsewhere = budget.clone();
/// from_elsewhere.cancel();
/// assert_eq!(budget.spent_share_at(500), f64::INFINITY);
/// ```
#[derive(Debug, Clone)]
pub struct SearchBudget {
    began: Instant,
    time_limit: Option<Duration>,
    evaluation_limit: Option<u64>,
    shared: Arc<SharedProgress>,
}

/// The state that all clones of a budget share.
#[derive(Debug, Default)]
struct SharedProgress {
    is_cancelled: AtomicBool,
    /// The greatest number of evaluations reported so far.
    evaluations: AtomicU64,
}

impl SearchBudget {
    /// No limit: the search ends when it is cancelled, or when it knows that no lower layout exists.
    pub fn until_cancelled() -> Self {
        Self { began: Instant::now(), time_limit: None, evaluation_limit: None, shared: Arc::default() }
    }

    /// Ends `limit_secs` wall seconds from now. A limit that is not a positive number ends the search at once.
    pub fn of_secs(limit_secs: f64) -> Self {
        Self::until_cancelled().with_secs(limit_secs)
    }

    /// Ends after this number of evaluations. One evaluation checks one part against its neighbours. The number per
    /// second depends on the meshes. A progress listener receives the number made so far.
    pub fn of_evaluations(limit: u64) -> Self {
        Self::until_cancelled().with_evaluations(limit)
    }

    /// The same budget, which also ends `limit_secs` wall seconds after its construction.
    #[must_use]
    pub fn with_secs(self, limit_secs: f64) -> Self {
        let limit = Duration::try_from_secs_f64(limit_secs);
        // More seconds than a `Duration` can hold mean no limit. A negative number or NaN means a limit of zero.
        let limit = limit.unwrap_or(if limit_secs > 0.0 { Duration::MAX } else { Duration::ZERO });
        Self { time_limit: Some(limit), ..self }
    }

    /// The same budget, which also ends after this number of evaluations.
    #[must_use]
    pub fn with_evaluations(self, limit: u64) -> Self {
        Self { evaluation_limit: Some(limit), ..self }
    }

    /// Ends the search soon. The search still returns its best layout so far.
    pub fn cancel(&self) {
        self.shared.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`SearchBudget::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.shared.is_cancelled.load(Ordering::Relaxed)
    }

    /// Wall seconds since the construction of the budget.
    pub fn elapsed_secs(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Wall seconds until the time limit; 0 after the limit, `None` without a limit.
    pub fn secs_left(&self) -> Option<f64> {
        self.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()).as_secs_f64())
    }

    /// Wall seconds since the time limit; 0 before the limit or without one.
    pub fn secs_over(&self) -> f64 {
        self.time_limit.map_or(0.0, |limit| self.began.elapsed().saturating_sub(limit).as_secs_f64())
    }

    /// The used share of the budget, 0 to 1. For evaluations, this is the greatest number that the search has
    /// reported so far.
    pub fn spent_share(&self) -> f64 {
        self.share_at(self.shared.evaluations.load(Ordering::Relaxed)).min(1.0)
    }

    fn share_at(&self, evaluations: u64) -> f64 {
        if self.is_cancelled() {
            return f64::INFINITY;
        }
        let of_time = self.time_limit.map(|limit| share(self.began.elapsed().as_secs_f64(), limit.as_secs_f64()));
        let of_evaluations = self.evaluation_limit.map(|limit| share(evaluations as f64, limit as f64));
        of_time.into_iter().chain(of_evaluations).fold(0.0, f64::max)
    }
}

/// The used share of a limit. A limit of 0 is used up from the beginning.
fn share(used: f64, limit: f64) -> f64 {
    if limit > 0.0 { used / limit } else { 1.0 }
}

impl StopCondition for SearchBudget {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        if self.evaluation_limit.is_some() {
            self.shared.evaluations.fetch_max(evaluations, Ordering::Relaxed);
        }
        self.share_at(evaluations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evaluations_are_a_share_and_the_highest_reported_number_counts() {
        let budget = SearchBudget::of_evaluations(200);
        assert_eq!((budget.spent_share_at(50), budget.spent_share_at(20)), (0.25, 0.1));
        assert_eq!((budget.spent_share(), budget.secs_left()), (0.25, None));
        assert_eq!((budget.spent_share_at(500), budget.spent_share()), (2.5, 1.0));
    }

    #[test]
    fn time_passes_and_whichever_limit_comes_first_ends_it() {
        let budget = SearchBudget::of_secs(1e-9).with_evaluations(1_000_000);
        while budget.secs_over() == 0.0 {
            std::thread::yield_now();
        }
        assert!(budget.spent_share_at(0) >= 1.0 && budget.secs_left() == Some(0.0));
        let patient = SearchBudget::of_secs(1e9).with_evaluations(10);
        assert!(patient.spent_share_at(0) < 1e-3 && patient.secs_over() == 0.0);
        assert_eq!(patient.spent_share_at(10), 1.0);
    }

    #[test]
    fn a_limit_that_is_none_ends_at_once_and_an_endless_one_never() {
        for secs in [0.0, -1.0, f64::NAN] {
            assert!(SearchBudget::of_secs(secs).spent_share_at(0) >= 1.0, "{secs}");
        }
        assert_eq!(SearchBudget::of_evaluations(0).spent_share_at(0), 1.0);
        assert!(SearchBudget::of_secs(f64::INFINITY).spent_share_at(u64::MAX) < 1e-6);
        assert_eq!(SearchBudget::until_cancelled().spent_share_at(u64::MAX), 0.0);
    }

    #[test]
    fn whoever_holds_a_clone_can_cancel() {
        let budget = SearchBudget::of_secs(1000.0);
        assert!(budget.spent_share_at(0) < 1.0);
        budget.clone().cancel();
        assert_eq!((budget.spent_share_at(0), budget.spent_share()), (f64::INFINITY, 1.0));
    }
}
