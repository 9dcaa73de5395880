//! What a scan finds: one thing in the hot folder.

use std::path::PathBuf;

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
    /// Whether it is a hard link to a file that not everybody may read.
    pub is_secret: bool,
}
