//! The marker file of a queue folder: a random id that shows whether the folder was replaced or unmounted.

use std::{
    fs,
    io::{self, Write},
    path::Path,
};

const NAME: &str = ".nestd-queue";

/// The id in the marker, if there is one.
pub(super) fn read_marker_id(dir: &Path) -> io::Result<Option<String>> {
    match fs::read_to_string(dir.join(NAME)) {
        Ok(text) => Ok(Some(text.trim().to_owned()).filter(|id| !id.is_empty())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Reads the id in the marker; creates the marker if there is none. If two processes create it at once, the first one
/// wins.
pub(super) fn read_or_create_marker(dir: &Path) -> io::Result<String> {
    if let Some(id) = read_marker_id(dir)? {
        return Ok(id);
    }
    let mut file = tempfile::Builder::new().prefix(".nestd-queue-").tempfile_in(dir)?;
    writeln!(file, "{:032x}", rand::random::<u128>())?;
    access::apply_file_permissions(file.as_file())?;
    file.as_file().sync_all()?;
    // An empty marker, left by a full disk, does not count.
    if fs::metadata(dir.join(NAME)).is_ok_and(|meta| meta.len() == 0) {
        fs::remove_file(dir.join(NAME))?;
    }
    match file.persist_noclobber(dir.join(NAME)) {
        Err(error) if error.error.kind() != io::ErrorKind::AlreadyExists => return Err(error.error),
        _ => fs::File::open(dir)?.sync_all()?,
    }
    read_marker_id(dir)?.ok_or_else(|| io::Error::other("the marker .nestd-queue is empty"))
}
