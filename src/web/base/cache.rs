//! A small cache for results that pages request again.

use std::sync::{Mutex, PoisonError};

/// The most recent results by key. A key must change whenever its result changes.
#[derive(Debug)]
pub(crate) struct RecentCache<T> {
    entries: Mutex<Vec<(String, T)>>,
    capacity: usize,
}

impl<T: Clone> RecentCache<T> {
    /// An empty cache that keeps up to `most` results.
    pub(crate) fn new(most: usize) -> Self {
        Self { entries: Mutex::default(), capacity: most }
    }

    /// The result under a key.
    pub(crate) fn get(&self, key: &str) -> Option<T> {
        let kept = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(known, _)| known == key).map(|(_, thing)| thing.clone())
    }

    /// Adds a result and drops the oldest one beyond the limit.
    pub(crate) fn insert(&self, key: String, thing: T) {
        let mut kept = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(0, (key, thing));
        kept.truncate(self.capacity);
    }
}
