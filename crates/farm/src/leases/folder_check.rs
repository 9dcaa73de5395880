//! Checks whether a folder is the expected one, for processes other than the daemon that serves it.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
    thread,
    time::{Duration, Instant},
};

use settings::{MachineFolders, Settings};

use super::{
    folder_lease::LeaseError,
    known_folders::known_identity,
    lease_clock,
    lease_holder::{FarmIdentity, LeaseHolder, find_place},
    lease_marker::{LeaseMarker, folder_identity, read_marker},
};

/// How often the markers are read while they are watched.
const WATCH_INTERVAL: Duration = Duration::from_millis(500);

/// Markers that this process has watched for the takeover delay without seeing a change: their daemons are dead.
static UNCHANGED: Mutex<Vec<LeaseHolder>> = Mutex::new(Vec::new());

/// Watches the folders that are marked by a daemon on another server, until it is clear which of these daemons are
/// alive. That takes as long as a takeover by a daemon; without such folders it takes no time.
pub fn watch_other_holders(settings: &Settings) {
    let mut watched: Vec<(PathBuf, LeaseHolder)> = Vec::new();
    for profile in settings.profiles.values() {
        let MachineFolders { inbox, queue: _, error, archive } = &profile.folders;
        for folder in [inbox, error, archive].map(PathBuf::as_path).into_iter().chain(profile.queue_folders()) {
            if let Err(LeaseError::HeldByOther { folder, holder }) = check_readable(&settings.state_dir, folder)
                && !holder.is_certainly_alive()
            {
                watched.push((folder, *holder));
            }
        }
    }
    let began = Instant::now();
    while !watched.is_empty() && began.elapsed() < lease_clock::takeover_delay() {
        thread::sleep(WATCH_INTERVAL.min(lease_clock::takeover_delay() / 4));
        watched.retain(|(folder, holder)| {
            read_marker(folder).is_ok_and(|mark| mark == LeaseMarker::HeldBy(Box::new(holder.clone())))
        });
    }
    let mut unchanged = UNCHANGED.lock().unwrap_or_else(PoisonError::into_inner);
    unchanged.extend(watched.into_iter().map(|(_, holder)| holder));
}

fn is_known_unchanged(holder: &LeaseHolder) -> bool {
    UNCHANGED.lock().unwrap_or_else(PoisonError::into_inner).contains(holder)
}

/// Checks that a folder can be read, and that this farm has served it or never knew it. The contents of any other
/// folder say nothing; it must not be taken for an empty one. Works with and without a running daemon.
///
/// # Errors
/// The folder is missing or cannot be read; its marker is missing although it had one; or another daemon serves it.
pub fn check_readable(state_dir: &Path, folder: &Path) -> Result<(), LeaseError> {
    let io = |source| LeaseError::Io { folder: folder.to_owned(), why: source };
    let now = folder_identity(folder).map_err(io)?;
    fs::read_dir(folder).map_err(io)?;
    match read_marker(folder).map_err(io)? {
        LeaseMarker::NoHolder => Ok(()),
        LeaseMarker::Missing if known_identity(state_dir, folder).is_none_or(|was| was == now) => Ok(()),
        LeaseMarker::Missing => Err(LeaseError::Replaced(folder.to_owned())),
        LeaseMarker::HeldBy(holder)
            if holder.belongs_to_state_dir(state_dir) || !holder.may_be_alive() || is_known_unchanged(&holder) =>
        {
            Ok(())
        }
        LeaseMarker::HeldBy(holder) => Err(LeaseError::HeldByOther { folder: folder.to_owned(), holder }),
    }
}

impl LeaseHolder {
    /// Whether this is the farm of the state directory, even if the farm's id was lost with it, or shares its ledger.
    pub(crate) fn belongs_to_state_dir(&self, state_dir: &Path) -> bool {
        let is_same_path = fs::canonicalize(state_dir).is_ok_and(|own| own == *self.state_dir());
        // A container has another host name, and may have another path.
        let is_same_place = !self.place.is_empty() && find_place(state_dir).is_ok_and(|place| place == self.place);
        let is_of_shared_ledger = FarmIdentity::read(state_dir).is_ok_and(|known| {
            known.is_some_and(|own| !own.database.is_empty() && (&own.id, &own.database) == (&self.farm, &self.place))
        });
        is_of_shared_ledger || is_same_place || is_same_path && self.is_on_this_host()
    }
}
