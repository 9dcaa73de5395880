//! Takes a settled part out of the hot folder by rename, before any work is done on it.
//!
//! A claim is a folder `.claimed/<id>/` that describes itself: `[order/..]name`, its tickets beside it, a copy of the
//! order list beside it. It is put together as `.claimed/.new-<id>/` and gets its name by one rename, so that a claim is
//! there whole or not at all; what a crash left half made is given back by [`claims`].

use std::{
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU32, Ordering},
};

use super::{
    Claim, ClaimError, Ready, Said, Seen,
    beside::SAID_NAME,
    claim_folder::{CLAIMED_DIR, NEW, claiming, folder_name, taken_over_name},
    claimed::io_error,
    disk, given_back,
    marks::mark_served,
    recover::{give_back_files, remove_claim_dir},
};

/// What became of a released original.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Released {
    /// It is removed; the store has it.
    Removed,
    /// Somebody wrote into it after it was claimed: it is back in the hot folder, as a new revision.
    GivenBack(PathBuf),
    /// Another farm has taken the claim over: what was read of it is not this farm's any more.
    TakenOver,
}

/// Claims a [`Ready::Part`] out of `inbox` for no farm in particular.
pub fn claim(inbox: &Path, ready: &Ready) -> Result<Claim, ClaimError> {
    claim_as(inbox, ready, "")
}

/// Claims a [`Ready::Part`] out of `inbox`, for the farm of this number.
pub fn claim_as(inbox: &Path, ready: &Ready, farm: &str) -> Result<Claim, ClaimError> {
    claim_stepwise(inbox, ready, farm, &mut || {})
}

/// `step` is called between any two steps that a crash could part; tests stop there.
pub(super) fn claim_stepwise(
    inbox: &Path,
    ready: &Ready,
    farm: &str,
    step: &mut dyn FnMut(),
) -> Result<Claim, ClaimError> {
    let (part, tickets, listed) = match ready {
        Ready::Part { part, tickets, list, said, .. } => (part, tickets, (list.as_ref(), said.as_ref())),
        Ready::List { list: seen, .. } | Ready::Refuse { seen, .. } => return Err(ClaimError::Gone(seen.path.clone())),
    };
    let _only_one = claiming(inbox);
    let (name, new) = begin(inbox, farm)?;
    let whole = take(inbox, &new, part, tickets, listed, step).and_then(|()| finish(inbox, &new, &name, step));
    if let Err(error) = whole {
        // What cannot be given back now is no matter of the part any more: the next look lists all claims.
        give_back_files(inbox, &new).map_err(|e| io_error("give back the half made claim", &new, e))?;
        return Err(error);
    }
    let claim =
        Claim::load(inbox, &name).map_err(|e| io_error("read the claim", &inbox.join(CLAIMED_DIR).join(&name), e))?;
    claim.ok_or_else(|| ClaimError::Gone(part.path.clone()))
}

fn begin(inbox: &Path, farm: &str) -> Result<(String, PathBuf), ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    disk::create_dirs_beneath(inbox, Path::new(CLAIMED_DIR)).map_err(|e| io_error("create", &claimed, e))?;
    let name = folder_name(&new_id(), farm);
    let new = claimed.join(format!("{NEW}{name}"));
    // Its name is on disk before anything is moved into it: what power loss took it from under would be lost.
    disk::create_dirs(&new).map_err(|e| io_error("create", &new, e))?;
    Ok((name, new))
}

/// Time, a counter for claims of the same millisecond, and chance against clocks that are set back.
fn new_id() -> String {
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

/// What the list says first, then the tickets, the part last: a part is never without what is said about it.
fn take(
    inbox: &Path,
    new: &Path,
    part: &Seen,
    tickets: &[Seen],
    (list, said): (Option<&Seen>, Option<&Said>),
    step: &mut dyn FnMut(),
) -> Result<(), ClaimError> {
    let relative = below(inbox, part)?;
    let folder = new.join(relative.parent().unwrap_or(Path::new("")));
    step();
    disk::create_dirs(&folder).map_err(|e| io_error("create", &folder, e))?;
    step();
    if let Some(list) = list {
        let meta = fs::symlink_metadata(&list.path).map_err(|e| gone_or(e, "look at", list))?;
        if !disk::is_still(list, &meta) {
            return Err(ClaimError::Changed(list.path.clone()));
        }
    }
    if let Some(said) = said {
        said.save(&folder.join(SAID_NAME)).map_err(|e| io_error("write", &folder, e))?;
        step();
        if let (Some(list), Some(row)) = (list, &said.file) {
            let name = part.path.file_name().unwrap_or_default();
            mark_served(inbox, list, row, name).map_err(|e| io_error("mark a row as served of", &list.path, e))?;
        }
        step();
    }
    for seen in tickets.iter().chain([part]) {
        let relative = below(inbox, seen)?;
        let to = new.join(relative);
        disk::rename_out(inbox, relative, &to).map_err(|e| gone_or(e, "claim", seen))?;
        step();
        if !is_same(seen, &to) {
            return Err(ClaimError::Changed(seen.path.clone()));
        }
    }
    given_back::forget(inbox, part);
    disk::fsync_dir(&folder).map_err(|e| io_error("fsync", &folder, e))
}

fn finish(inbox: &Path, new: &Path, name: &str, step: &mut dyn FnMut()) -> Result<(), ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    step();
    disk::rename_noreplace(new, &claimed.join(name)).map_err(|e| io_error("claim", new, e))?;
    step();
    // The claim is whole; that its name is not on disk yet only means that a power cut would undo it.
    let _ = disk::fsync_dir(&claimed);
    Ok(())
}

fn below<'a>(inbox: &Path, seen: &'a Seen) -> Result<&'a Path, ClaimError> {
    seen.path.strip_prefix(inbox).map_err(|_| ClaimError::Gone(seen.path.clone()))
}

fn gone_or(error: io::Error, what: &'static str, seen: &Seen) -> ClaimError {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => ClaimError::Gone(seen.path.clone()),
        io::ErrorKind::InvalidData => ClaimError::Changed(seen.path.clone()),
        _ => io_error(what, &seen.path, error),
    }
}

/// Whether what was renamed is what had settled. The rename itself changes the ctime.
fn is_same(seen: &Seen, now_at: &Path) -> bool {
    fs::symlink_metadata(now_at).is_ok_and(|meta| {
        meta.is_file()
            && (meta.len(), meta.ino(), meta.dev()) == (seen.size, seen.inode, seen.dev)
            && disk::mtime_ns(&meta) == seen.mtime_ns
            && !disk::is_second_name_of_a_secret(&meta)
    })
}

/// Lets the original go after its copy is in the store under `hash` and its row is committed. Safe to repeat.
///
/// Whoever wrote into it may have set its time back, and whoever changed its mode wrote nothing: the ctime tells that
/// something was done, the bytes tell what.
pub fn release(claim: &Claim, hash: &str) -> Result<Released, ClaimError> {
    release_stepwise(claim, hash, &mut || {})
}

pub(super) fn release_stepwise(claim: &Claim, hash: &str, step: &mut dyn FnMut()) -> Result<Released, ClaimError> {
    match fs::symlink_metadata(&claim.part) {
        Ok(meta)
            if (meta.len(), disk::mtime_ns(&meta), disk::ctime_ns(&meta))
                != (claim.size, claim.mtime_ns, claim.ctime_ns) =>
        {
            let bytes = disk::hash_file(&claim.part).map_err(|e| io_error("read", &claim.part, e))?;
            if bytes != hash {
                return give_back(claim).map(Released::GivenBack);
            }
        }
        // An earlier try went further.
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(io_error("look at", &claim.part, error)),
        Ok(_) => {}
    }
    step();
    let _only_one = claiming(&claim.inbox);
    // The one rename in there decides between this farm and one that takes the claim over.
    if remove_claim_dir(&claim.dir, step).map_err(|e| io_error("remove", &claim.dir, e))? {
        return Ok(Released::Removed);
    }
    let trace = taken_over_name(&claim.dir);
    match disk::try_is_there(&trace).map_err(|e| io_error("look at", &trace, e))? {
        true => Ok(Released::TakenOver),
        false => Ok(Released::Removed),
    }
}

/// Puts a claimed part and its tickets back into the hot folder, to be settled and claimed anew: for one that changed
/// while it was read. Returns where the part is.
pub fn give_back(claim: &Claim) -> Result<PathBuf, ClaimError> {
    let _only_one = claiming(&claim.inbox);
    let back = give_back_files(&claim.inbox, &claim.dir).map_err(|e| io_error("give back", &claim.part, e))?;
    back.ok_or_else(|| ClaimError::Gone(claim.part.clone()))
}

#[cfg(test)]
#[path = "claim_tests.rs"]
mod tests;
