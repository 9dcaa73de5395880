//! What failed for the disk's sake is tried again, each time after twice the wait: a full disk is a state, not a loop.

use std::{
    collections::HashMap,
    hash::Hash,
    time::{Duration, Instant},
};

use super::time_source::TimeSource;

/// After the first failure.
const FIRST: Duration = Duration::from_secs(1);
/// After many.
const LONGEST: Duration = Duration::from_secs(60);

/// The waits of things that failed, by what they are.
#[derive(Debug)]
pub struct BackOff<K> {
    waits: HashMap<K, (Instant, Duration)>,
    time: TimeSource,
}

impl<K> Default for BackOff<K> {
    fn default() -> Self {
        Self::by(TimeSource::default())
    }
}

impl<K> BackOff<K> {
    /// Waits that these clocks measure.
    pub fn by(time: TimeSource) -> Self {
        Self { waits: HashMap::new(), time }
    }
}

impl<K: Eq + Hash> BackOff<K> {
    /// Whether it failed and its wait is not over.
    pub fn rests(&self, what: &K) -> bool {
        self.waits.get(what).is_some_and(|(until, _)| self.time.instant() < *until)
    }

    /// Whether it failed when it was last tried.
    pub fn is_failing(&self, what: &K) -> bool {
        self.waits.contains_key(what)
    }

    /// It failed (again).
    pub fn failed(&mut self, what: K) {
        let wait = self.waits.get(&what).map_or(FIRST, |(_, wait)| (*wait * 2).min(LONGEST));
        self.waits.insert(what, (self.time.instant() + wait, wait));
    }

    /// How many failed when they were last tried.
    pub fn len(&self) -> usize {
        self.waits.len()
    }

    /// It was done.
    pub fn done(&mut self, what: &K) {
        self.waits.remove(what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_failure_doubles_the_wait_up_to_a_minute_and_success_ends_it() {
        let mut waits = BackOff::default();
        assert!(!waits.rests(&"a"));
        for secs in [1, 2, 4, 8, 16, 32, 60, 60] {
            waits.failed("a");
            assert!(waits.rests(&"a") && waits.waits["a"].1 == Duration::from_secs(secs));
        }
        assert!(!waits.rests(&"b"));
        waits.done(&"a");
        assert!(!waits.rests(&"a") && !waits.is_failing(&"a"));
    }
}
