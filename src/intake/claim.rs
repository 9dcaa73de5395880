//! Takes a settled part out of the hot folder by rename, before any work is done on it.
//!
//! A claim is a folder `.claimed/<id>/` that describes itself: `[order/..]name`, its tickets beside it, a copy of the
//! order list beside it. It is put together as `.claimed/.new-<id>/` and gets its name by one rename, so that a claim is
//! there whole or not at all; what a crash left half made is given back by [`claims`].

use std::{
    ffi::OsString,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU32, Ordering},
    },
};

use thiserror::Error;

use super::{
    Ready, Seen,
    adopt::{find, folder_name, id_and_farm, taken_over_name},
    beside::{Role, SAID_NAME, role},
    disk, display_name, given_back,
    list_end::mark_served,
    listed::Said,
    name::order_name,
    recover::{give_back_files, remove_claim_dir},
};

/// Claims lie here, below the hot folder and so on its own file system.
pub(super) const CLAIMED_DIR: &str = ".claimed";
/// A claim that is being put together.
pub(super) const NEW: &str = ".new-";
/// A claim that is being removed.
pub(super) const DONE: &str = ".done-";

/// A claimed part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Unique for ever, sortable by time; begins the name of its folder.
    pub id: String,
    /// The hot folder it was claimed from.
    pub inbox: PathBuf,
    /// Its folder, `.claimed/<id>@<farm>`.
    pub dir: PathBuf,
    /// The claimed file.
    pub part: PathBuf,
    /// Its name as dropped, raw.
    pub name: OsString,
    /// Its sub-folders below the hot folder, raw; empty = none.
    pub order_path: PathBuf,
    /// Its sub-folders, escaped, joined by `/`; empty = none.
    pub order: String,
    /// Sidecar tickets that were claimed with it.
    pub tickets: Vec<PathBuf>,
    /// What the order list of its folder says about it; of an older nestd a copy of the whole list.
    pub list: Option<PathBuf>,
    /// Size, bytes.
    pub size: u64,
    /// Last change of contents, nanoseconds since 1970.
    pub mtime_ns: i128,
    /// Last change of contents or attributes, nanoseconds since 1970: nobody can set it.
    pub ctime_ns: i128,
}

impl Claim {
    /// Its name, escaped.
    pub fn display_name(&self) -> String {
        display_name(&self.name)
    }

    /// Reads a claim from its folder; `None` if it does not hold exactly one part.
    pub(super) fn load(inbox: &Path, name: &str) -> io::Result<Option<Self>> {
        let dir = inbox.join(CLAIMED_DIR).join(name);
        let (mut parts, mut tickets, mut list) = (Vec::new(), Vec::new(), None);
        for file in disk::files_below(&dir)? {
            match role(&file) {
                Role::Part => parts.push(file),
                Role::Ticket { .. } => tickets.push(file),
                Role::List => list = Some(file),
            }
        }
        let [part] = &parts[..] else { return Ok(None) };
        let meta = fs::symlink_metadata(part)?;
        let order_path = part.parent().and_then(|p| p.strip_prefix(&dir).ok()).unwrap_or(Path::new("")).to_owned();
        Ok(Some(Self {
            id: id_and_farm(name).0.to_owned(),
            inbox: inbox.to_owned(),
            part: part.clone(),
            name: part.file_name().unwrap_or_default().to_owned(),
            order: order_name(&order_path),
            order_path,
            tickets,
            list,
            size: meta.len(),
            mtime_ns: disk::mtime_ns(&meta),
            ctime_ns: disk::ctime_ns(&meta),
            dir,
        }))
    }
}

/// Why nothing was claimed. The part stands in the hot folder as before, or a crash recovery will put it there.
#[derive(Debug, Error)]
pub enum ClaimError {
    /// It changed since it was seen; it must settle again.
    #[error("{} changed while it was being claimed", .0.display())]
    Changed(PathBuf),
    /// It is gone, or was never a part.
    #[error("{} is not there to be claimed", .0.display())]
    Gone(PathBuf),
    /// The system said no.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

pub(super) fn io_error(what: &'static str, path: &Path, source: io::Error) -> ClaimError {
    ClaimError::Io { what, path: path.to_owned(), source }
}

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

/// Where a claim lies, or would lie.
pub fn claim_dir(inbox: &Path, id: &str) -> PathBuf {
    find(inbox, id).unwrap_or_else(|| inbox.join(CLAIMED_DIR).join(id))
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
    let _only_one = claiming();
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

/// Held while claims are put together or taken apart: a recovery must not take for a crash's leftover what another thread
/// is putting together.
pub(super) fn claiming() -> MutexGuard<'static, ()> {
    static CLAIMING: Mutex<()> = Mutex::new(());
    CLAIMING.lock().unwrap_or_else(PoisonError::into_inner)
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
    let _only_one = claiming();
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
    let _only_one = claiming();
    let back = give_back_files(&claim.inbox, &claim.dir).map_err(|e| io_error("give back", &claim.part, e))?;
    back.ok_or_else(|| ClaimError::Gone(claim.part.clone()))
}

#[cfg(test)]
#[path = "claim_tests.rs"]
mod tests;
