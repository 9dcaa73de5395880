//! Refuses files: moves them to the error folder beside a file with the reason. Nothing is overwritten or lost.
//!
//! The reason is written first, so a crash never leaves an unexplained file in the error folder. The reason names the
//! claim or file that it belongs to, so the next attempt continues where the crash happened.

use std::{
    ffi::OsStr,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use language::say;
use thiserror::Error;

use super::recover::{remove_claim_dir, ticket_file_name};
use crate::{
    ClaimedPart, InboxEntry, display_name,
    folder::{claim_folder::lock_claims, disk, file_role::REASON_SUFFIX},
    names::name::{numbered_name, raw_name, with_suffix},
};

/// Maximum length of a reason that nestd writes.
pub(super) const MAX_REASON_BYTES: u64 = 1 << 20;

/// Why a file could not be refused. It stays in place.
#[derive(Debug, Error)]
#[error("cannot {what} {}", .path.display())]
pub struct RefuseError {
    /// The operation that failed.
    pub what: &'static str,
    /// The path that it was applied to.
    pub path: PathBuf,
    /// The error of the operating system.
    #[source]
    pub source: io::Error,
}

pub(crate) fn io_error(what: &'static str, path: &Path, source: io::Error) -> RefuseError {
    RefuseError { what, path: path.to_owned(), source }
}

/// Moves a claimed part and its tickets into `error_dir/[order/]`, beside `<name>.reason.txt`. Returns the new path of
/// the part. `reason` is addressed to the technician, in whole sentences. Safe to repeat until it succeeds.
pub fn refuse_claim(claim: &ClaimedPart, error_dir: &Path, reason: &str) -> Result<PathBuf, RefuseError> {
    refuse_stepwise(claim, error_dir, reason, &mut || {})
}

pub(super) fn refuse_stepwise(
    claim: &ClaimedPart,
    error_dir: &Path,
    reason: &str,
    step: &mut dyn FnMut(),
) -> Result<PathBuf, RefuseError> {
    let mut only_one = lock_claims(&claim.inbox);
    let folder = open_error_folder(error_dir, &claim.order_path)?;
    let refusal =
        PendingRefusal { source: &claim.part, folder: &folder, name: &claim.name, key: format!("Claim: {}", claim.id) };
    let relative = claim.part.strip_prefix(&claim.inbox).unwrap_or(&claim.part);
    let to = match fs::symlink_metadata(&claim.part) {
        Ok(_) => {
            refusal.write_and_move(&claim.order, reason, step, |to| disk::move_out_of(&claim.inbox, relative, to))?
        }
        // An earlier attempt moved the part and failed afterwards.
        Err(error) if error.kind() == io::ErrorKind::NotFound => refusal.find_moved_file()?,
        Err(error) => return Err(io_error("look at", &claim.part, error)),
    };
    for ticket in &claim.tickets {
        let name = ticket_file_name(to.file_name().unwrap_or_default(), ticket);
        if disk::try_path_exists(ticket).map_err(|e| io_error("look at", ticket, e))? {
            disk::move_to_free_name(ticket, &folder, &name).map_err(|e| io_error("refuse", ticket, e))?;
        }
        step();
    }
    remove_claim_dir(&mut only_one, &claim.dir, step).map_err(|e| io_error("remove", &claim.dir, e))?;
    Ok(to)
}

/// Moves an entry that was never claimed (a link, a socket, a folder, an orphan ticket) from `inbox` to the error
/// folder in the same way.
pub fn refuse_entry(inbox: &Path, seen: &InboxEntry, error_dir: &Path, reason: &str) -> Result<PathBuf, RefuseError> {
    let gone = || io_error("refuse", &seen.path, io::ErrorKind::NotFound.into());
    let relative = seen.path.strip_prefix(inbox).map_err(|_| gone())?;
    let meta = fs::symlink_metadata(&seen.path).map_err(|e| io_error("refuse", &seen.path, e))?;
    if (meta.dev(), meta.ino()) != (seen.dev, seen.inode) {
        return Err(gone());
    }
    let folder = open_error_folder(error_dir, relative.parent().unwrap_or(Path::new("")))?;
    let name = seen.path.file_name().unwrap_or_default();
    let refusal = PendingRefusal {
        source: &seen.path,
        folder: &folder,
        name,
        key: format!("Inode: {}-{}", seen.inode, seen.mtime_ns),
    };
    refusal.write_and_move(&seen.order, reason, &mut || {}, |to| disk::move_out_of(inbox, relative, to))
}

/// Writes a row of an order list as a list of its own to the error folder, beside its reason. The list itself stays. Safe to
/// repeat: `key` identifies the row.
pub(crate) fn refuse_list_row(
    list: &InboxEntry,
    order: &Path,
    error_dir: &Path,
    row: &str,
    key: String,
    reason: &str,
) -> Result<PathBuf, RefuseError> {
    let folder = open_error_folder(error_dir, order)?;
    let name = list.path.file_name().unwrap_or_default();
    let refusal = PendingRefusal { source: &list.path, folder: &folder, name, key };
    for n in 1..=disk::MAX_NAME_NUMBER {
        let (to, reason_file) = refusal.numbered_paths(n);
        let is_own = refusal.is_own_reason(&reason_file)?;
        if !is_own && (disk::path_exists(&to) || disk::path_exists(&reason_file)) {
            continue;
        }
        let write = |file: &Path, text: &str| {
            disk::write_file_atomically(file, text.as_bytes()).map_err(|e| io_error("write", file, e))
        };
        write(&reason_file, &refusal.reason_text(&list.order, reason))?;
        return write(&to, row).map(|()| to);
    }
    Err(io_error("find a free name in", &folder, io::ErrorKind::AlreadyExists.into()))
}

/// Creates `error_dir/order`. It is an error if somebody replaced a folder in this path by a link.
fn open_error_folder(error_dir: &Path, order: &Path) -> Result<PathBuf, RefuseError> {
    let folder = error_dir.join(order);
    match disk::create_dirs_beneath(error_dir, order) {
        Ok(_) => Ok(folder),
        Err(error) => Err(io_error("use the folder", &folder, error)),
    }
}

/// Writes the reason and then copies the stored file, if there is one, to `error_dir/<folder>/<name>`. Repeating it
/// with the same file changes nothing. Used for a part whose claim has ended.
pub fn copy_to_error_folder(
    stored: Option<&Path>,
    error_dir: &Path,
    folder: &str,
    display_name: &str,
    reason: &str,
) -> Result<(), RefuseError> {
    let folder = open_error_folder(error_dir, Path::new(folder))?;
    let name = raw_name(display_name).unwrap_or_else(|| display_name.into());
    let (to, reason_file) = (folder.join(&name), folder.join(with_suffix(&name, "", REASON_SUFFIX)));
    disk::write_file_atomically(&reason_file, reason.as_bytes()).map_err(|e| io_error("write", &reason_file, e))?;
    let Some(stored) = stored else { return Ok(()) };
    match disk::path_exists(&to) && disk::have_same_bytes(stored, &to) {
        true => Ok(()),
        false => disk::copy_noreplace(stored, &to).map_err(|e| io_error("copy to the error folder", stored, e)),
    }
}

/// Replaces the reason of a file that is already in the error folder.
pub fn rewrite_reason(reason_file: &Path, reason: &str) -> Result<(), RefuseError> {
    disk::write_file_atomically(reason_file, reason.as_bytes()).map_err(|e| io_error("write", reason_file, e))
}

struct PendingRefusal<'a> {
    source: &'a Path,
    folder: &'a Path,
    name: &'a OsStr,
    /// A line in the reason file that identifies this refusal.
    key: String,
}

impl PendingRefusal<'_> {
    fn write_and_move(
        &self,
        order: &str,
        reason: &str,
        step: &mut dyn FnMut(),
        move_to: impl FnOnce(&Path) -> io::Result<()>,
    ) -> Result<PathBuf, RefuseError> {
        step();
        let (to, reason_file) = self.find_free_paths()?;
        if !self.is_own_reason(&reason_file)? {
            let text = self.reason_text(order, reason);
            disk::write_file_atomically(&reason_file, text.as_bytes())
                .map_err(|e| io_error("write", &reason_file, e))?;
        }
        step();
        let moved = match disk::path_exists(&to) {
            // A crash happened after copying the file to another file system: only the original remains to be removed.
            true => fs::remove_file(self.source),
            false => move_to(&to),
        };
        moved.map_err(|e| io_error("refuse", self.source, e))?;
        step();
        Ok(to)
    }

    /// Finds the first number whose names are free, or used by an earlier attempt of this refusal.
    fn find_free_paths(&self) -> Result<(PathBuf, PathBuf), RefuseError> {
        for n in 1..=disk::MAX_NAME_NUMBER {
            let (to, reason_file) = self.numbered_paths(n);
            let is_free = match self.is_own_reason(&reason_file)? {
                true => !disk::path_exists(&to) || disk::have_same_bytes(self.source, &to),
                false => !disk::path_exists(&to) && !disk::path_exists(&reason_file),
            };
            if is_free {
                return Ok((to, reason_file));
            }
        }
        Err(io_error("find a free name in", self.folder, io::ErrorKind::AlreadyExists.into()))
    }

    fn numbered_paths(&self, n: u32) -> (PathBuf, PathBuf) {
        let number = if n == 1 { String::new() } else { format!(" ({n})") };
        (
            self.folder.join(numbered_name(self.name, n)),
            self.folder.join(with_suffix(self.name, &number, REASON_SUFFIX)),
        )
    }

    /// Path to which an earlier attempt moved the file. Somebody may have removed the file since.
    fn find_moved_file(&self) -> Result<PathBuf, RefuseError> {
        for n in 1..=disk::MAX_NAME_NUMBER {
            let (to, reason_file) = self.numbered_paths(n);
            if self.is_own_reason(&reason_file)? {
                return Ok(to);
            }
            if !disk::path_exists(&to) && !disk::path_exists(&reason_file) {
                break;
            }
        }
        Err(io_error("refuse", self.source, io::ErrorKind::NotFound.into()))
    }

    fn is_own_reason(&self, reason_file: &Path) -> Result<bool, RefuseError> {
        // A folder, pipe or link of that name is not a reason file.
        let text = disk::read_start(reason_file, MAX_REASON_BYTES).map_err(|e| io_error("read", reason_file, e))?;
        Ok(text.is_some_and(|text| text.split(|&b| b == b'\n').any(|line| line == self.key.as_bytes())))
    }

    fn reason_text(&self, order: &str, reason: &str) -> String {
        let name = display_name(self.name);
        let place = if order.is_empty() { name.clone() } else { format!("{order}/{name}") };
        let when = jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ");
        let (refused, reason) = (say!("reason-refused", name = &name), language::told(reason.trim_end()));
        let (file, when) = (say!("reason-file", place = place), say!("reason-when", time = when.to_string()));
        format!("{refused}\n\n{reason}\n\n{file}\n{when}\n{}\n", self.key)
    }
}

#[cfg(test)]
#[path = "tests/refuse_tests.rs"]
mod tests;
