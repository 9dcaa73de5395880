//! A wake-up without data: something changed in a hot folder, so look. What it misses (events are lost when the queue
//! overflows, folders are made faster than they are watched, network shares tell nothing), the periodic scan finds.

use std::{
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{SyncSender, sync_channel},
    },
    thread,
    time::Duration,
};

use notify::{
    Config, Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher as _,
    event::{AccessKind, AccessMode},
};
use thiserror::Error;

use super::ignore::{is_ignored, is_own};

/// At most one wake-up in this time: a thousand files that are copied in are one reason to look.
const MIN_GAP: Duration = Duration::from_millis(200);

/// Why there is no watch. The periodic scan goes on without it.
#[derive(Debug, Error)]
#[error("cannot watch the hot folders")]
pub struct WatchError(#[from] notify::Error);

/// Watches hot folders until it is dropped.
#[derive(Debug)]
pub struct Watcher {
    notify: RecommendedWatcher,
    roots: Vec<Root>,
    wake: SyncSender<()>,
}

#[derive(Debug)]
struct Root {
    path: PathBuf,
    /// Device and inode that are watched; a root that was made anew has others and would be silent for ever.
    watched: Option<(u64, u64)>,
}

impl Watcher {
    /// Watches `paths` with all their sub-folders and calls `wake` on a thread of its own after something changed, at
    /// most some times a second. A path that is not there yet is watched once [`Watcher::check`] finds it.
    pub fn start(paths: Vec<PathBuf>, wake: impl Fn() + Send + 'static) -> Result<Self, WatchError> {
        // One place: what happens while a wake-up is due is covered by it.
        let (sender, receiver) = sync_channel(1);
        thread::Builder::new()
            .name("hot-folder-wake".to_owned())
            .spawn(move || {
                while receiver.recv().is_ok() {
                    wake();
                    thread::sleep(MIN_GAP);
                }
            })
            .map_err(notify::Error::io)?;
        let roots: Arc<[PathBuf]> = paths.clone().into();
        let token = sender.clone();
        let notify = RecommendedWatcher::new(
            move |event: notify::Result<Event>| {
                if matters(&event, &roots) {
                    token.try_send(()).unwrap_or(());
                }
            },
            Config::default().with_follow_symlinks(false),
        )?;
        let roots = paths.into_iter().map(|path| Root { path, watched: None }).collect();
        let mut watcher = Self { notify, roots, wake: sender };
        watcher.check();
        Ok(watcher)
    }

    /// To be called at each periodic scan: watches paths that were made or made anew since. Returns those that cannot
    /// be watched now, with the reason in plain words.
    pub fn check(&mut self) -> Vec<(PathBuf, String)> {
        let mut troubles = Vec::new();
        for root in &mut self.roots {
            match root.check(&mut self.notify) {
                Ok(false) => {}
                // What was dropped before the watch stood made no event.
                Ok(true) => self.wake.try_send(()).unwrap_or(()),
                Err(why) => troubles.push((root.path.clone(), why)),
            }
        }
        troubles
    }
}

impl Root {
    /// Returns whether it is watched anew.
    fn check(&mut self, notify: &mut RecommendedWatcher) -> Result<bool, String> {
        let now = match identity(&self.path) {
            Ok(now) => now,
            Err(error) => {
                self.unwatch(notify);
                return Err(error.to_string());
            }
        };
        if self.watched == Some(now) {
            return Ok(false);
        }
        self.unwatch(notify);
        notify.watch(&self.path, RecursiveMode::Recursive).map_err(|error| error.to_string())?;
        self.watched = Some(now);
        Ok(true)
    }

    fn unwatch(&mut self, notify: &mut RecommendedWatcher) {
        if self.watched.take().is_some() {
            // It fails when the folder is gone, and the watch with it.
            let _ = notify.unwatch(&self.path);
        }
    }
}

fn identity(path: &Path) -> io::Result<(u64, u64)> {
    fs::metadata(path).map(|meta| (meta.dev(), meta.ino()))
}

/// Whether an event is a reason to look. Errors and lost events are. Reading is not, or each scan would cause the next;
/// nor is what nestd itself writes.
fn matters(event: &notify::Result<Event>, roots: &[PathBuf]) -> bool {
    let Ok(event) = event else { return true };
    let is_reading = matches!(event.kind, EventKind::Access(kind) if kind != AccessKind::Close(AccessMode::Write));
    if event.need_rescan() {
        return true;
    }
    !is_reading && (event.paths.is_empty() || event.paths.iter().any(|path| is_dropped(path, roots)))
}

/// Whether a path is one that a scan would list.
fn is_dropped(path: &Path, roots: &[PathBuf]) -> bool {
    let Some(below) = roots.iter().find_map(|root| path.strip_prefix(root).ok()) else { return true };
    let mut parts = below.iter();
    match (parts.next(), parts.next()) {
        (Some(name), None) => !is_own(name) && !is_ignored(name),
        _ => !below.iter().any(is_ignored),
    }
}

#[cfg(test)]
#[path = "watch_tests.rs"]
mod tests;
