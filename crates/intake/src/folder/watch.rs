//! Watches the hot folders and wakes the daemon when something changed. The wake-up carries no data. The periodic scan
//! finds what the watcher misses: events lost when the queue overflows, folders created faster than they are watched,
//! and network shares that send no events.

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

use super::ignore::{is_ignored, is_status_file};

/// Minimum time between two wake-ups: a thousand copied files need only one scan.
const MIN_GAP: Duration = Duration::from_millis(200);

/// Why the folders cannot be watched. The periodic scan works without it.
#[derive(Debug, Error)]
#[error("cannot watch the hot folders")]
pub struct WatchError(#[from] notify::Error);

/// Watches hot folders until it is dropped.
#[derive(Debug)]
pub struct InboxWatcher {
    folders: Arc<Mutex<WatchedFolders>>,
    roots: Vec<WatchedRoot>,
    wake: SyncSender<()>,
}

#[derive(Debug)]
struct WatchedRoot {
    path: PathBuf,
    /// Device and inode of the watched folder. If the folder is created again, they differ, and the old watch would
    /// never report anything.
    watched: Option<(u64, u64)>,
}

/// The watched folders, each with its own watch. A recursive watch would also cover the claims, of which there may be
/// thousands a minute.
#[derive(Debug)]
struct WatchedFolders {
    notify: RecommendedWatcher,
    watched: HashSet<PathBuf>,
}

impl WatchedFolders {
    /// Watches a folder and the sub-folders that a scan would list.
    fn watch_folder(&mut self, folder: &Path) -> notify::Result<()> {
        self.notify.watch(folder, RecursiveMode::NonRecursive)?;
        self.watched.insert(folder.to_owned());
        // Folders created in it before the watch was active caused no event.
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) && !is_ignored(&entry.file_name()) {
                match self.watch_folder(&entry.path()) {
                    // The folder may have been removed or claimed already.
                    Err(error) if matches!(error.kind, ErrorKind::PathNotFound | ErrorKind::Io(_)) => {}
                    other => other?,
                }
            }
        }
        Ok(())
    }

    fn unwatch_folder(&mut self, folder: &Path) {
        for below in self.watched.extract_if(|watched| watched.starts_with(folder)) {
            // This fails if the folder is gone; its watch is then gone too.
            let _ = self.notify.unwatch(&below);
        }
    }

    /// Forgets removed folders; their watches ended with them.
    fn forget_removed(&mut self) {
        self.watched.retain(|folder| folder.is_dir());
    }
}

impl InboxWatcher {
    /// Watches `paths` with all their sub-folders and calls `wake` on its own thread after something changed, at most a
    /// few times per second. A path that does not exist yet is watched once [`InboxWatcher::check_roots`] finds it.
    pub fn start(paths: Vec<PathBuf>, wake: impl Fn() + Send + 'static) -> Result<Self, WatchError> {
        // A channel of capacity one: a pending wake-up covers all changes until it is received.
        let (sender, receiver) = sync_channel(1);
        let made = Arc::new(Mutex::new(Vec::new()));
        let roots: Arc<[PathBuf]> = paths.clone().into();
        let (token, new) = (sender.clone(), made.clone());
        let notify = RecommendedWatcher::new(
            move |event: notify::Result<Event>| {
                if is_relevant(&event, &roots) {
                    lock_mutex(&new).extend(event.into_iter().filter(creates_name).flat_map(|event| event.paths));
                    token.try_send(()).unwrap_or(());
                }
            },
            Config::default().with_follow_symlinks(false),
        )?;
        let folders = Arc::new(Mutex::new(WatchedFolders { notify, watched: HashSet::new() }));
        // The thread ends with the watcher and must not keep it alive.
        let watched = Arc::downgrade(&folders);
        thread::Builder::new()
            .name("hot-folder-wake".to_owned())
            .spawn(move || {
                while receiver.recv().is_ok() {
                    let Some(folders) = watched.upgrade() else { return };
                    // The lock is not held during the work, because the thread that fills the list also adds watches.
                    let new_folders = std::mem::take(&mut *lock_mutex(&made));
                    watch_new_folders(&folders, new_folders);
                    drop(folders);
                    wake();
                    thread::sleep(MIN_GAP);
                }
            })
            .map_err(notify::Error::io)?;
        let roots = paths.into_iter().map(|path| WatchedRoot { path, watched: None }).collect();
        let mut watcher = Self { folders, roots, wake: sender };
        watcher.check_roots();
        Ok(watcher)
    }

    /// Call this at each periodic scan. It watches paths that were created or replaced since the last call. Returns the
    /// paths that cannot be watched now, with the reason in plain words.
    pub fn check_roots(&mut self) -> Vec<(PathBuf, String)> {
        let mut troubles = Vec::new();
        let mut folders = lock_mutex(&self.folders);
        folders.forget_removed();
        for root in &mut self.roots {
            match root.rewatch_if_replaced(&mut folders) {
                Ok(false) => {}
                // Files dropped before the watch was active caused no event.
                Ok(true) => self.wake.try_send(()).unwrap_or(()),
                Err(why) => troubles.push((root.path.clone(), why)),
            }
        }
        troubles
    }
}

impl WatchedRoot {
    /// Watches the folder if it is new or was replaced. Returns whether it did.
    fn rewatch_if_replaced(&mut self, folders: &mut WatchedFolders) -> Result<bool, String> {
        let now = match device_and_inode(&self.path) {
            Ok(now) => now,
            Err(error) => {
                self.watched = None;
                folders.unwatch_folder(&self.path);
                return Err(error.to_string());
            }
        };
        if self.watched == Some(now) {
            return Ok(false);
        }
        folders.unwatch_folder(&self.path);
        folders.watch_folder(&self.path).map_err(|error| error.to_string())?;
        self.watched = Some(now);
        Ok(true)
    }
}

/// Watches the folders among the created paths. Files that are already in them are found by the following scan.
fn watch_new_folders(folders: &Mutex<WatchedFolders>, made: Vec<PathBuf>) {
    let is_folder = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|meta| meta.is_dir());
    for folder in made.into_iter().filter(is_folder) {
        if let Err(error) = lock_mutex(folders).watch_folder(&folder) {
            debug!("No file-system events from {}: {error}.", folder.display());
        }
    }
}

/// Whether an event creates a name: only then can it be a new folder.
fn creates_name(event: &Event) -> bool {
    match event.kind {
        EventKind::Create(kind) => kind != CreateKind::File,
        EventKind::Modify(ModifyKind::Name(mode)) => mode != RenameMode::From,
        _ => false,
    }
}

fn lock_mutex<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

fn device_and_inode(path: &Path) -> io::Result<(u64, u64)> {
    fs::metadata(path).map(|meta| (meta.dev(), meta.ino()))
}

/// Whether an event requires a scan. Errors and lost events do. Reading does not, or each scan would cause the next
/// one. Neither do the files that nestd itself writes.
fn is_relevant(event: &notify::Result<Event>, roots: &[PathBuf]) -> bool {
    let Ok(event) = event else { return true };
    let is_reading = matches!(event.kind, EventKind::Access(kind) if kind != AccessKind::Close(AccessMode::Write));
    if event.need_rescan() {
        return true;
    }
    !is_reading && (event.paths.is_empty() || event.paths.iter().any(|path| is_scanned_path(path, roots)))
}

/// Whether a scan would list this path.
fn is_scanned_path(path: &Path, roots: &[PathBuf]) -> bool {
    let Some(below) = roots.iter().find_map(|root| path.strip_prefix(root).ok()) else { return true };
    let mut parts = below.iter();
    match (parts.next(), parts.next()) {
        (Some(name), None) => !is_status_file(name) && !is_ignored(name),
        _ => !below.iter().any(is_ignored),
    }
}

#[cfg(test)]
#[path = "tests/watch_tests.rs"]
mod tests;
