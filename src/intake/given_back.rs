//! What was said about a part that had to be given back to the hot folder: its list may be gone since, and its name may have
//! been taken. Notes lie in `.claimed/.given/`, one for each file, by its inode.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{Said, Seen, claim_folder::CLAIMED_DIR, disk, display_name, name::raw_name};

/// A note.
#[derive(Debug, Serialize, Deserialize)]
struct Note {
    /// The name under which it was given back, escaped.
    now: String,
    /// The name under which it was dropped, escaped.
    dropped: String,
    said: Said,
}

/// A part that was given back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct GivenBack {
    /// The name under which it was dropped.
    pub name: OsString,
    /// What its list said.
    pub said: Said,
}

/// Longer notes are nobody's.
const MAX_BYTES: u64 = 16 << 20;

fn folder(inbox: &Path) -> PathBuf {
    inbox.join(CLAIMED_DIR).join(".given")
}

/// Notes what is said about a part before it goes back as `to`, relative to the hot folder.
pub(super) fn keep(inbox: &Path, part: &Path, to: &Path, said: Said) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let shown = |path: &Path| display_name(path.file_name().unwrap_or_default());
    let note = Note { now: shown(to), dropped: shown(part), said };
    let inode = fs::symlink_metadata(part)?.ino();
    let folder = folder(inbox);
    disk::create_dirs_beneath(inbox, folder.strip_prefix(inbox).unwrap_or(&folder))?;
    disk::write_by_rename(&folder.join(format!("{inode}.json")), &serde_json::to_vec(&note)?)
}

/// What is known of a part that was given back; `None` = it never was. A note of another file with the same inode is none.
pub(super) fn find(inbox: &Path, part: &Seen) -> Option<GivenBack> {
    let bytes = disk::read_start(&folder(inbox).join(format!("{}.json", part.inode)), MAX_BYTES).ok()??;
    let note: Note = serde_json::from_slice(&bytes).ok()?;
    let is_it = display_name(part.path.file_name()?) == note.now;
    is_it.then(|| GivenBack { name: raw_name(&note.dropped).unwrap_or_default(), said: note.said })
}

/// A part was claimed again: its note has done its work.
pub(super) fn forget(inbox: &Path, part: &Seen) {
    let _ = fs::remove_file(folder(inbox).join(format!("{}.json", part.inode)));
}
