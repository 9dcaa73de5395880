//! Refuses: moves to the error folder, beside a file that says why. Nothing is overwritten, nothing is lost.
//!
//! The reason is written first, so that a crash never leaves a file there that nobody can explain; the reason knows
//! whose it is, so that the next try goes on where the crash was.

use std::{
    ffi::OsStr,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use thiserror::Error;

use super::{
    Claim, Seen,
    claim_folder::claiming,
    disk, display_name,
    name::{numbered, raw_name, with_suffix},
    recover::{follower_name, remove_claim_dir},
};

/// No reason of ours is longer.
pub(super) const MAX_REASON_BYTES: u64 = 1 << 20;
/// How the name of a reason ends.
const REASON: &str = ".reason.txt";

/// Why something could not be refused; it stays where it is.
#[derive(Debug, Error)]
#[error("cannot {what} {}", .path.display())]
pub struct RefuseError {
    /// What was tried.
    pub what: &'static str,
    /// On what.
    pub path: PathBuf,
    /// The error of the system.
    #[source]
    pub source: io::Error,
}

pub(super) fn io_error(what: &'static str, path: &Path, source: io::Error) -> RefuseError {
    RefuseError { what, path: path.to_owned(), source }
}

/// Moves a claimed part and its tickets into `error_dir/[order/]`, beside `<name>.reason.txt`. Returns where the part
/// is. `reason` is whole sentences for the technician. Safe to repeat until it succeeds.
pub fn refuse(claim: &Claim, error_dir: &Path, reason: &str) -> Result<PathBuf, RefuseError> {
    refuse_stepwise(claim, error_dir, reason, &mut || {})
}

pub(super) fn refuse_stepwise(
    claim: &Claim,
    error_dir: &Path,
    reason: &str,
    step: &mut dyn FnMut(),
) -> Result<PathBuf, RefuseError> {
    let _only_one = claiming(&claim.inbox);
    let folder = open_folder(error_dir, &claim.order_path)?;
    let refusal =
        Refusal { source: &claim.part, folder: &folder, name: &claim.name, key: format!("Claim: {}", claim.id) };
    let relative = claim.part.strip_prefix(&claim.inbox).unwrap_or(&claim.part);
    let to = match fs::symlink_metadata(&claim.part) {
        Ok(_) => refusal.write_and_move(&claim.order, reason, step, |to| disk::move_out(&claim.inbox, relative, to))?,
        // An earlier try moved it and failed after that.
        Err(error) if error.kind() == io::ErrorKind::NotFound => refusal.place_of_ours()?,
        Err(error) => return Err(io_error("look at", &claim.part, error)),
    };
    for ticket in &claim.tickets {
        let name = follower_name(to.file_name().unwrap_or_default(), ticket);
        if disk::try_is_there(ticket).map_err(|e| io_error("look at", ticket, e))? {
            disk::move_to_free_name(ticket, &folder, &name).map_err(|e| io_error("refuse", ticket, e))?;
        }
        step();
    }
    remove_claim_dir(&claim.dir, step).map_err(|e| io_error("remove", &claim.dir, e))?;
    Ok(to)
}

/// Moves what was never claimed (a link, a socket, a folder, an orphan ticket) out of `inbox` likewise.
pub fn refuse_path(inbox: &Path, seen: &Seen, error_dir: &Path, reason: &str) -> Result<PathBuf, RefuseError> {
    let gone = || io_error("refuse", &seen.path, io::ErrorKind::NotFound.into());
    let relative = seen.path.strip_prefix(inbox).map_err(|_| gone())?;
    let meta = fs::symlink_metadata(&seen.path).map_err(|e| io_error("refuse", &seen.path, e))?;
    if (meta.dev(), meta.ino()) != (seen.dev, seen.inode) {
        return Err(gone());
    }
    let folder = open_folder(error_dir, relative.parent().unwrap_or(Path::new("")))?;
    let name = seen.path.file_name().unwrap_or_default();
    let refusal =
        Refusal { source: &seen.path, folder: &folder, name, key: format!("Inode: {}-{}", seen.inode, seen.mtime_ns) };
    refusal.write_and_move(&seen.order, reason, &mut || {}, |to| disk::move_out(inbox, relative, to))
}

/// Makes `error_dir/order`. An order folder in there that somebody made a link is no place for refused files.
fn open_folder(error_dir: &Path, order: &Path) -> Result<PathBuf, RefuseError> {
    let folder = error_dir.join(order);
    match disk::create_dirs_beneath(error_dir, order) {
        Ok(_) => Ok(folder),
        Err(error) => Err(io_error("use the folder", &folder, error)),
    }
}

/// Copies a stored file, where there is one, to `error_dir/<folder>/<name>`, after its reason; the same copy again changes
/// nothing. For a part whose claim has ended.
pub fn refuse_copy(
    stored: Option<&Path>,
    error_dir: &Path,
    folder: &str,
    display_name: &str,
    reason: &str,
) -> Result<(), RefuseError> {
    let folder = open_folder(error_dir, Path::new(folder))?;
    let name = raw_name(display_name).unwrap_or_else(|| display_name.into());
    let (to, reason_file) = (folder.join(&name), folder.join(with_suffix(&name, "", REASON)));
    disk::write_by_rename(&reason_file, reason.as_bytes()).map_err(|e| io_error("write", &reason_file, e))?;
    let Some(stored) = stored else { return Ok(()) };
    match disk::is_there(&to) && disk::same_bytes(stored, &to) {
        true => Ok(()),
        false => disk::copy_noreplace(stored, &to).map_err(|e| io_error("copy to the error folder", stored, e)),
    }
}

/// Another reason for a file that is in the error folder already.
pub fn rewrite_reason(reason_file: &Path, reason: &str) -> Result<(), RefuseError> {
    disk::write_by_rename(reason_file, reason.as_bytes()).map_err(|e| io_error("write", reason_file, e))
}

struct Refusal<'a> {
    source: &'a Path,
    folder: &'a Path,
    name: &'a OsStr,
    /// A line that tells this refusal's reason from another one's.
    key: String,
}

impl Refusal<'_> {
    fn write_and_move(
        &self,
        order: &str,
        reason: &str,
        step: &mut dyn FnMut(),
        move_to: impl FnOnce(&Path) -> io::Result<()>,
    ) -> Result<PathBuf, RefuseError> {
        step();
        let (to, reason_file) = self.free_place()?;
        if !self.is_ours(&reason_file)? {
            let text = self.reason_text(order, reason);
            disk::write_by_rename(&reason_file, text.as_bytes()).map_err(|e| io_error("write", &reason_file, e))?;
        }
        step();
        let moved = match disk::is_there(&to) {
            // A crash after copying it to another file system: the original is what is left to go.
            true => fs::remove_file(self.source),
            false => move_to(&to),
        };
        moved.map_err(|e| io_error("refuse", self.source, e))?;
        step();
        Ok(to)
    }

    /// The first number whose names are free, or ours from an earlier try.
    fn free_place(&self) -> Result<(PathBuf, PathBuf), RefuseError> {
        for n in 1..=disk::MAX_NUMBER {
            let (to, reason_file) = self.place(n);
            let is_free = match self.is_ours(&reason_file)? {
                true => !disk::is_there(&to) || disk::same_bytes(self.source, &to),
                false => !disk::is_there(&to) && !disk::is_there(&reason_file),
            };
            if is_free {
                return Ok((to, reason_file));
            }
        }
        Err(io_error("find a free name in", self.folder, io::ErrorKind::AlreadyExists.into()))
    }

    fn place(&self, n: u32) -> (PathBuf, PathBuf) {
        let number = if n == 1 { String::new() } else { format!(" ({n})") };
        (self.folder.join(numbered(self.name, n)), self.folder.join(with_suffix(self.name, &number, REASON)))
    }

    /// Where an earlier try moved it to; somebody may have taken it away since.
    fn place_of_ours(&self) -> Result<PathBuf, RefuseError> {
        for n in 1..=disk::MAX_NUMBER {
            let (to, reason_file) = self.place(n);
            if self.is_ours(&reason_file)? {
                return Ok(to);
            }
            if !disk::is_there(&to) && !disk::is_there(&reason_file) {
                break;
            }
        }
        Err(io_error("refuse", self.source, io::ErrorKind::NotFound.into()))
    }

    fn is_ours(&self, reason_file: &Path) -> Result<bool, RefuseError> {
        // A folder, pipe or link of that name is nobody's reason.
        let text = disk::read_start(reason_file, MAX_REASON_BYTES).map_err(|e| io_error("read", reason_file, e))?;
        Ok(text.is_some_and(|text| text.split(|&b| b == b'\n').any(|line| line == self.key.as_bytes())))
    }

    fn reason_text(&self, order: &str, reason: &str) -> String {
        let name = display_name(self.name);
        let place = if order.is_empty() { name.clone() } else { format!("{order}/{name}") };
        let when = jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ");
        format!("{name} was refused.\n\n{}\n\nFile: {place}\nWhen: {when}\n{}\n", reason.trim_end(), self.key)
    }
}

#[cfg(test)]
#[path = "refuse_tests.rs"]
mod tests;
