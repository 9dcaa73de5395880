//! Leases on the folders of a machine: hot folder, queue, archive, error folder. Two daemons with different ledgers on
//! one folder would each take half of the parts and overwrite each other's files, and locks do not work on every share.
//! So a daemon writes its name into `.nestd-owner` and keeps changing a number there as long as it lives. A daemon that
//! finds another name there checks whether the other one is alive: on its own server by the lock, on another server by
//! whether the number changes.
//!
//! The same file shows whether an empty directory is an unmounted share or a folder that somebody emptied; `served`
//! knows across restarts which folders had one.

use std::{
    io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Instant,
};

use thiserror::Error;

use super::{
    known_folders,
    lease_clock::{LeaseTimestamp, takeover_delay},
    lease_holder::LeaseHolder,
    lease_marker::{self, LeaseMarker, folder_identity, read_marker, write_marker},
};

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
        "{} is not the folder that was there before: its marker {} is missing. Mount it again; if it was replaced or \
         emptied on purpose: touch {}", .0.display(), lease_marker::NAME, .0.join(lease_marker::NAME).display()
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
    /// The last two markers that this process wrote or tried to write, shared by all clones of the lease. Any other
    /// marker was written by somebody else: by another farm, by a copy of this farm with the same id, or by this very
    /// process before its machine was put back to a snapshot.
    written: Arc<Mutex<[Option<LeaseHolder>; 2]>>,
    /// How often the lease was interrupted: somebody else served the folder, or may have, since this process wrote its
    /// marker.
    interruptions: u32,
}

impl FolderLease {
    /// A lease that is not acquired yet.
    pub fn new(me: LeaseHolder, folder: &Path) -> Self {
        Self {
            holder: me,
            folder: folder.to_owned(),
            held_identity: None,
            is_remembered: false,
            other_holder: None,
            written: Arc::default(),
            interruptions: 0,
        }
    }

    /// Path of the folder.
    pub fn folder_path(&self) -> &Path {
        &self.folder
    }

    /// Id of this farm.
    pub fn farm_id(&self) -> &str {
        &self.holder.farm
    }

    /// How often somebody else served the folder, or may have, since this process first held it. What the ledger knew of
    /// the folder before the last time says nothing any more.
    pub fn interruption_count(&self) -> u32 {
        self.interruptions
    }

    /// Checks that the marker is the one that this process wrote last, so that the next operation does not work in
    /// another farm's folder.
    pub fn check_held(&self) -> Result<(), LeaseError> {
        let folder = self.folder.clone();
        match read_marker(&self.folder).map_err(|source| self.io_error(source))? {
            LeaseMarker::HeldBy(holder) if self.is_own_marker(&holder) => Ok(()),
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
        let seen = match self.accept_marker() {
            Ok(seen) => seen,
            Err(refused) => {
                let is_held = matches!(refused, LeaseError::HeldByOther { .. } | LeaseError::HolderUnclear { .. });
                self.interruptions += u32::from(is_held && self.has_written());
                return Err(refused);
            }
        };
        let is_own = matches!(&seen, LeaseMarker::HeldBy(holder) if self.is_own_marker(holder));
        self.interruptions += u32::from(self.has_written() && !is_own);
        self.holder.change_beat();
        *self.written_markers() = match seen {
            LeaseMarker::HeldBy(holder) if is_own => [Some(*holder), Some(self.holder.clone())],
            _ => [None, Some(self.holder.clone())],
        };
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
        self.accept_marker().map(drop)
    }

    /// Reads the marker, and checks that the folder may be used.
    fn accept_marker(&mut self) -> Result<LeaseMarker, LeaseError> {
        let now = folder_identity(&self.folder).map_err(|source| self.io_error(source))?;
        let holder = match read_marker(&self.folder).map_err(|source| self.io_error(source))? {
            LeaseMarker::HeldBy(holder) => *holder,
            mark => {
                self.other_holder = None;
                return match self.is_expected_folder(&mark, now) {
                    true => Ok(mark),
                    false => Err(LeaseError::Replaced(self.folder.clone())),
                };
            }
        };
        let marker = || LeaseMarker::HeldBy(Box::new(holder.clone()));
        if holder.stopped || self.is_own_marker(&holder) {
            self.other_holder = None;
            // A share may have another device number after it was mounted again.
            self.held_identity = self.held_identity.map(|_| now);
            return Ok(marker());
        }
        let (folder, boxed) = (self.folder.clone(), Box::new(holder.clone()));
        match holder.holds_state_lock(&self.holder) {
            Some(true) => return Err(LeaseError::HeldByOther { folder, holder: boxed }),
            Some(false) => return Ok(marker()),
            None => {}
        }
        match &self.other_holder {
            Some((known, since)) if *known == holder && since.elapsed() >= takeover_delay() => Ok(marker()),
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

    /// Whether a marker is this daemon's: one that this process wrote, or, before it wrote any, one of an earlier daemon
    /// of the same farm.
    fn is_own_marker(&self, marker: &LeaseHolder) -> bool {
        let written = self.written_markers();
        match written.iter().all(Option::is_none) {
            true => self.holder.is_same_farm(marker),
            false => written.iter().flatten().any(|own| own == marker),
        }
    }

    fn has_written(&self) -> bool {
        self.written_markers().iter().any(Option::is_some)
    }

    fn written_markers(&self) -> MutexGuard<'_, [Option<LeaseHolder>; 2]> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records that this daemon no longer serves the folder. A folder of another farm is left alone.
    pub fn release(&mut self) {
        let checked_at = LeaseTimestamp::now();
        let is_ours = |mark| matches!(mark, LeaseMarker::HeldBy(holder) if self.is_own_marker(&holder));
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

#[cfg(test)]
#[path = "tests/folder_lease_tests.rs"]
mod tests;
