//! Claims a settled part: renames it out of the hot folder before any other work is done on it.
//!
//! A claim is a self-describing folder `.claimed/<id>/`. It holds `[order/..]name` and beside it the tickets of the
//! part and what the order list says about it. It is assembled as `.claimed/.new-<id>/` and then renamed once, so a
//! claim either exists completely or not at all. [`recover_claims`](crate::recover_claims) gives back the files of an assembly that a crash
//! interrupted.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU32, Ordering},
};

use super::{
    given_back,
    recover::{give_back_files, remove_claim_dir},
};
use crate::{
    ClaimError, ClaimedPart, InboxEntry, ListLookup, SettledEntry,
    folder::{
        claim_folder::{
            CLAIMED_DIR, EmptiedClaims, UNFINISHED_PREFIX, claim_folder_name, lock_claims, takeover_trace_path,
        },
        claimed_part::io_error,
        disk,
        file_role::LIST_LOOKUP_NAME,
    },
    lists::served_rows::{mark_row_unused, mark_served, path_below_list},
};

/// Result of releasing a claimed file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ReleaseOutcome {
    /// The file was removed; the store has a copy.
    Removed,
    /// Somebody changed the file after it was claimed. It is back in the hot folder, as a new revision.
    GivenBack(PathBuf),
    /// Another farm has taken the claim over. This farm must not use what it read.
    TakenOver,
}

/// Claims a [`SettledEntry::Part`] from `inbox` without recording a farm.
pub fn claim_part(inbox: &Path, ready: &SettledEntry) -> Result<ClaimedPart, ClaimError> {
    claim_for_farm(inbox, ready, "")
}

/// Claims a [`SettledEntry::Part`] from `inbox` for the given farm.
pub fn claim_for_farm(inbox: &Path, ready: &SettledEntry, farm: &str) -> Result<ClaimedPart, ClaimError> {
    claim_stepwise(inbox, ready, farm, &mut || {})
}

/// Calls `step` between any two steps where a crash could happen, so that tests can stop there.
pub(super) fn claim_stepwise(
    inbox: &Path,
    ready: &SettledEntry,
    farm: &str,
    step: &mut dyn FnMut(),
) -> Result<ClaimedPart, ClaimError> {
    let (part, tickets, listed) = match ready {
        SettledEntry::Part { part, tickets, list, lookup: said, .. } => (part, tickets, (list.as_ref(), said.as_ref())),
        SettledEntry::List { list: seen, .. }
        | SettledEntry::Blocked { part: seen, .. }
        | SettledEntry::RivalList { rival: seen, .. }
        | SettledEntry::Orphan { ticket: seen, .. }
        | SettledEntry::Control { file: seen, .. }
        | SettledEntry::Refuse { seen, .. } => {
            return Err(ClaimError::Gone(seen.path.clone()));
        }
    };
    let mut only_one = lock_claims(inbox);
    let (name, new) = create_claim_dir(&mut only_one, inbox, farm)?;
    let whole =
        move_files_in(inbox, &new, part, tickets, listed, step).and_then(|()| finish_claim(inbox, &new, &name, step));
    if let Err(error) = whole {
        // What cannot be given back now does not concern the part any more: the next scan lists all claims.
        give_back_files(inbox, &new).map_err(|e| io_error("give back the half made claim", &new, e))?;
        return Err(error);
    }
    let claim = ClaimedPart::load_from_folder(inbox, &name)
        .map_err(|e| io_error("read the claim", &inbox.join(CLAIMED_DIR).join(&name), e))?;
    claim.ok_or_else(|| ClaimError::Gone(part.path.clone()))
}

pub(super) fn create_claim_dir(
    emptied: &mut EmptiedClaims,
    inbox: &Path,
    farm: &str,
) -> Result<(String, PathBuf), ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    disk::create_dirs_beneath(inbox, Path::new(CLAIMED_DIR)).map_err(|e| io_error("create", &claimed, e))?;
    let name = claim_folder_name(&new_claim_id(), farm);
    let new = claimed.join(format!("{UNFINISHED_PREFIX}{name}"));
    // The folder name is on disk before any file is moved into it. Otherwise a power loss could lose the moved files.
    emptied.make_folder(&new).map_err(|e| io_error("create", &new, e))?;
    Ok((name, new))
}

/// Made of the time, a counter for claims of the same millisecond, and a random number in case the clock is set back.
fn new_claim_id() -> String {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed) % 10_000;
    let now = jiff::Timestamp::now();
    format!(
        "{}{:03}Z-{count:04}-{:08x}",
        now.strftime("%Y%m%dT%H%M%S"),
        now.subsec_millisecond(),
        rand::random::<u32>()
    )
}

/// Writes the list's data first, then moves the tickets, and the part last. So a part never exists without its
/// instructions.
fn move_files_in(
    inbox: &Path,
    new: &Path,
    part: &InboxEntry,
    tickets: &[InboxEntry],
    (list, said): (Option<&InboxEntry>, Option<&ListLookup>),
    step: &mut dyn FnMut(),
) -> Result<(), ClaimError> {
    let relative = path_in_inbox(inbox, part)?;
    let folder = new.join(relative.parent().unwrap_or(Path::new("")));
    step();
    disk::create_dirs(&folder).map_err(|e| io_error("create", &folder, e))?;
    step();
    if let Some(list) = list {
        let meta = fs::symlink_metadata(&list.path).map_err(|e| gone_or_io_error(e, "look at", list))?;
        if !disk::is_unchanged(list, &meta) {
            return Err(ClaimError::Changed(list.path.clone()));
        }
    }
    if let Some(said) = said {
        said.save_to(&folder.join(LIST_LOOKUP_NAME)).map_err(|e| io_error("write", &folder, e))?;
        step();
        if let Some(list) = list {
            let mark_failed = |e| io_error("mark a row as served of", &list.path, e);
            for row in &said.unused_rows {
                mark_row_unused(inbox, list, row).map_err(mark_failed)?;
            }
            if let Some(row) = &said.file {
                mark_served(inbox, list, row, &path_below_list(&part.path, &list.path)).map_err(mark_failed)?;
            }
        }
        step();
    }
    for seen in tickets.iter().chain([part]) {
        let relative = path_in_inbox(inbox, seen)?;
        let to = new.join(relative);
        disk::rename_out(inbox, relative, &to).map_err(|e| gone_or_io_error(e, "claim", seen))?;
        step();
        if !disk::is_same_file(seen, &to) {
            return Err(ClaimError::Changed(seen.path.clone()));
        }
    }
    given_back::delete_note(inbox, part);
    disk::fsync_dir(&folder).map_err(|e| io_error("fsync", &folder, e))
}

fn finish_claim(inbox: &Path, new: &Path, name: &str, step: &mut dyn FnMut()) -> Result<(), ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    step();
    disk::rename_noreplace(new, &claimed.join(name)).map_err(|e| io_error("claim", new, e))?;
    step();
    // The claim is complete. If its name is not on disk yet, a power cut merely undoes the claim.
    let _ = disk::fsync_dir(&claimed);
    Ok(())
}

fn path_in_inbox<'a>(inbox: &Path, seen: &'a InboxEntry) -> Result<&'a Path, ClaimError> {
    seen.path.strip_prefix(inbox).map_err(|_| ClaimError::Gone(seen.path.clone()))
}

fn gone_or_io_error(error: io::Error, what: &'static str, seen: &InboxEntry) -> ClaimError {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => ClaimError::Gone(seen.path.clone()),
        io::ErrorKind::InvalidData => ClaimError::Changed(seen.path.clone()),
        _ => io_error(what, &seen.path, error),
    }
}

/// Removes the original after its copy is in the store under `hash` and its row is committed. Safe to repeat.
///
/// The mtime is not reliable: a writer may have reset it. A changed mode is not a write. So a changed ctime shows that
/// something happened to the file, and its bytes show whether the content changed.
pub fn release_claim(claim: &ClaimedPart, hash: &str) -> Result<ReleaseOutcome, ClaimError> {
    release_stepwise(claim, hash, &mut || {})
}

pub(super) fn release_stepwise(
    claim: &ClaimedPart,
    hash: &str,
    step: &mut dyn FnMut(),
) -> Result<ReleaseOutcome, ClaimError> {
    match fs::symlink_metadata(&claim.part) {
        Ok(meta)
            if (meta.len(), disk::mtime_ns(&meta), disk::ctime_ns(&meta))
                != (claim.size, claim.mtime_ns, claim.ctime_ns) =>
        {
            let bytes = disk::hash_file(&claim.part).map_err(|e| io_error("read", &claim.part, e))?;
            if bytes != hash {
                return give_back_claim(claim).map(ReleaseOutcome::GivenBack);
            }
        }
        // An earlier attempt already removed the file.
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(io_error("look at", &claim.part, error)),
        Ok(_) => {}
    }
    step();
    let mut only_one = lock_claims(&claim.inbox);
    // The single rename inside this call decides whether this farm or a farm that takes the claim over wins.
    if remove_claim_dir(&mut only_one, &claim.dir, step).map_err(|e| io_error("remove", &claim.dir, e))? {
        return Ok(ReleaseOutcome::Removed);
    }
    let trace = takeover_trace_path(&claim.dir);
    match disk::try_path_exists(&trace).map_err(|e| io_error("look at", &trace, e))? {
        true => Ok(ReleaseOutcome::TakenOver),
        false => Ok(ReleaseOutcome::Removed),
    }
}

/// Puts a claimed part and its tickets back into the hot folder, where they settle and are claimed again. Used for a
/// part that changed while it was read. Returns the new path of the part.
pub fn give_back_claim(claim: &ClaimedPart) -> Result<PathBuf, ClaimError> {
    let _only_one = lock_claims(&claim.inbox);
    let back = give_back_files(&claim.inbox, &claim.dir).map_err(|e| io_error("give back", &claim.part, e))?;
    back.ok_or_else(|| ClaimError::Gone(claim.part.clone()))
}

#[cfg(test)]
#[path = "tests/claim_tests.rs"]
mod tests;
