//! Retries with exponential backoff after disk failures: a full disk is a lasting state and must not cause a busy loop.

use std::{
    collections::HashMap,
    hash::Hash,
    time::{Duration, Instant},
};

use super::time_source::TimeSource;

/// Wait after the first failure.
const FIRST_WAIT: Duration = Duration::from_secs(1);
/// Maximum wait.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// Waiting times of failed operations, by key.
#[derive(Debug)]
pub struct RetryBackoff<K> {
    waits: HashMap<K, (Instant, Duration)>,
    time: TimeSource,
}

impl<K> Default for RetryBackoff<K> {
    fn default() -> Self {
        Self::by(TimeSource::default())
    }
}

impl<K> RetryBackoff<K> {
    /// Waits that these clocks measure.
    pub fn by(time: TimeSource) -> Self {
        Self { waits: HashMap::new(), time }
    }
}

impl<K: Eq + Hash> RetryBackoff<K> {
    /// Whether the operation failed and its wait is not over.
    pub fn is_waiting(&self, what: &K) -> bool {
        self.waits.get(what).is_some_and(|(until, _)| self.time.instant() < *until)
    }

    /// Whether the last attempt failed.
    pub fn is_failing(&self, what: &K) -> bool {
        self.waits.contains_key(what)
    }

    /// Records a failure and doubles the wait.
    pub fn record_failure(&mut self, what: K) {
        let wait = self.waits.get(&what).map_or(FIRST_WAIT, |(_, wait)| (*wait * 2).min(LONGEST_WAIT));
        self.waits.insert(what, (self.time.instant() + wait, wait));
    }

    /// What made the operations fail is over: each is tried at once, and waits as after a first failure if it fails again.
    pub fn end_waits(&mut self) {
        let now = self.time.instant();
        self.waits.values_mut().for_each(|wait| *wait = (now, FIRST_WAIT / 2));
    }

    /// Number of operations whose last attempt failed.
    pub fn len(&self) -> usize {
        self.waits.len()
    }

    /// Whether none failed.
    pub fn is_empty(&self) -> bool {
        self.waits.is_empty()
    }

    /// Records a success and ends the wait.
    pub fn record_success(&mut self, what: &K) {
        self.waits.remove(what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_failure_doubles_the_wait_up_to_a_minute_and_success_ends_it() {
        let mut waits = RetryBackoff::default();
        assert!(!waits.is_waiting(&"a"));
        for secs in [1, 2, 4, 8, 16, 32, 60, 60] {
            waits.record_failure("a");
            assert!(waits.is_waiting(&"a") && waits.waits["a"].1 == Duration::from_secs(secs));
        }
        assert!(!waits.is_waiting(&"b"));
        waits.end_waits();
        assert!(!waits.is_waiting(&"a") && waits.is_failing(&"a"));
        waits.record_failure("a");
        assert!(waits.waits["a"].1 == FIRST_WAIT);
        waits.record_success(&"a");
        assert!(!waits.is_waiting(&"a") && !waits.is_failing(&"a"));
    }
}
