//! A ready-made rule for when a search ends: after a time, after a number of evaluations, or when it is cancelled. This is the
//! only clock in the crate, and only a caller who asks for a time limit is ended by it; the search itself never looks at one.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use super::StopCondition;

/// What a search may cost: wall time, evaluations, or whichever of both ends first; counted from its construction. Clones share
/// one budget: another thread can cancel the search with one, or ask how far it is.
///
/// A limit on evaluations gives the same placements on every run; a limit on time does not.
///
/// ```
/// use nester::{SearchBudget, Stop};
///
/// let budget = SearchBudget::of_evaluations(2000).with_secs(3600.0);
/// assert_eq!(budget.spent(500), 0.25);
/// assert_eq!(budget.spent_share(), 0.25);
///
/// let from_elsewhere = budget.clone();
/// from_elsewhere.cancel();
/// assert_eq!(budget.spent(500), f64::INFINITY);
/// ```
#[derive(Debug, Clone)]
pub struct SearchBudget {
    began: Instant,
    time_limit: Option<Duration>,
    evaluation_limit: Option<u64>,
    shared: Arc<SharedProgress>,
}

/// What all clones of a budget know.
#[derive(Debug, Default)]
struct SharedProgress {
    is_cancelled: AtomicBool,
    /// The most evaluations that were told.
    evaluations: AtomicU64,
}

impl SearchBudget {
    /// No limit: ends when it is cancelled, or when the search knows that nothing can be lower.
    pub fn until_cancelled() -> Self {
        Self { began: Instant::now(), time_limit: None, evaluation_limit: None, shared: Arc::default() }
    }

    /// Ends after so many wall seconds from now; what is no positive number ends at once.
    pub fn of_secs(limit_secs: f64) -> Self {
        Self::until_cancelled().with_secs(limit_secs)
    }

    /// Ends after so many evaluations: looks at one part among its neighbours. How many of them a second holds depends on the
    /// meshes; a listener is told how many were made.
    pub fn of_evaluations(limit: u64) -> Self {
        Self::until_cancelled().with_evaluations(limit)
    }

    /// The same, which also ends so many wall seconds after it was made.
    #[must_use]
    pub fn with_secs(self, limit_secs: f64) -> Self {
        let limit = Duration::try_from_secs_f64(limit_secs);
        // More seconds than a clock counts are no limit; fewer than none, and what is no number, are none.
        let limit = limit.unwrap_or(if limit_secs > 0.0 { Duration::MAX } else { Duration::ZERO });
        Self { time_limit: Some(limit), ..self }
    }

    /// The same, which also ends after so many evaluations.
    #[must_use]
    pub fn with_evaluations(self, limit: u64) -> Self {
        Self { evaluation_limit: Some(limit), ..self }
    }

    /// Ends the search soon; what it has found so far is kept.
    pub fn cancel(&self) {
        self.shared.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Wall seconds since it was made.
    pub fn elapsed_secs(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Wall seconds until the time limit; 0 once it is passed, `None` without one.
    pub fn secs_left(&self) -> Option<f64> {
        self.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()).as_secs_f64())
    }

    /// Wall seconds by which the time limit is passed; 0 before it and without one.
    pub fn secs_over(&self) -> f64 {
        self.time_limit.map_or(0.0, |limit| self.began.elapsed().saturating_sub(limit).as_secs_f64())
    }

    /// The share that is spent, 0 to 1, as far as the search has told of its evaluations.
    pub fn spent_share(&self) -> f64 {
        self.share_at(self.shared.evaluations.load(Ordering::Relaxed)).min(1.0)
    }

    fn share_at(&self, evaluations: u64) -> f64 {
        if self.shared.is_cancelled.load(Ordering::Relaxed) {
            return f64::INFINITY;
        }
        let of_time = self.time_limit.map(|limit| share(self.began.elapsed().as_secs_f64(), limit.as_secs_f64()));
        let of_evaluations = self.evaluation_limit.map(|limit| share(evaluations as f64, limit as f64));
        of_time.into_iter().chain(of_evaluations).fold(0.0, f64::max)
    }
}

/// A limit of nothing is spent from the beginning.
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
    fn evaluations_are_a_share_and_the_most_that_were_told_count() {
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
