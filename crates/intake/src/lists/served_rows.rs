//! Records which rows of an order list were served, as marks on the disk that survive a restart.

use std::{
    collections::HashMap,
    ffi::{OsStr, OsString},
    fs,
    io::{self, Write},
    os::unix::ffi::{OsStrExt, OsStringExt},
    path::{Path, PathBuf},
    time::Duration,
};

use crate::{
    InboxEntry,
    folder::{claim_folder::CLAIMED_DIR, disk},
};

/// Content of the mark of a row that was applied to a part taken before the list came. No file has such a name.
const LATE_MARK: &str = "/late";

/// Content of the mark of a row that could not be used for the part that it means.
const UNUSED_MARK: &str = "/unused";

/// The longest path below a list that a mark holds, bytes.
const MAX_PATH_BYTES: u64 = 4096;

/// Marks of lists that somebody deleted are removed after this time.
const STALE_MARKS: Duration = Duration::from_secs(7 * 24 * 3600);

/// The path of a part below the folder of its list: its name, where it is beside the list.
pub(crate) fn path_below_list(part: &Path, list: &Path) -> OsString {
    let below = list.parent().and_then(|folder| part.strip_prefix(folder).ok());
    below.map_or_else(|| part.file_name().unwrap_or_default(), Path::as_os_str).to_owned()
}

/// Records on disk that a row of a list was served, and by which file (its path below the folder of the list). This happens before the
/// claim is complete; if the claim then fails, the part is still in the folder and is matched again.
pub(crate) fn mark_served(inbox: &Path, list: &InboxEntry, row_file: &str, name: &OsStr) -> io::Result<()> {
    let marks = marks_dir(inbox, list);
    let below = marks.strip_prefix(inbox).unwrap_or(&marks);
    disk::create_dirs_beneath(inbox, below)?;
    let mut file = disk::create_fresh_file(&marks.join(mark_name(row_file)))?;
    file.write_all(name.as_bytes())?;
    file.sync_all()?;
    disk::fsync_dir(&marks)
}

/// Records that a row is done with: it was applied to a part that was taken before the list came, or was refused.
pub(crate) fn mark_row_late(inbox: &Path, list: &InboxEntry, row_file: &str) -> io::Result<()> {
    mark_served(inbox, list, row_file, OsStr::new(LATE_MARK))
}

/// Records that a row means a part that was claimed, and could not be used for it: the part is refused, or asked about.
pub(crate) fn mark_row_unused(inbox: &Path, list: &InboxEntry, row_file: &str) -> io::Result<()> {
    mark_served(inbox, list, row_file, OsStr::new(UNUSED_MARK))
}

/// The rows of a list that were served, according to the marks.
#[derive(Debug)]
pub(crate) struct ServedRows {
    pub dir: PathBuf,
    /// Name of the file that served a row, by the name of the row's mark.
    served: HashMap<String, OsString>,
}

impl ServedRows {
    /// Loads the marks from the disk. Unreadable marks are skipped.
    pub fn load_marks(inbox: &Path, list: &InboxEntry) -> Self {
        let dir = marks_dir(inbox, list);
        let entries = fs::read_dir(&dir).into_iter().flatten().flatten();
        let mark = |entry: fs::DirEntry| {
            let bytes = disk::read_start(&entry.path(), MAX_PATH_BYTES).ok()??;
            Some((entry.file_name().into_string().ok()?, OsString::from_vec(bytes)))
        };
        let served = entries.filter_map(mark).collect();
        Self { dir, served }
    }

    /// Whether the disk holds as many marks as were loaded.
    pub fn are_complete(&self) -> bool {
        fs::read_dir(&self.dir).map_or(0, Iterator::count) == self.served.len()
    }

    /// Adds a mark that is already on the disk.
    pub fn add_served(&mut self, row_file: &str, name: &OsStr) {
        self.served.insert(mark_name(row_file), name.to_owned());
    }

    /// Adds the mark of a row that could not be used, which is already on the disk.
    pub fn add_unused(&mut self, row_file: &str) {
        self.add_served(row_file, OsStr::new(UNUSED_MARK));
    }

    /// Whether the row of a file was served.
    pub fn is_served(&self, row_file: &str) -> bool {
        self.served.contains_key(&mark_name(row_file))
    }

    /// The files that served a row.
    pub fn serving_files(&self) -> impl Iterator<Item = &OsString> {
        self.served.values().filter(|name| !name.is_empty() && *name != LATE_MARK && *name != UNUSED_MARK)
    }

    /// Whether a row could not be used for the part that it means.
    pub fn is_unused(&self, row_file: &str) -> bool {
        self.served.get(&mark_name(row_file)).is_some_and(|name| name == UNUSED_MARK)
    }

    /// Whether a row was applied to a part that was taken before the list came. It is for no other part then.
    pub fn is_late(&self, row_file: &str) -> bool {
        self.served.get(&mark_name(row_file)).is_some_and(|name| name == LATE_MARK)
    }

    /// When a row was last served.
    pub fn last_served_ns(&self) -> Option<i128> {
        fs::metadata(&self.dir).ok().map(|meta| disk::mtime_ns(&meta))
    }
}

/// Removes old marks of lists and old notes about parts that were given back.
pub(crate) fn sweep_marks(inbox: &Path) {
    for folder in [".lists", ".given"].map(|name| inbox.join(CLAIMED_DIR).join(name)) {
        if fs::symlink_metadata(&folder).is_ok_and(|meta| !meta.is_dir()) {
            continue;
        }
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if age_secs(&entry.path()).is_some_and(|age| age > STALE_MARKS.as_secs_f64()) {
                let _ = fs::remove_dir_all(entry.path()).or_else(|_| fs::remove_file(entry.path()));
            }
        }
    }
}

/// The inode and ctime distinguish this list from a later one with the same text, whose rows have not been served yet.
fn marks_dir(inbox: &Path, list: &InboxEntry) -> PathBuf {
    inbox.join(CLAIMED_DIR).join(".lists").join(format!("{}-{}", list.inode, list.ctime_ns))
}

fn mark_name(file: &str) -> String {
    blake3::hash(file.as_bytes()).to_hex()[..32].to_owned()
}

/// Seconds since the last change of a file or folder.
pub(crate) fn age_secs(path: &Path) -> Option<f64> {
    let meta = fs::metadata(path).ok()?;
    Some(meta.modified().ok()?.elapsed().unwrap_or_default().as_secs_f64())
}
