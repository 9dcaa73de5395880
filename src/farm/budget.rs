//! The clock of a search: wall seconds, a cancellation, or both.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use nester::Stop;

/// A search may end so much after its time before others begin beside it.
const OVERDUE: Duration = Duration::from_secs(2);

/// A budget of wall seconds that can be cancelled from another thread.
#[derive(Debug, Clone)]
pub struct Budget {
    began: Instant,
    limit: Duration,
    cancelled: Arc<AtomicBool>,
}

impl Budget {
    /// Starts now and ends after `limit_secs` seconds.
    pub fn starting_now(limit_secs: f64) -> Self {
        Self {
            began: Instant::now(),
            limit: Duration::from_secs_f64(limit_secs.clamp(0.001, 1e9)),
            cancelled: Arc::default(),
        }
    }

    /// Ends the search soon; what it has found so far counts.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the search goes on although its time was over a while ago: it must not keep others from theirs.
    pub fn is_overdue(&self) -> bool {
        self.began.elapsed() > self.limit + OVERDUE
    }

    /// Wall seconds since the start.
    pub fn elapsed_secs(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }
}

impl Stop for Budget {
    fn spent(&self, _evaluations: u64) -> f64 {
        if self.cancelled.load(Ordering::Relaxed) {
            return f64::INFINITY;
        }
        self.began.elapsed().as_secs_f64() / self.limit.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cancelled_budget_is_spent_at_once() {
        let budget = Budget::starting_now(1000.0);
        assert!(budget.spent(0) < 1.0);
        budget.clone().cancel();
        assert_eq!(budget.spent(0), f64::INFINITY);
    }
}
