//! Opens what stands in folders that others may write into, to look at it.

use std::{fs::File, io, path::Path};

use super::{disk, refuse::MAX_REASON_BYTES};

/// Opens a regular file of the hot folder to read. It may have been swapped for something else since it was listed: no link
/// is followed, neither in its own place nor above it, and no pipe is waited for.
pub fn open_dropped(inbox: &Path, file: &Path) -> io::Result<File> {
    let relative = file.strip_prefix(inbox).map_err(|_| io::ErrorKind::InvalidInput)?;
    disk::open_beneath(inbox, relative)
}

/// What a reason in the error folder says; `None` where somebody has put something else in its place.
pub fn read_reason(file: &Path) -> io::Result<Option<String>> {
    let bytes = disk::read_start(file, MAX_REASON_BYTES)?;
    Ok(bytes.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()))
}
