//! Opens files in folders that other users may write into.

use std::{fs::File, io, path::Path};

use super::refuse::MAX_REASON_BYTES;
use crate::folder::disk;

/// Opens a regular file of the hot folder for reading. It may have been replaced since the scan, so no link is
/// followed, neither in its own path component nor above it, and a pipe does not block.
pub fn open_dropped_file(inbox: &Path, file: &Path) -> io::Result<File> {
    let relative = file.strip_prefix(inbox).map_err(|_| io::ErrorKind::InvalidInput)?;
    disk::open_beneath(inbox, relative)
}

/// Reads a reason file of the error folder. `None` if somebody replaced it by something that is not a file.
pub fn read_reason(file: &Path) -> io::Result<Option<String>> {
    let bytes = disk::read_start(file, MAX_REASON_BYTES)?;
    Ok(bytes.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()))
}
