//! Leases on the folders of a machine: hot folder, queue, archive, error folder. Two daemons with different ledgers on
//! one folder would each take half of the parts and overwrite each other's files, and locks do not work on every share.
//! So a daemon writes its name into `.nestd-owner` and keeps changing a number there as long as it lives. A daemon that
//! finds another name there checks whether the other one is alive: on its own server by the lock, on another server by
//! whether the number changes.
//!
//! The same file shows whether an empty directory is an unmounted share or a folder that somebody emptied; `served`
//! knows across restarts which folders had one.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Write},
    os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt},
    path::{Path, PathBuf},
    time::Instant,
};

use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    known_folders,
    lease_clock::{LeaseTimestamp, takeover_delay},
    state_lock,
};

/// Name of the marker in each folder: a dot-file, which no scan and no printer takes.
pub(super) const NAME: &str = ".nestd-owner";
/// Name of the file with the farm's id in the state directory.
pub const FARM_ID_FILE: &str = "nestd.farm";
/// Fixed length of the marker, so that a renewal is a single write that never shortens it.
const BYTES: usize = 1024;

/// A daemon, as named in its marker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseHolder {
    /// Id of its farm: a random number in its state directory.
    farm: String,
    /// Name of its server.
    host: String,
    /// Its state directory.
    state_dir: PathBuf,
    /// Process id.
    pid: u32,
    /// Start time.
    since: Timestamp,
    /// Changes as long as the daemon lives.
    beat: u64,
    /// The daemon has stopped in order.
    stopped: bool,
}

/// Why a folder cannot be used.
#[derive(Debug, Error)]
pub enum LeaseError {
    /// Another daemon serves it.
    #[error(
        "{} is served by another nestd: process {} on {} since {}, with the state folder {}. Stop that one, or give each \
         farm folders of its own",
        .folder.display(), .holder.pid, .holder.host, .holder.since.strftime("%Y-%m-%d %H:%M:%S UTC"), .holder.state_dir.display()
    )]
    HeldByOther {
        /// The folder.
        folder: PathBuf,
        /// The other daemon.
        holder: Box<LeaseHolder>,
    },
    /// The marker names another daemon, and it is not clear yet whether that one is alive.
    #[error("{} is marked by process {} on {}: checking if it is alive", .folder.display(), .holder.pid, .holder.host)]
    HolderUnclear {
        /// The folder.
        folder: PathBuf,
        /// The other daemon.
        holder: Box<LeaseHolder>,
    },
    /// It is another directory than before and has no marker: an empty mount point.
    #[error(
        "{} is not the folder that was there before: its marker {NAME} is missing. Mount it again; if it was replaced or \
         emptied on purpose: touch {}", .0.display(), .0.join(NAME).display()
    )]
    Replaced(PathBuf),
    /// Files of the parts are still claimed, by this farm or by one that took them over.
    #[error("{claims} claims in {} are not released yet", .folder.display())]
    ClaimsNotReleased {
        /// The hot folder.
        folder: PathBuf,
        /// Number of claims.
        claims: usize,
    },
    /// A system call failed.
    #[error("{} cannot be used: {why}", .folder.display())]
    Io {
        /// The folder.
        folder: PathBuf,
        /// The error of the system. The message contains it already, so it is not given as a source.
        why: io::Error,
    },
}

/// This daemon's lease on one folder.
#[derive(Debug, Clone)]
pub struct FolderLease {
    holder: LeaseHolder,
    folder: PathBuf,
    /// Device and inode of the directory when this daemon held it.
    held_identity: Option<(u64, u64)>,
    /// The next start knows from the state folder that this farm served it.
    is_remembered: bool,
    /// The marker of another daemon, and since when it has not changed.
    other_holder: Option<(LeaseHolder, Instant)>,
}

/// What the marker of a folder says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LeaseMarker {
    /// There is no marker.
    Missing,
    /// The marker names no daemon: a person has accepted the folder as it is, or a crash tore the file.
    NoHolder,
    /// The daemon that served the folder last.
    HeldBy(Box<LeaseHolder>),
}

impl LeaseHolder {
    /// Id of its farm.
    pub fn farm_id(&self) -> &str {
        &self.farm
    }

    /// The daemon of this process.
    pub fn for_this_process(state_dir: &Path, since: Timestamp) -> io::Result<Self> {
        let farm = read_or_create_farm_id(state_dir)?;
        let state_dir = fs::canonicalize(state_dir)?;
        Ok(Self {
            farm,
            host: state_lock::host_name(),
            state_dir,
            pid: std::process::id(),
            since,
            beat: 0,
            stopped: false,
        })
    }

    /// Whether the state directory has a farm id.
    pub(super) fn has_farm_id(state_dir: &Path) -> bool {
        state_dir.join(FARM_ID_FILE).exists()
    }

    /// Its state directory.
    pub(super) fn state_dir(&self) -> &Path {
        &self.state_dir
    }

    /// Whether the daemon ran on this server.
    pub(super) fn is_on_this_host(&self) -> bool {
        self.host == state_lock::host_name()
    }

    /// Whether the daemon may be alive, as far as this can be decided at once: it has not stopped, and it holds its
    /// lock or is on another server.
    pub(super) fn may_be_alive(&self) -> bool {
        !(self.stopped || self.is_on_this_host() && self.is_state_lock_held() == Some(false))
    }

    /// Whether both are the same farm: this process holds the lock of its state directory, so an earlier daemon of it
    /// is dead. A copied state directory, or one that was moved to another server, is another farm.
    fn is_same_farm(&self, other: &Self) -> bool {
        (&self.farm, &self.host, &self.state_dir) == (&other.farm, &other.host, &other.state_dir)
    }

    /// Whether the daemon holds the lock of its state directory; `None` = this cannot be decided from here. (Containers
    /// may share the name of their server and each have a folder of their own under the same path.)
    fn holds_state_lock(&self, asks: &Self) -> Option<bool> {
        if self.host != asks.host || self.state_dir == asks.state_dir {
            return None;
        }
        self.is_state_lock_held()
    }

    fn is_state_lock_held(&self) -> Option<bool> {
        let nofollow = (rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK).bits();
        let path = self.state_dir.join(state_lock::NAME);
        let file = OpenOptions::new().read(true).custom_flags(nofollow as i32).open(path).ok()?;
        match flock(&file, FlockOperation::NonBlockingLockShared) {
            Ok(()) => Some(false),
            Err(rustix::io::Errno::WOULDBLOCK) => Some(true),
            Err(_) => None,
        }
    }
}

impl FolderLease {
    /// A lease that is not acquired yet.
    pub fn new(me: LeaseHolder, folder: &Path) -> Self {
        Self { holder: me, folder: folder.to_owned(), held_identity: None, is_remembered: false, other_holder: None }
    }

    /// Path of the folder.
    pub fn folder_path(&self) -> &Path {
        &self.folder
    }

    /// Id of this farm.
    pub fn farm_id(&self) -> &str {
        &self.holder.farm
    }

    /// Checks that the marker names this farm right now, so that the next operation does not work in another farm's
    /// folder.
    pub fn check_held(&self) -> Result<(), LeaseError> {
        let folder = self.folder.clone();
        match read_marker(&self.folder).map_err(|source| self.io_error(source))? {
            LeaseMarker::HeldBy(holder) if self.holder.is_same_farm(&holder) => Ok(()),
            LeaseMarker::HeldBy(holder) => Err(LeaseError::HeldByOther { folder, holder }),
            LeaseMarker::Missing | LeaseMarker::NoHolder => Err(LeaseError::Replaced(folder)),
        }
    }

    /// Whether both leases are on the same folder.
    pub fn is_same_folder(&self, other: &Self) -> bool {
        self.folder == other.folder
    }

    /// Whether the folder was never served: then it may be created. If a served folder is missing, an empty directory
    /// in its place would be in the way of whoever mounts it again.
    pub fn was_never_served(&self) -> bool {
        self.held_identity.is_none() && !known_folders::is_known_folder(&self.holder.state_dir, &self.folder)
    }

    /// Device and inode of the folder when this run held it; `None` = it never did.
    pub fn held_identity(&self) -> Option<(u64, u64)> {
        self.held_identity
    }

    /// Acquires the lease or renews it. Call this at every renewal interval.
    pub fn renew(&mut self) -> Result<(), LeaseError> {
        let checked_at = LeaseTimestamp::now();
        self.check_usable()?;
        self.holder.beat += 1;
        write_marker(&self.folder, &self.holder, checked_at).map_err(|source| self.io_error(source))?;
        let now = folder_identity(&self.folder).map_err(|source| self.io_error(source))?;
        if !self.is_remembered || self.held_identity != Some(now) {
            // On a full disk the folder is used anyway; the next renewal tries again.
            self.is_remembered = known_folders::remember_folder(&self.holder.state_dir, &self.folder, now).is_ok();
        }
        self.held_identity = Some(now);
        Ok(())
    }

    /// Checks that the folder may be used: it is available, it is the same as before, and no other daemon serves it.
    pub fn check_usable(&mut self) -> Result<(), LeaseError> {
        let now = folder_identity(&self.folder).map_err(|source| self.io_error(source))?;
        let holder = match read_marker(&self.folder).map_err(|source| self.io_error(source))? {
            LeaseMarker::HeldBy(holder) => *holder,
            mark => {
                self.other_holder = None;
                return match self.is_expected_folder(&mark, now) {
                    true => Ok(()),
                    false => Err(LeaseError::Replaced(self.folder.clone())),
                };
            }
        };
        if holder.stopped || self.holder.is_same_farm(&holder) {
            self.other_holder = None;
            // A share may have another device number after it was mounted again.
            self.held_identity = self.held_identity.map(|_| now);
            return Ok(());
        }
        let (folder, boxed) = (self.folder.clone(), Box::new(holder.clone()));
        match holder.holds_state_lock(&self.holder) {
            Some(true) => return Err(LeaseError::HeldByOther { folder, holder: boxed }),
            Some(false) => return Ok(()),
            None => {}
        }
        match &self.other_holder {
            Some((known, since)) if *known == holder && since.elapsed() >= takeover_delay() => Ok(()),
            Some((known, _)) if *known == holder => Err(LeaseError::HolderUnclear { folder, holder: boxed }),
            known => {
                let moved = known.as_ref().is_some_and(|(known, _)| known.beat != holder.beat);
                self.other_holder = Some((holder, Instant::now()));
                Err(match moved {
                    true => LeaseError::HeldByOther { folder, holder: boxed },
                    false => LeaseError::HolderUnclear { folder, holder: boxed },
                })
            }
        }
    }

    /// Records that this daemon no longer serves the folder. A folder of another farm is left alone.
    pub fn release(&mut self) {
        let checked_at = LeaseTimestamp::now();
        let is_ours = |mark| matches!(mark, LeaseMarker::HeldBy(holder) if self.holder.is_same_farm(&holder));
        if self.held_identity.is_some() && read_marker(&self.folder).is_ok_and(is_ours) {
            self.holder.stopped = true;
            // Without this entry the daemon looks as if it had been killed.
            let _ = write_marker(&self.folder, &self.holder, checked_at);
        }
    }

    /// Whether a folder without a holder is the one that was served, or may be used for the first time.
    fn is_expected_folder(&self, mark: &LeaseMarker, now: (u64, u64)) -> bool {
        let was = self.held_identity.or_else(|| known_folders::known_identity(&self.holder.state_dir, &self.folder));
        *mark == LeaseMarker::NoHolder || was.is_none_or(|was| was == now)
    }

    fn io_error(&self, source: io::Error) -> LeaseError {
        LeaseError::Io { folder: self.folder.clone(), why: source }
    }
}

/// The id of a farm, created at its first start.
fn read_or_create_farm_id(state_dir: &Path) -> io::Result<String> {
    let path = state_dir.join(FARM_ID_FILE);
    match fs::read_to_string(&path) {
        Ok(number) if !number.trim().is_empty() => return Ok(number.trim().to_owned()),
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let number = format!("{:032x}", rand::random::<u128>());
    let mut file = tempfile::Builder::new().prefix(".nestd-farm-").tempfile_in(state_dir)?;
    writeln!(file, "{number}")?;
    file.as_file().sync_all()?;
    file.persist(&path)?;
    File::open(state_dir)?.sync_all()?;
    Ok(number)
}

/// Device and inode of a folder.
pub(super) fn folder_identity(folder: &Path) -> io::Result<(u64, u64)> {
    let meta = fs::metadata(folder)?;
    match meta.is_dir() {
        true => Ok((meta.dev(), meta.ino())),
        false => Err(io::ErrorKind::NotADirectory.into()),
    }
}

/// Reads the marker of a folder; an unreadable text counts as a marker without a holder.
pub(super) fn read_marker(folder: &Path) -> io::Result<LeaseMarker> {
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut text = String::new();
    match OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(folder.join(NAME)) {
        Ok(file) => match file.take(BYTES as u64).read_to_string(&mut text) {
            Err(error) if error.raw_os_error().is_some() => return Err(error),
            _ => {}
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(LeaseMarker::Missing),
        Err(error) => return Err(error),
    }
    Ok(serde_json::from_str(text.trim_end())
        .map_or(LeaseMarker::NoHolder, |holder| LeaseMarker::HeldBy(Box::new(holder))))
}

/// Writes the marker in place and at full length: a reader sees the old or the new number. Fails if `checked_at` is too
/// old: after a long pause the daemon would overwrite the name of another one that has taken the folder meanwhile.
fn write_marker(folder: &Path, holder: &LeaseHolder, checked_at: LeaseTimestamp) -> io::Result<()> {
    let mut text = serde_json::to_string(holder).map_err(io::Error::other)?;
    text.extend(std::iter::repeat_n(' ', BYTES.saturating_sub(text.len() + 1)));
    text.push('\n');
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut open = OpenOptions::new();
    open.write(true).create(true).truncate(false).custom_flags(flags.bits() as i32);
    let file = match open.open(folder.join(NAME)) {
        // An administrator created it to accept the folder: the folder is ours, so the marker may be replaced.
        Err(error)
            if error.kind() == io::ErrorKind::PermissionDenied && read_marker(folder)? == LeaseMarker::NoHolder =>
        {
            fs::remove_file(folder.join(NAME))?;
            open.open(folder.join(NAME))?
        }
        other => other?,
    };
    if file.metadata()?.len() == 0 {
        crate::access::apply_file_permissions(&file)?;
    }
    match checked_at.is_valid() {
        true => file.write_all_at(text.as_bytes(), 0),
        false => Err(io::ErrorKind::TimedOut.into()),
    }
}

#[cfg(test)]
#[path = "folder_lease_tests.rs"]
mod tests;
