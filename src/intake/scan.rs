//! Lists the hot folder. The scan is the truth about what stands there; file-system events only say "look".

use std::{
    ffi::OsStr,
    fs, io,
    os::unix::fs::{FileTypeExt, MetadataExt},
    path::{Path, PathBuf},
};

use thiserror::Error;

use super::{
    Kind, Seen,
    beside::Unseen,
    disk,
    ignore::{is_ignored, is_own},
    name::{is_part_name, order_name},
};

/// How far a scan goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanLimits {
    /// Sub-folders below the hot folder.
    pub max_depth: usize,
    /// Things listed in one scan; the rest waits for the next one.
    pub max_entries: usize,
}

impl Default for ScanLimits {
    fn default() -> Self {
        Self { max_depth: 8, max_entries: 200_000 }
    }
}

/// What a scan found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Listing {
    /// What stands in the hot folder and is not ignored, sorted by path; without parts whose ticket or list may be among the
    /// troubles.
    pub seen: Vec<Seen>,
    /// Sub-folders that could not be listed and things that could not be looked at, each with the reason in plain words.
    pub troubles: Vec<(PathBuf, String)>,
}

/// Why there is no listing. It never means that the files were deleted.
#[derive(Debug, Error)]
pub enum ScanError {
    /// The hot folder is not there, cannot be read, or is another file system than before.
    #[error("the hot folder {} is unavailable: {why}", .inbox.display())]
    Unavailable {
        /// The hot folder.
        inbox: PathBuf,
        /// In plain words.
        why: String,
        /// The error of the system, if there was one.
        #[source]
        source: Option<io::Error>,
    },
}

/// A hot folder that remembers which file system it is on.
#[derive(Debug)]
pub struct Inbox {
    path: PathBuf,
    limits: ScanLimits,
    dev: Option<u64>,
}

impl Inbox {
    /// Names the hot folder; touches nothing.
    pub fn new(path: impl Into<PathBuf>, limits: ScanLimits) -> Self {
        Self { path: path.into(), limits, dev: None }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Lists it. Another file system than at the first scan (unmounted, or something mounted over it) is
    /// [`ScanError::Unavailable`]: nothing may be concluded from what is missing there.
    pub fn scan(&mut self) -> Result<Listing, ScanError> {
        let dev = root_dev(&self.path)?;
        if let Some(first) = self.dev
            && first != dev
        {
            let why = "it is on another file system than when nestd first saw it; mount it again, or restart nestd";
            return Err(unavailable(&self.path, why, None));
        }
        let listing = scan(&self.path, self.limits)?;
        self.dev = Some(dev);
        Ok(listing)
    }
}

/// Lists a hot folder without a memory of its file system; [`Inbox::scan`] is the daemon's.
pub fn scan(inbox: &Path, limits: ScanLimits) -> Result<Listing, ScanError> {
    let dev = root_dev(inbox)?;
    let mut walk = Walk { inbox, limits, dev, listing: Listing::default() };
    walk.folder(Path::new(""), 0).map_err(|error| unavailable(inbox, "it cannot be listed", Some(error)))?;
    // Unmounted while it was listed: what is missing says nothing.
    if root_dev(inbox)? != dev {
        return Err(unavailable(inbox, "its file system changed while it was listed", None));
    }
    // A ticket that cannot be looked at now is there all the same: its part waits for it.
    let unseen = Unseen::of(walk.listing.troubles.iter().map(|(path, _)| path.as_path()));
    walk.listing.seen.retain(|one| !unseen.may_belong_to(&one.path));
    walk.listing.seen.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(walk.listing)
}

fn unavailable(inbox: &Path, why: &str, source: Option<io::Error>) -> ScanError {
    ScanError::Unavailable { inbox: inbox.to_owned(), why: why.to_owned(), source }
}

/// The file system of a hot folder, which may itself be reached by a link.
fn root_dev(inbox: &Path) -> Result<u64, ScanError> {
    let meta = fs::metadata(inbox).map_err(|error| unavailable(inbox, "it is not there", Some(error)))?;
    match meta.is_dir() {
        true => Ok(meta.dev()),
        false => Err(unavailable(inbox, "it is not a folder", None)),
    }
}

struct Walk<'a> {
    inbox: &'a Path,
    limits: ScanLimits,
    dev: u64,
    listing: Listing,
}

impl Walk<'_> {
    /// Lists one folder, `depth` sub-folders below the hot folder. An error means that the whole hot folder is in doubt.
    fn folder(&mut self, order: &Path, depth: usize) -> io::Result<()> {
        let path = self.inbox.join(order);
        let entries = match fs::read_dir(&path) {
            Err(error) if depth > 0 => return self.trouble(path, error),
            other => other?,
        };
        for entry in entries {
            let name = match entry {
                Err(error) if depth > 0 => return self.trouble(path, error),
                other => other?.file_name(),
            };
            if self.listing.seen.len() >= self.limits.max_entries {
                let why = format!("holds more than {} files; the rest waits", self.limits.max_entries);
                self.listing.troubles.push((path, why));
                return Ok(());
            }
            if is_ignored(&name) || (depth == 0 && is_own(&name)) {
                continue;
            }
            self.entry(order, &name, depth)?;
        }
        Ok(())
    }

    fn entry(&mut self, order: &Path, name: &OsStr, depth: usize) -> io::Result<()> {
        let path = self.inbox.join(order).join(name);
        let meta = match fs::symlink_metadata(&path) {
            Err(error) => return self.trouble(path, error),
            Ok(meta) => meta,
        };
        if meta.is_dir() && depth < self.limits.max_depth && !is_part_name(name) {
            if meta.dev() != self.dev {
                self.listing.troubles.push((path, "is another file system; parts cannot be claimed from it".into()));
                return Ok(());
            }
            return self.folder(&order.join(name), depth + 1);
        }
        self.listing.seen.push(Seen {
            path,
            order: order_name(order),
            kind: kind(meta.file_type()),
            size: meta.len(),
            allocated: meta.blocks() * 512,
            ctime_ns: disk::ctime_ns(&meta),
            mtime_ns: disk::mtime_ns(&meta),
            inode: meta.ino(),
            dev: meta.dev(),
            is_secret: disk::is_second_name_of_a_secret(&meta),
        });
        Ok(())
    }

    /// A thing that vanished while it was listed is none of ours, one without permission is noted and the rest goes on;
    /// anything else (an unreachable server, a failing disk) puts the whole hot folder in doubt.
    fn trouble(&mut self, path: PathBuf, error: io::Error) -> io::Result<()> {
        match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Ok(()),
            io::ErrorKind::PermissionDenied => {
                self.listing.troubles.push((path, "cannot be read: permission denied".to_owned()));
                Ok(())
            }
            _ => Err(error),
        }
    }
}

fn kind(file_type: fs::FileType) -> Kind {
    match file_type {
        t if t.is_file() => Kind::File,
        t if t.is_dir() => Kind::Directory,
        t if t.is_symlink() => Kind::Symlink,
        t if t.is_socket() => Kind::Socket,
        t if t.is_fifo() => Kind::Fifo,
        _ => Kind::Device,
    }
}

#[cfg(test)]
#[path = "scan_tests.rs"]
mod tests;
