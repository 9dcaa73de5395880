//! Whether a folder is the one that it should be, for others than the daemon that serves it.

use std::{fs, path::Path};

use super::{
    owner::{Mark, Owner, OwnerError, identity, read},
    served::known,
};

/// Whether a folder can be read and is the one that this farm has served, or was never served by it. What lies in any other
/// says nothing, least of all that there is nothing. Usable without a daemon, and beside one.
///
/// # Errors
/// It is not there or cannot be read; its marker is missing though it had one; another daemon serves it.
pub fn demand_readable(state_dir: &Path, folder: &Path) -> Result<(), OwnerError> {
    let io = |source| OwnerError::Io { folder: folder.to_owned(), why: source };
    let now = identity(folder).map_err(io)?;
    fs::read_dir(folder).map_err(io)?;
    match read(folder).map_err(io)? {
        Mark::Blank => Ok(()),
        Mark::Missing if known(state_dir, folder).is_none_or(|was| was == now) => Ok(()),
        Mark::Missing => Err(OwnerError::Replaced(folder.to_owned())),
        Mark::Of(owner) if owner.is_of_state(state_dir) || !owner.may_live() => Ok(()),
        Mark::Of(owner) => Err(OwnerError::Other { folder: folder.to_owned(), owner }),
    }
}

impl Owner {
    /// Whether it names the farm of this state directory, whose number may have been lost with it.
    fn is_of_state(&self, state_dir: &Path) -> bool {
        fs::canonicalize(state_dir).is_ok_and(|own| own == *self.state_dir()) && self.is_here()
    }
}
