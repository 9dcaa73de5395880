//! Lists the hot folder. The scan decides which files are there; file-system events only trigger a scan.

use std::{
    ffi::OsStr,
    fs, io,
    os::unix::fs::{FileTypeExt, MetadataExt},
    path::{Path, PathBuf},
};

use thiserror::Error;

use crate::{
    EntryKind, FoundList, InboxEntry,
    folder::{
        disk,
        file_role::{FileRole, file_role},
        ignore::{is_ignored, is_status_file},
    },
    lists::{
        folder_lists::{list_format, mark_lists},
        hidden_sidecar::is_hidden_sidecar,
        sidecars::UnreadableSidecars,
    },
    names::{
        name::{is_part_name, order_display_name},
        unordered_folder::is_bin_name,
    },
};

/// Name of the marker that nestd leaves in each hot folder.
const OWNER_MARKER: &str = ".nestd-owner";

/// Limits of one scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanLimits {
    /// Maximum depth of sub-folders below the hot folder.
    pub max_depth: usize,
    /// Maximum number of entries in one scan. The rest waits for the next scan.
    pub max_entries: usize,
}

impl Default for ScanLimits {
    fn default() -> Self {
        Self { max_depth: 8, max_entries: 200_000 }
    }
}

/// Result of a scan.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct InboxListing {
    /// All entries of the hot folder that are not ignored, sorted by path. Parts are left out while their ticket or
    /// list may be among the entries that could not be read.
    pub entries: Vec<InboxEntry>,
    /// Sub-folders that could not be listed and entries that could not be inspected, each with the reason in plain
    /// words.
    pub warnings: Vec<(PathBuf, String)>,
}

/// Why a scan failed. A failed scan never means that the files were deleted.
#[derive(Debug, Error)]
pub enum ScanError {
    /// The hot folder is missing, cannot be read, or is on another file system than before.
    #[error("the hot folder {} is unavailable: {why}", .inbox.display())]
    Unavailable {
        /// The hot folder.
        inbox: PathBuf,
        /// The reason, in plain words.
        why: String,
        /// The error of the operating system, if there was one.
        #[source]
        source: Option<io::Error>,
    },
}

/// A hot folder, with the file system that it was on at the first scan.
#[derive(Debug)]
pub struct InboxFolder {
    path: PathBuf,
    limits: ScanLimits,
    dev: Option<u64>,
}

impl InboxFolder {
    /// Refers to the hot folder. Does not access the disk.
    pub fn new(path: impl Into<PathBuf>, limits: ScanLimits) -> Self {
        Self { path: path.into(), limits, dev: None }
    }

    /// Path of the hot folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Lists the hot folder. If the file system differs from the first scan (unmounted, or another one mounted over
    /// it), the result is [`ScanError::Unavailable`], because missing files then prove nothing.
    pub fn scan(&mut self) -> Result<InboxListing, ScanError> {
        let dev = root_dev(&self.path)?;
        if let Some(first) = self.dev
            && first != dev
        {
            let why = "it is on another file system than when nestd first saw it; mount it again, or restart nestd";
            return Err(unavailable_error(&self.path, why, None));
        }
        let listing = scan_inbox(&self.path, self.limits)?;
        self.dev = Some(dev);
        Ok(listing)
    }
}

/// Lists a hot folder without comparing its file system with an earlier scan. The daemon uses [`InboxFolder::scan`].
pub fn scan_inbox(inbox: &Path, limits: ScanLimits) -> Result<InboxListing, ScanError> {
    let dev = root_dev(inbox)?;
    let mut walk = InboxWalker { inbox, limits, dev, listing: InboxListing::default() };
    walk.list_folder(Path::new(""), 0).map_err(|error| unavailable_error(inbox, "it cannot be listed", Some(error)))?;
    // The folder was unmounted during the scan: missing files prove nothing.
    if root_dev(inbox)? != dev {
        return Err(unavailable_error(inbox, "its file system changed while it was listed", None));
    }
    // A ticket that cannot be inspected now still exists, so its part has to wait for it.
    let unseen = UnreadableSidecars::from_paths(walk.listing.warnings.iter().map(|(path, _)| path.as_path()));
    walk.listing.entries.retain(|one| !unseen.may_belong_to(&one.path));
    walk.listing.entries.sort_by(|a, b| a.path.cmp(&b.path));
    mark_lists(inbox, &mut walk.listing.entries);
    Ok(walk.listing)
}

fn unavailable_error(inbox: &Path, why: &str, source: Option<io::Error>) -> ScanError {
    ScanError::Unavailable { inbox: inbox.to_owned(), why: why.to_owned(), source }
}

/// Returns the device number of the hot folder's file system. The hot folder itself may be a symbolic link.
fn root_dev(inbox: &Path) -> Result<u64, ScanError> {
    let meta = fs::metadata(inbox).map_err(|error| unavailable_error(inbox, "it is not there", Some(error)))?;
    match meta.is_dir() {
        true => Ok(meta.dev()),
        false => Err(unavailable_error(inbox, "it is not a folder", None)),
    }
}

struct InboxWalker<'a> {
    inbox: &'a Path,
    limits: ScanLimits,
    dev: u64,
    listing: InboxListing,
}

impl InboxWalker<'_> {
    /// Lists one folder, `depth` levels below the hot folder. An error means that the whole hot folder may be
    /// unavailable.
    fn list_folder(&mut self, order: &Path, depth: usize) -> io::Result<()> {
        let path = self.inbox.join(order);
        // What was the hot folder of another machine has its status still.
        let has_status = depth == 0 || path.join(OWNER_MARKER).exists();
        let entries = match fs::read_dir(&path) {
            Err(error) if depth > 0 => return self.handle_error(path, error),
            other => other?,
        };
        for entry in entries {
            let name = match entry {
                Err(error) if depth > 0 => return self.handle_error(path, error),
                other => other?.file_name(),
            };
            if self.listing.entries.len() >= self.limits.max_entries {
                let why = format!("holds more than {} files; the rest waits", self.limits.max_entries);
                self.listing.warnings.push((path, why));
                return Ok(());
            }
            let is_left = is_ignored(&name) && !is_hidden_sidecar(&name);
            if is_left || (has_status && is_status_file(&name)) {
                continue;
            }
            self.add_entry(order, &name, depth)?;
        }
        Ok(())
    }

    fn add_entry(&mut self, order: &Path, name: &OsStr, depth: usize) -> io::Result<()> {
        let path = self.inbox.join(order).join(name);
        let meta = match fs::symlink_metadata(&path) {
            Err(error) => return self.handle_error(path, error),
            Ok(meta) => meta,
        };
        if meta.is_dir() && (is_bin_name(name) || is_hidden_sidecar(name)) {
            return self.leave_folder(path, name);
        }
        if meta.is_dir() && depth < self.limits.max_depth && !is_file_name(name) {
            if meta.dev() != self.dev {
                self.listing.warnings.push((path, "is another file system; parts cannot be claimed from it".into()));
                return Ok(());
            }
            return self.list_folder(&order.join(name), depth + 1);
        }
        self.listing.entries.push(InboxEntry {
            path,
            order: order_display_name(order),
            kind: entry_kind(meta.file_type()),
            size: meta.len(),
            allocated: meta.blocks() * 512,
            ctime_ns: disk::ctime_ns(&meta),
            mtime_ns: disk::mtime_ns(&meta),
            inode: meta.ino(),
            dev: meta.dev(),
            is_private_link: disk::is_hard_link_to_private_file(&meta),
            found_list: FoundList::None,
        });
        Ok(())
    }

    /// Tells of a recycle bin that holds something.
    fn leave_folder(&mut self, path: PathBuf, name: &OsStr) -> io::Result<()> {
        let is_empty = || Ok(fs::read_dir(&path)?.next().is_none());
        match is_empty() {
            Err(error) => self.handle_error(path, error),
            Ok(false) if is_bin_name(name) => {
                self.listing.warnings.push((path, "is a recycle bin by its name, so nothing in it is printed".into()));
                Ok(())
            }
            Ok(_) => Ok(()),
        }
    }

    /// Handles an error for one entry. An entry that vanished during the scan is skipped. An entry without permission
    /// becomes a warning, and the scan goes on. Any other error (an unreachable server, a failing disk) fails the whole
    /// scan.
    fn handle_error(&mut self, path: PathBuf, error: io::Error) -> io::Result<()> {
        match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Ok(()),
            io::ErrorKind::PermissionDenied => {
                self.listing.warnings.push((path, "cannot be read: permission denied".to_owned()));
                Ok(())
            }
            _ => Err(error),
        }
    }
}

/// Whether a folder of this name is no order, but stands in the place of a part, a ticket or a list.
pub(super) fn is_file_name(name: &OsStr) -> bool {
    is_part_name(name) || file_role(name.as_ref()) != FileRole::Part || list_format(name.as_ref()).is_some()
}

fn entry_kind(file_type: fs::FileType) -> EntryKind {
    match file_type {
        t if t.is_file() => EntryKind::File,
        t if t.is_dir() => EntryKind::Directory,
        t if t.is_symlink() => EntryKind::Symlink,
        t if t.is_socket() => EntryKind::Socket,
        t if t.is_fifo() => EntryKind::Fifo,
        _ => EntryKind::Device,
    }
}

#[cfg(test)]
#[path = "tests/scan_tests.rs"]
mod tests;
