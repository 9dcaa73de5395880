//! Checks whether a folder is the expected one, for processes other than the daemon that serves it.

use std::{fs, path::Path};

use super::{
    folder_lease::{LeaseError, LeaseHolder, LeaseMarker, folder_identity, read_marker},
    known_folders::known_identity,
};

/// Checks that a folder can be read, and that this farm has served it or never knew it. The contents of any other
/// folder say nothing; it must not be taken for an empty one. Works with and without a running daemon.
///
/// # Errors
/// The folder is missing or cannot be read; its marker is missing although it had one; or another daemon serves it.
pub fn check_readable(state_dir: &Path, folder: &Path) -> Result<(), LeaseError> {
    let io = |source| LeaseError::Io { folder: folder.to_owned(), why: source };
    let now = folder_identity(folder).map_err(io)?;
    fs::read_dir(folder).map_err(io)?;
    match read_marker(folder).map_err(io)? {
        LeaseMarker::NoHolder => Ok(()),
        LeaseMarker::Missing if known_identity(state_dir, folder).is_none_or(|was| was == now) => Ok(()),
        LeaseMarker::Missing => Err(LeaseError::Replaced(folder.to_owned())),
        LeaseMarker::HeldBy(holder) if holder.belongs_to_state_dir(state_dir) || !holder.may_be_alive() => Ok(()),
        LeaseMarker::HeldBy(holder) => Err(LeaseError::HeldByOther { folder: folder.to_owned(), holder }),
    }
}

impl LeaseHolder {
    /// Whether this is the farm of the state directory, even if the farm's id was lost with it.
    fn belongs_to_state_dir(&self, state_dir: &Path) -> bool {
        fs::canonicalize(state_dir).is_ok_and(|own| own == *self.state_dir()) && self.is_on_this_host()
    }
}
