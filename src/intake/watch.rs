//! A wake-up without data: something changed in a hot folder, so look. What it misses (events are lost when the queue
//! overflows, folders are made faster than they are watched, network shares tell nothing), the periodic scan finds.

use std::{
    collections::HashSet,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{SyncSender, sync_channel},
    },
    thread,
    time::Duration,
};

use notify::{
    Config, ErrorKind, Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher as _,
    event::{AccessKind, AccessMode, CreateKind, ModifyKind, RenameMode},
};
use thiserror::Error;
use tracing::debug;

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
    folders: Arc<Mutex<Folders>>,
    roots: Vec<Root>,
    wake: SyncSender<()>,
}

#[derive(Debug)]
struct Root {
    path: PathBuf,
    /// Device and inode that are watched; a root that was made anew has others and would be silent for ever.
    watched: Option<(u64, u64)>,
}

/// The folders that are watched, each by itself: a recursive watch would watch every claim, too, of which there may be
/// thousands a minute.
#[derive(Debug)]
struct Folders {
    notify: RecommendedWatcher,
    watched: HashSet<PathBuf>,
}

impl Folders {
    /// Watches a folder and those below it that a scan would list.
    fn add(&mut self, folder: &Path) -> notify::Result<()> {
        self.notify.watch(folder, RecursiveMode::NonRecursive)?;
        self.watched.insert(folder.to_owned());
        // What was made in it before the watch stood made no event.
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) && !is_ignored(&entry.file_name()) {
                match self.add(&entry.path()) {
                    // It may be gone or taken already.
                    Err(error) if matches!(error.kind, ErrorKind::PathNotFound | ErrorKind::Io(_)) => {}
                    other => other?,
                }
            }
        }
        Ok(())
    }

    fn remove(&mut self, folder: &Path) {
        for below in self.watched.extract_if(|watched| watched.starts_with(folder)) {
            // It fails when the folder is gone, and the watch with it.
            let _ = self.notify.unwatch(&below);
        }
    }

    /// Forgets folders that are gone; their watches went with them.
    fn forget_gone(&mut self) {
        self.watched.retain(|folder| folder.is_dir());
    }
}

impl Watcher {
    /// Watches `paths` with all their sub-folders and calls `wake` on a thread of its own after something changed, at
    /// most some times a second. A path that is not there yet is watched once [`Watcher::check`] finds it.
    pub fn start(paths: Vec<PathBuf>, wake: impl Fn() + Send + 'static) -> Result<Self, WatchError> {
        // One place: what happens while a wake-up is due is covered by it.
        let (sender, receiver) = sync_channel(1);
        let made = Arc::new(Mutex::new(Vec::new()));
        let roots: Arc<[PathBuf]> = paths.clone().into();
        let (token, new) = (sender.clone(), made.clone());
        let notify = RecommendedWatcher::new(
            move |event: notify::Result<Event>| {
                if matters(&event, &roots) {
                    lock(&new).extend(event.into_iter().filter(makes_a_name).flat_map(|event| event.paths));
                    token.try_send(()).unwrap_or(());
                }
            },
            Config::default().with_follow_symlinks(false),
        )?;
        let folders = Arc::new(Mutex::new(Folders { notify, watched: HashSet::new() }));
        // The thread ends with the watcher, which must not live on for the thread's sake.
        let watched = Arc::downgrade(&folders);
        thread::Builder::new()
            .name("hot-folder-wake".to_owned())
            .spawn(move || {
                while receiver.recv().is_ok() {
                    let Some(folders) = watched.upgrade() else { return };
                    // Not locked while it is worked at: the thread that fills it is the one that makes watches.
                    let new_folders = std::mem::take(&mut *lock(&made));
                    watch_made(&folders, new_folders);
                    drop(folders);
                    wake();
                    thread::sleep(MIN_GAP);
                }
            })
            .map_err(notify::Error::io)?;
        let roots = paths.into_iter().map(|path| Root { path, watched: None }).collect();
        let mut watcher = Self { folders, roots, wake: sender };
        watcher.check();
        Ok(watcher)
    }

    /// To be called at each periodic scan: watches paths that were made or made anew since. Returns those that cannot
    /// be watched now, with the reason in plain words.
    pub fn check(&mut self) -> Vec<(PathBuf, String)> {
        let mut troubles = Vec::new();
        let mut folders = lock(&self.folders);
        folders.forget_gone();
        for root in &mut self.roots {
            match root.check(&mut folders) {
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
    fn check(&mut self, folders: &mut Folders) -> Result<bool, String> {
        let now = match identity(&self.path) {
            Ok(now) => now,
            Err(error) => {
                self.watched = None;
                folders.remove(&self.path);
                return Err(error.to_string());
            }
        };
        if self.watched == Some(now) {
            return Ok(false);
        }
        folders.remove(&self.path);
        folders.add(&self.path).map_err(|error| error.to_string())?;
        self.watched = Some(now);
        Ok(true)
    }
}

/// Watches the folders among what was made; files that stand in them already are found by the look that follows.
fn watch_made(folders: &Mutex<Folders>, made: Vec<PathBuf>) {
    let is_folder = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|meta| meta.is_dir());
    for folder in made.into_iter().filter(is_folder) {
        if let Err(error) = lock(folders).add(&folder) {
            debug!("No file-system events from {}: {error}.", folder.display());
        }
    }
}

/// Whether an event gives something a name: only then it may be a new folder.
fn makes_a_name(event: &Event) -> bool {
    match event.kind {
        EventKind::Create(kind) => kind != CreateKind::File,
        EventKind::Modify(ModifyKind::Name(mode)) => mode != RenameMode::From,
        _ => false,
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
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
