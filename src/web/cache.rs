//! What was made for a page and is asked for again.

use std::sync::{Mutex, PoisonError};

/// The last few things that were made, by a text that is another one when the thing is.
#[derive(Debug)]
pub(super) struct Cache<T> {
    kept: Mutex<Vec<(String, T)>>,
    most: usize,
}

impl<T: Clone> Cache<T> {
    /// An empty one that keeps so many things.
    pub(super) fn new(most: usize) -> Self {
        Self { kept: Mutex::default(), most }
    }

    /// A thing that is kept.
    pub(super) fn get(&self, key: &str) -> Option<T> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(known, _)| known == key).map(|(_, thing)| thing.clone())
    }

    /// Keeps a thing; the oldest goes.
    pub(super) fn put(&self, key: String, thing: T) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(0, (key, thing));
        kept.truncate(self.most);
    }
}
