//! Opens what stands in folders that others may write into, to look at it.

use std::{fs::File, io, path::Path};

use rustix::io::Errno;

use super::disk;

/// No reason of ours is longer.
const MAX_REASON_BYTES: u64 = 1 << 20;

/// Opens a regular file of the hot folder to read. It may have been swapped for something else since it was listed: no link
/// is followed, neither in its own place nor above it, and no pipe is waited for.
pub fn open_dropped(inbox: &Path, file: &Path) -> io::Result<File> {
    let relative = file.strip_prefix(inbox).map_err(|_| io::ErrorKind::InvalidInput)?;
    disk::open_beneath(inbox, relative)
}

/// What a reason in the error folder says; `None` where there is none, or somebody has put something else in its place.
pub fn read_reason(file: &Path) -> io::Result<Option<String>> {
    use io::ErrorKind::{InvalidInput, IsADirectory, NotFound};
    match disk::read_start(file, MAX_REASON_BYTES) {
        Ok(text) => Ok(Some(String::from_utf8_lossy(&text).into_owned())),
        Err(error) if [InvalidInput, IsADirectory, NotFound].contains(&error.kind()) => Ok(None),
        // A link or a socket.
        Err(error) if [Errno::LOOP, Errno::NXIO].map(Errno::raw_os_error).map(Some).contains(&error.raw_os_error()) => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
