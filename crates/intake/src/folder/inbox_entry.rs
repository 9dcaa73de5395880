//! One entry of the hot folder, as a scan found it.

use std::path::PathBuf;

/// Type of an entry in the hot folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EntryKind {
    /// A regular file: a part, a ticket or an order list.
    File,
    /// A symbolic link; never followed.
    Symlink,
    /// A folder that cannot be an order, because it has the name of a part file or is nested too deep.
    Directory,
    /// A socket.
    Socket,
    /// A named pipe.
    Fifo,
    /// A block or character device.
    Device,
}

/// What a look into a text file of the hot folder found beside what its name says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FoundList {
    /// Nothing.
    #[default]
    None,
    /// An order list that names a file beside it, or one that was taken.
    Readable,
    /// A list in a format that nestd does not read, such as `order.json`, beside parts.
    Foreign,
    /// No list: a table with the name of the part beside it (`part.stl.csv`), whose rows name no file.
    OfPart,
}

/// One entry of the hot folder, as a scan found it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InboxEntry {
    /// Full path.
    pub path: PathBuf,
    /// Sub-folders between the hot folder and this entry, escaped for display and joined by `/`. Empty = none.
    pub order: String,
    /// Type of the entry.
    pub kind: EntryKind,
    /// Size, bytes.
    pub size: u64,
    /// Bytes allocated on the disk. Fewer than `size` means that the file has a hole, perhaps because a copy is in
    /// progress.
    pub allocated: u64,
    /// Last change of contents or attributes, nanoseconds since 1970.
    pub ctime_ns: i128,
    /// Modification time as set by the copying program, nanoseconds since 1970.
    pub mtime_ns: i128,
    /// Inode number.
    pub inode: u64,
    /// Device number of the file system.
    pub dev: u64,
    /// Whether this is one of several hard links to a file that is not readable by everyone.
    pub is_private_link: bool,
    /// Whether its content is an order list, although its name does not say so.
    pub found_list: FoundList,
}

/// Why a ticket or list cannot be read, whatever is in it, and what helps: a sentence without its subject, which is the name of
/// the file.
pub(crate) fn unreadable_reason(seen: &InboxEntry) -> Option<String> {
    let kind = match seen.kind {
        // Of what is hidden, a scan lists tickets and lists alone.
        EntryKind::File if is_hidden(seen) => {
            return Some(
                "is hidden, so nestd does not read it: take away the dot at the start of its name, or delete it"
                    .to_owned(),
            );
        }
        // The user who made the link may not be allowed to read the file.
        EntryKind::File if seen.is_private_link => {
            return Some(
                "is a hard link (it has another name elsewhere) and not everyone may read it, so nestd neither reads it nor \
                 prints parts according to it: drop a copy of the file"
                    .to_owned(),
            );
        }
        EntryKind::File => return None,
        EntryKind::Symlink => "a symbolic link",
        EntryKind::Directory => "a folder",
        EntryKind::Socket => "a socket",
        EntryKind::Fifo => "a named pipe",
        EntryKind::Device => "a device",
    };
    Some(format!("is {kind}, so nestd does not read it: put the file itself in its place"))
}

/// Whether the name of an entry begins with a dot.
pub(crate) fn is_hidden(seen: &InboxEntry) -> bool {
    seen.path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}
