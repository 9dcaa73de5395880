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

use crate::{SearchEnd, StopCondition};

/// A search that ends before this share of its budget has ended by itself.
const LEAST_USED_SHARE: f64 = 0.5;

/// The limits of a search: wall time, evaluations, patience, or several (the first one reached ends the search). Time
/// counts from the construction of the budget. Clones share one budget: another thread can use a clone to cancel the
/// search or to read its progress.
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
    patience: Option<Duration>,
    shared: Arc<SharedProgress>,
}

/// The state that all clones of a budget share.
#[derive(Debug)]
struct SharedProgress {
    is_cancelled: AtomicBool,
    /// Whether a search with patience has evaluated anything yet.
    is_evaluating: AtomicBool,
    /// Whether the patience was over.
    is_stalled: AtomicBool,
    /// The greatest number of evaluations reported so far.
    evaluations: AtomicU64,
    constructed: Instant,
    /// Nanoseconds from the construction to the last gain; 0 before. With patience, the first evaluation counts as one.
    gained_ns: AtomicU64,
}

impl SearchBudget {
    /// No limit: the search ends when it is cancelled, or when it knows that no lower layout exists.
    pub fn until_cancelled() -> Self {
        let began = Instant::now();
        let shared = SharedProgress {
            is_cancelled: AtomicBool::new(false),
            is_evaluating: AtomicBool::new(false),
            is_stalled: AtomicBool::new(false),
            evaluations: AtomicU64::new(0),
            constructed: began,
            gained_ns: AtomicU64::new(0),
        };
        Self { began, time_limit: None, evaluation_limit: None, patience: None, shared: Arc::new(shared) }
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
        Self { time_limit: Some(limit_of_secs(limit_secs)), ..self }
    }

    /// The same budget, which also ends when [`SearchBudget::record_gain`] was not called for `secs` wall seconds. What
    /// comes before the first evaluation does not count.
    #[must_use]
    pub fn with_patience(self, secs: f64) -> Self {
        Self { patience: Some(limit_of_secs(secs)), ..self }
    }

    /// A round of a longer search: it ends `secs` wall seconds from now, or with the whole budget.
    #[must_use]
    pub fn begin_round(&self, secs: f64) -> Self {
        Self { began: Instant::now(), time_limit: None, ..self.clone() }.with_secs(secs)
    }

    /// Tells that the search has found something better.
    pub fn record_gain(&self) {
        self.shared.gained_ns.store(self.shared.elapsed_ns(), Ordering::Relaxed);
    }

    /// Wall seconds since the last gain; 0 before. With patience, the first evaluation counts as one.
    pub fn idle_secs(&self) -> f64 {
        match self.shared.gained_ns.load(Ordering::Relaxed) {
            0 => 0.0,
            gained_ns => self.shared.elapsed_ns().saturating_sub(gained_ns) as f64 * 1e-9,
        }
    }

    /// Why a search with this budget has ended; `is_lowest` = its layout is as low as the lower bound.
    pub fn why_ended(&self, is_lowest: bool) -> SearchEnd {
        if is_lowest {
            SearchEnd::Lowest
        } else if self.is_cancelled() {
            SearchEnd::Stopped
        } else if let (Some(patience), true) = (self.patience, self.shared.is_stalled.load(Ordering::Relaxed)) {
            SearchEnd::Stalled { secs: patience.as_secs_f64() }
        } else if self.spent_share() < LEAST_USED_SHARE {
            SearchEnd::Exhausted
        } else {
            SearchEnd::Used { idle_secs: self.idle_secs() }
        }
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

    /// Whether nothing was gained for too long. The first evaluation starts the clock.
    fn is_patience_over(&self, evaluations: u64) -> bool {
        let Some(patience) = self.patience.filter(|_| evaluations > 0) else { return false };
        if !self.shared.is_evaluating.swap(true, Ordering::Relaxed) {
            self.record_gain();
        }
        let is_over = self.idle_secs() > patience.as_secs_f64();
        if is_over {
            self.shared.is_stalled.store(true, Ordering::Relaxed);
        }
        is_over
    }

    fn share_at(&self, evaluations: u64) -> f64 {
        if self.is_cancelled() || self.is_patience_over(evaluations) {
            return f64::INFINITY;
        }
        let of_time = self.time_limit.map(|limit| share(self.began.elapsed().as_secs_f64(), limit.as_secs_f64()));
        let of_evaluations = self.evaluation_limit.map(|limit| share(evaluations as f64, limit as f64));
        of_time.into_iter().chain(of_evaluations).fold(0.0, f64::max)
    }
}

impl SharedProgress {
    /// Nanoseconds since the construction, at least 1.
    fn elapsed_ns(&self) -> u64 {
        u64::try_from(self.constructed.elapsed().as_nanos()).unwrap_or(u64::MAX).max(1)
    }
}

/// More seconds than a `Duration` can hold mean no limit. A negative number or NaN means a limit of zero.
fn limit_of_secs(secs: f64) -> Duration {
    Duration::try_from_secs_f64(secs).unwrap_or(if secs > 0.0 { Duration::MAX } else { Duration::ZERO })
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
    fn patience_ends_a_search_that_gains_nothing_once_it_evaluates() {
        let wait = || std::thread::sleep(Duration::from_millis(30));
        let budget = SearchBudget::until_cancelled().with_patience(0.02);
        assert_eq!(budget.idle_secs(), 0.0);
        budget.record_gain();
        wait();
        assert_eq!(budget.spent_share_at(0), 0.0, "it still prepares");
        assert_eq!(budget.spent_share_at(1), 0.0, "the clock starts");
        wait();
        budget.record_gain();
        assert_eq!(budget.spent_share_at(2), 0.0);
        let round = budget.begin_round(1e9);
        assert!(round.spent_share_at(3) < 1e-3);
        wait();
        assert_eq!((round.spent_share_at(4), budget.spent_share_at(4)), (f64::INFINITY, f64::INFINITY));
        assert_eq!(budget.why_ended(false), SearchEnd::Stalled { secs: 0.02 });
        assert_eq!(budget.why_ended(true), SearchEnd::Lowest);
        assert_eq!(SearchBudget::of_secs(1e9).why_ended(false), SearchEnd::Exhausted);
        let used = SearchBudget::of_secs(0.0).with_patience(9.0);
        assert_eq!(used.why_ended(false), SearchEnd::Used { idle_secs: 0.0 });
    }

    #[test]
    fn whoever_holds_a_clone_can_cancel() {
        let budget = SearchBudget::of_secs(1000.0);
        assert!(budget.spent_share_at(0) < 1.0);
        budget.clone().cancel();
        assert_eq!((budget.spent_share_at(0), budget.spent_share()), (f64::INFINITY, 1.0));
    }
}
