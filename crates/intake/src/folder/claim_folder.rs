//! The folder of a claim. Its name, `.claimed/<id>@<farm>`, tells the state and the owner of the claim. A name without
//! a farm was made by an earlier release and counts as our own.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use super::disk;

/// Folder of the claims. It is inside the hot folder and therefore on the same file system.
pub(crate) const CLAIMED_DIR: &str = ".claimed";
/// Prefix of a claim that is being assembled.
pub(crate) const UNFINISHED_PREFIX: &str = ".new-";
/// Prefix of a claim that is being removed.
pub(crate) const REMOVED_PREFIX: &str = ".done-";

/// How the ids of the claims of ordered lines begin.
pub(crate) const ORDERED_PREFIX: &str = "order-";

/// Prefix of the trace that a taken-over claim leaves: `.adopted-<id>@<former farm>`. The trace stays, because the
/// former farm may come back at any time, even with an older ledger.
pub(crate) const ADOPTED_PREFIX: &str = ".adopted-";

/// Claims fewer than this in one go have folders of their own.
const FEW_CLAIMS: usize = 16;
/// More emptied folders are not kept.
const MOST_EMPTIED: usize = 256;

/// Emptied folders of claims that were removed, which the next claims take. A file system passes over the inodes that were
/// removed minutes ago when it makes a new one, one by one (ext4: `recently_deleted`): to make and remove a folder for each of
/// thousands of files took a tenth of the daemon's CPU time. After a crash they are removed as the claims that they were.
#[derive(Debug, Default)]
pub(crate) struct EmptiedClaims {
    /// Claims since a scan has found nothing to claim.
    claimed: usize,
    folders: Vec<PathBuf>,
}

impl EmptiedClaims {
    /// Makes the empty folder `new` of a claim, whose name is on disk then.
    pub fn make_folder(&mut self, new: &Path) -> io::Result<()> {
        self.claimed += 1;
        while let Some(emptied) = self.folders.pop() {
            // Others may have removed it, or put something into it.
            let is_folder = fs::symlink_metadata(&emptied).is_ok_and(|meta| meta.is_dir());
            let is_empty = is_folder && fs::read_dir(&emptied).is_ok_and(|mut entries| entries.next().is_none());
            if is_empty && fs::rename(&emptied, new).is_ok() {
                return new.parent().map_or(Ok(()), disk::fsync_dir);
            }
        }
        disk::create_dirs(new)
    }

    /// Removes what is in the folder of a removed claim, and the folder, unless it is kept.
    pub fn remove_folder(&mut self, removed: &Path) -> io::Result<()> {
        if self.claimed < FEW_CLAIMS || self.folders.len() >= MOST_EMPTIED || !removed.is_dir() {
            return disk::remove_folder(removed);
        }
        for entry in fs::read_dir(removed)? {
            let entry = entry?;
            match entry.file_type()?.is_dir() {
                true => disk::remove_folder(&entry.path())?,
                false => fs::remove_file(entry.path())?,
            }
        }
        self.folders.push(removed.to_owned());
        Ok(())
    }
}

/// Removes the folders that are kept for the next claims: a scan has found nothing to claim.
pub fn remove_emptied_claims(inbox: &Path) {
    let mut emptied = lock_claims(inbox);
    emptied.claimed = 0;
    for folder in std::mem::take(&mut emptied.folders) {
        // What is not empty or gone, the next recovery removes.
        let _ = fs::remove_dir(folder);
    }
}

/// Held while claims of a hot folder are put together or taken apart: a recovery must not take for a crash's leftover what
/// another thread is putting together. Moving a large file to another file system takes long; other hot folders do not wait.
pub(crate) fn lock_claims(inbox: &Path) -> MutexGuard<'static, EmptiedClaims> {
    static CLAIMING: Mutex<BTreeMap<PathBuf, &'static Mutex<EmptiedClaims>>> = Mutex::new(BTreeMap::new());
    let mut known = CLAIMING.lock().unwrap_or_else(PoisonError::into_inner);
    let of_inbox: &'static Mutex<EmptiedClaims> = match known.get(inbox) {
        Some(of_inbox) => of_inbox,
        // A process serves few hot folders, and each for long.
        None => known.entry(inbox.to_owned()).or_insert(Box::leak(Box::default())),
    };
    drop(known);
    of_inbox.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Folder name of a claim. If `farm` is "", the name contains no farm.
pub(crate) fn claim_folder_name(id: &str, farm: &str) -> String {
    if farm.is_empty() { id.to_owned() } else { format!("{id}@{farm}") }
}

/// Splits the folder name of a claim into id and farm.
pub(crate) fn parse_folder_name(name: &str) -> (&str, Option<&str>) {
    let name = [UNFINISHED_PREFIX, REMOVED_PREFIX, ADOPTED_PREFIX]
        .iter()
        .find_map(|with| name.strip_prefix(with))
        .unwrap_or(name);
    name.split_once('@').map_or((name, None), |(id, farm)| (id, Some(farm)))
}

/// Whether the folder name of a claim is that of an ordered line.
pub(crate) fn is_ordered_claim(folder_name: &str) -> bool {
    parse_folder_name(folder_name).0.starts_with(ORDERED_PREFIX)
}

/// Returns the claim id in a folder name, whether the claim is complete or not.
pub fn claim_id(name: &str) -> &str {
    parse_folder_name(name).0
}

/// Path of the trace that shows that the claim was taken over.
pub(crate) fn takeover_trace_path(dir: &Path) -> PathBuf {
    dir.with_file_name(format!("{ADOPTED_PREFIX}{}", dir.file_name().unwrap_or_default().to_string_lossy()))
}

/// Whether the folder name belongs to a claim (complete or not) of another farm.
pub(crate) fn is_foreign_claim(name: &str, farm: &str) -> bool {
    !name.starts_with(ADOPTED_PREFIX) && parse_folder_name(name).1.is_some_and(|of| of != farm)
}

/// Finds the folder of a claim.
pub(super) fn find_claim_dir(inbox: &Path, id: &str) -> Option<PathBuf> {
    let is_it = |name: &&String| !name.starts_with('.') && parse_folder_name(name).0 == id;
    Some(inbox.join(CLAIMED_DIR).join(list_claim_folders(inbox).ok()?.iter().find(is_it)?))
}

/// Folder of a claim; if it does not exist, the folder that it would have.
pub fn claim_dir(inbox: &Path, id: &str) -> PathBuf {
    find_claim_dir(inbox, id).unwrap_or_else(|| inbox.join(CLAIMED_DIR).join(id))
}

/// Names of all entries in `.claimed/`.
pub(crate) fn list_claim_folders(inbox: &Path) -> io::Result<Vec<String>> {
    let entries = match fs::read_dir(inbox.join(CLAIMED_DIR)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other?,
    };
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    names.collect()
}
