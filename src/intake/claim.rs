//! Takes a settled part out of the hot folder by rename, before any work is done on it.
//!
//! A claim is a folder `.claimed/<id>/` that describes itself: `[order/..]name`, its tickets beside it, a copy of the
//! order list beside it. It is put together as `.claimed/.new-<id>/` and gets its name by one rename, so that a claim is
//! there whole or not at all; what a crash left half made is given back by [`claims`].

use std::{
    ffi::OsString,
    fs,
    io::{self, Read, Write},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU32, Ordering},
    },
};

use thiserror::Error;
use tracing::warn;

use super::{
    Ready, Seen,
    beside::{LIST_NAME, Role, role},
    disk, display_name,
    list_end::mark_served,
    name::order_name,
    order_list::OrderList,
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
    /// Unique for ever, sortable by time; also the name of its folder.
    pub id: String,
    /// The hot folder it was claimed from.
    pub inbox: PathBuf,
    /// Its folder, `.claimed/<id>`.
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
    /// Copy of the order list of its folder.
    pub list: Option<PathBuf>,
    /// Size, bytes.
    pub size: u64,
    /// Last change of contents, nanoseconds since 1970.
    pub mtime_ns: i128,
}

impl Claim {
    /// Its name, escaped.
    pub fn display_name(&self) -> String {
        display_name(&self.name)
    }

    /// Reads a claim from its folder; `None` if it does not hold exactly one part.
    pub(super) fn load(inbox: &Path, id: &str) -> io::Result<Option<Self>> {
        let dir = inbox.join(CLAIMED_DIR).join(id);
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
            id: id.to_owned(),
            inbox: inbox.to_owned(),
            part: part.clone(),
            name: part.file_name().unwrap_or_default().to_owned(),
            order: order_name(&order_path),
            order_path,
            tickets,
            list,
            size: meta.len(),
            mtime_ns: disk::mtime_ns(&meta),
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
}

/// Where a claim lies, or would lie.
pub fn claim_dir(inbox: &Path, id: &str) -> PathBuf {
    inbox.join(CLAIMED_DIR).join(id)
}

/// Claims a [`Ready::Part`] out of `inbox`.
pub fn claim(inbox: &Path, ready: &Ready) -> Result<Claim, ClaimError> {
    claim_stepwise(inbox, ready, &mut || {})
}

/// `step` is called between any two steps that a crash could part; tests stop there.
pub(super) fn claim_stepwise(inbox: &Path, ready: &Ready, step: &mut dyn FnMut()) -> Result<Claim, ClaimError> {
    let (part, tickets, list) = match ready {
        Ready::Part { part, tickets, list, .. } => (part, tickets, list.as_ref()),
        Ready::List { list: seen, .. } | Ready::Refuse { seen, .. } => return Err(ClaimError::Gone(seen.path.clone())),
    };
    let _only_one = claiming();
    let (id, new) = begin(inbox)?;
    let whole = take(inbox, &new, part, tickets, list, step).and_then(|()| finish(inbox, &new, &id, step));
    if let Err(error) = whole {
        if let Err(error) = give_back_files(inbox, &new) {
            warn!(claim = %new.display(), %error, "Could not give back a half made claim; the next look does it.");
        }
        return Err(error);
    }
    let claim =
        Claim::load(inbox, &id).map_err(|e| io_error("read the claim", &inbox.join(CLAIMED_DIR).join(&id), e))?;
    claim.ok_or_else(|| ClaimError::Gone(part.path.clone()))
}

/// Held while claims are put together or taken apart: a recovery must not take for a crash's leftover what another thread
/// is putting together.
pub(super) fn claiming() -> MutexGuard<'static, ()> {
    static CLAIMING: Mutex<()> = Mutex::new(());
    CLAIMING.lock().unwrap_or_else(PoisonError::into_inner)
}

fn begin(inbox: &Path) -> Result<(String, PathBuf), ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    disk::create_dirs_beneath(inbox, Path::new(CLAIMED_DIR)).map_err(|e| io_error("create", &claimed, e))?;
    let id = new_id();
    let new = claimed.join(format!("{NEW}{id}"));
    // Its name is on disk before anything is moved into it: what power loss took it from under would be lost.
    disk::create_dirs(&new).map_err(|e| io_error("create", &new, e))?;
    Ok((id, new))
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

/// The list's copy first, then the tickets, the part last: a part is never without what is said about it.
fn take(
    inbox: &Path,
    new: &Path,
    part: &Seen,
    tickets: &[Seen],
    list: Option<&Seen>,
    step: &mut dyn FnMut(),
) -> Result<(), ClaimError> {
    let relative = below(inbox, part)?;
    let folder = new.join(relative.parent().unwrap_or(Path::new("")));
    step();
    disk::create_dirs(&folder).map_err(|e| io_error("create", &folder, e))?;
    step();
    if let Some(list) = list {
        copy_list(list, &folder.join(LIST_NAME)).map_err(|e| gone_or(e, "copy", list))?;
        step();
        let content = OrderList::read(&folder.join(LIST_NAME)).map_err(|e| gone_or(e, "read", list))?;
        let name = part.path.file_name().unwrap_or_default();
        if let Ok(Some(row)) = content.row_for(name) {
            mark_served(inbox, list, row).map_err(|e| io_error("mark a row as served of", &list.path, e))?;
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
    disk::fsync_dir(&folder).map_err(|e| io_error("fsync", &folder, e))
}

fn finish(inbox: &Path, new: &Path, id: &str, step: &mut dyn FnMut()) -> Result<(), ClaimError> {
    let claimed = inbox.join(CLAIMED_DIR);
    step();
    disk::rename_noreplace(new, &claimed.join(id)).map_err(|e| io_error("claim", new, e))?;
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

/// Copies the settled list; `InvalidData` if it is not the settled one any more.
fn copy_list(list: &Seen, to: &Path) -> io::Result<()> {
    let file = disk::open_regular(&list.path)?;
    let mut bytes = Vec::new();
    (&file).take(list.size + 1).read_to_end(&mut bytes)?;
    let meta = file.metadata()?;
    let print = (meta.ino(), disk::ctime_ns(&meta), bytes.len() as u64, disk::is_second_name_of_a_secret(&meta));
    if print != (list.inode, list.ctime_ns, list.size, false) {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut copy = disk::create_anew(to)?;
    copy.write_all(&bytes)?;
    copy.sync_all()
}

/// Lets the original go after its copy is in the store and its row is committed. Safe to repeat.
pub fn release(claim: &Claim) -> Result<Released, ClaimError> {
    release_stepwise(claim, &mut || {})
}

pub(super) fn release_stepwise(claim: &Claim, step: &mut dyn FnMut()) -> Result<Released, ClaimError> {
    match fs::symlink_metadata(&claim.part) {
        Ok(meta) if (meta.len(), disk::mtime_ns(&meta)) != (claim.size, claim.mtime_ns) => {
            return give_back(claim).map(Released::GivenBack);
        }
        // An earlier try went further.
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(io_error("look at", &claim.part, error)),
        Ok(_) => {}
    }
    step();
    let _only_one = claiming();
    remove_claim_dir(&claim.dir, step).map_err(|e| io_error("remove", &claim.dir, e))?;
    Ok(Released::Removed)
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
