//! Notes about parts that were given back to the hot folder. They keep what the order list said, because the list may
//! be gone since, and the original name, because the part may have got another one. The notes are in
//! `.claimed/.given/`, one per file, named by its inode.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use crate::{
    InboxEntry, ListLookup, display_name,
    folder::{claim_folder::CLAIMED_DIR, disk},
    names::name::raw_name,
};

/// Note about a part that was given back.
#[derive(Debug, Serialize, Deserialize)]
struct GivenBackNote {
    /// The name under which it was given back, escaped.
    now: String,
    /// The name under which it was dropped, escaped.
    dropped: String,
    said: ListLookup,
}

/// A part that was given back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct GivenBackPart {
    /// The name under which it was dropped.
    pub name: OsString,
    /// What its list said.
    pub lookup: ListLookup,
}

/// A longer file is not a note of nestd.
const MAX_BYTES: u64 = 16 << 20;

fn notes_dir(inbox: &Path) -> PathBuf {
    inbox.join(CLAIMED_DIR).join(".given")
}

/// Saves the note about a part before it is moved back to `to`, relative to the hot folder.
pub(super) fn save_note(inbox: &Path, part: &Path, to: &Path, said: ListLookup) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let shown = |path: &Path| display_name(path.file_name().unwrap_or_default());
    let note = GivenBackNote { now: shown(to), dropped: shown(part), said };
    let inode = fs::symlink_metadata(part)?.ino();
    let folder = notes_dir(inbox);
    disk::create_dirs_beneath(inbox, folder.strip_prefix(inbox).unwrap_or(&folder))?;
    disk::write_file_atomically(&folder.join(format!("{inode}.json")), &serde_json::to_vec(&note)?)
}

/// Finds the note about a part that was given back. `None` = it never was. A note about another file that had the same
/// inode is ignored.
pub(crate) fn find_given_back(inbox: &Path, part: &InboxEntry) -> Option<GivenBackPart> {
    let bytes = disk::read_start(&notes_dir(inbox).join(format!("{}.json", part.inode)), MAX_BYTES).ok()??;
    let note: GivenBackNote = serde_json::from_slice(&bytes).ok()?;
    let is_it = display_name(part.path.file_name()?) == note.now;
    is_it.then(|| GivenBackPart { name: raw_name(&note.dropped).unwrap_or_default(), lookup: note.said })
}

/// Deletes the note of a part that was claimed again.
pub(crate) fn delete_note(inbox: &Path, part: &InboxEntry) {
    let _ = fs::remove_file(notes_dir(inbox).join(format!("{}.json", part.inode)));
}
