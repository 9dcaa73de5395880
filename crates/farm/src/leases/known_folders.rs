//! Which folders this farm has served, stored in the state folder across restarts: so an empty mount point is not taken
//! for a new archive.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

/// Name of the file in the state directory: each folder with its device and inode.
const FILE: &str = "nestd.folders";

/// Whether this farm has served the folder.
pub fn is_known_folder(state_dir: &Path, folder: &Path) -> bool {
    known_identity(state_dir, folder).is_some()
}

/// Device and inode of a folder when this farm last served it.
pub(super) fn known_identity(state_dir: &Path, folder: &Path) -> Option<(u64, u64)> {
    read_known_folders(state_dir).unwrap_or_default().get(folder).copied()
}

/// Records that the folder is served; the entry is on disk when this returns.
pub(super) fn remember_folder(state_dir: &Path, folder: &Path, now: (u64, u64)) -> io::Result<()> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let mut folders = read_known_folders(state_dir)?;
    if folders.insert(folder.to_owned(), now) == Some(now) {
        return Ok(());
    }
    let mut file = tempfile::Builder::new().prefix(".nestd-folders-").tempfile_in(state_dir)?;
    file.write_all(serde_json::to_string_pretty(&folders)?.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(state_dir.join(FILE))?;
    File::open(state_dir)?.sync_all()
}

fn read_known_folders(state_dir: &Path) -> io::Result<BTreeMap<PathBuf, (u64, u64)>> {
    match fs::read_to_string(state_dir.join(FILE)) {
        // A crash cannot tear this file; an unreadable file counts as empty.
        Ok(text) => Ok(serde_json::from_str(&text).unwrap_or_default()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(BTreeMap::new()),
        Err(error) => Err(error),
    }
}
