//! Which folders this farm has served, remembered in the state folder over restarts: an empty mount point in the place of an
//! archive is told from an archive that is new.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

/// In the state directory: each folder with the device and inode that it had.
const FILE: &str = "nestd.folders";

/// Whether this farm has served the folder.
pub fn is_known(state_dir: &Path, folder: &Path) -> bool {
    known(state_dir, folder).is_some()
}

/// Device and inode of a folder when this farm served it last.
pub(super) fn known(state_dir: &Path, folder: &Path) -> Option<(u64, u64)> {
    all(state_dir).unwrap_or_default().get(folder).copied()
}

/// Writes down that the folder is served, on disk when it returns.
pub(super) fn remember(state_dir: &Path, folder: &Path, now: (u64, u64)) -> io::Result<()> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let mut folders = all(state_dir)?;
    if folders.insert(folder.to_owned(), now) == Some(now) {
        return Ok(());
    }
    let mut file = tempfile::Builder::new().prefix(".nestd-folders-").tempfile_in(state_dir)?;
    file.write_all(serde_json::to_string_pretty(&folders)?.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(state_dir.join(FILE))?;
    File::open(state_dir)?.sync_all()
}

fn all(state_dir: &Path) -> io::Result<BTreeMap<PathBuf, (u64, u64)>> {
    match fs::read_to_string(state_dir.join(FILE)) {
        // A crash cannot tear it; one that nobody can read knows nothing.
        Ok(text) => Ok(serde_json::from_str(&text).unwrap_or_default()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(BTreeMap::new()),
        Err(error) => Err(error),
    }
}
