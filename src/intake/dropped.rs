//! Opens what stands in the hot folder to look at it before it is claimed.

use std::{fs::File, io, path::Path};

use super::disk;

/// Opens a regular file of the hot folder to read. It may have been swapped for something else since it was listed: no link
/// is followed, neither in its own place nor above it, and no pipe is waited for.
pub fn open_dropped(inbox: &Path, file: &Path) -> io::Result<File> {
    let relative = file.strip_prefix(inbox).map_err(|_| io::ErrorKind::InvalidInput)?;
    disk::open_beneath(inbox, relative)
}
