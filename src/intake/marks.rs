//! Which rows of an order list were served: marks on the disk, so that a restart does not forget.

use std::{
    collections::HashMap,
    ffi::{OsStr, OsString},
    fs,
    io::{self, Write},
    os::unix::ffi::{OsStrExt, OsStringExt},
    path::{Path, PathBuf},
    time::Duration,
};

use super::{Seen, claim_folder::CLAIMED_DIR, disk, name::MAX_NAME_BYTES};

/// Marks of lists that somebody deleted go after so long.
const STALE_MARKS: Duration = Duration::from_secs(7 * 24 * 3600);

/// Notes on disk that a row of a list was served, and by which file. Before the claim is whole: a part that is still there
/// counts anyway.
pub(super) fn mark_served(inbox: &Path, list: &Seen, row_file: &str, name: &OsStr) -> io::Result<()> {
    let marks = marks_dir(inbox, list);
    let below = marks.strip_prefix(inbox).unwrap_or(&marks);
    disk::create_dirs_beneath(inbox, below)?;
    let mut file = disk::create_anew(&marks.join(mark(row_file)))?;
    file.write_all(name.as_bytes())?;
    file.sync_all()?;
    disk::fsync_dir(&marks)
}

/// Which rows of a list were served, as the marks say.
#[derive(Debug)]
pub(super) struct Marks {
    pub dir: PathBuf,
    /// The file that served a row, by the row's mark.
    served: HashMap<String, OsString>,
}

impl Marks {
    /// Those on the disk; none that can be read are none.
    pub fn load(inbox: &Path, list: &Seen) -> Self {
        let dir = marks_dir(inbox, list);
        let entries = fs::read_dir(&dir).into_iter().flatten().flatten();
        let mark = |entry: fs::DirEntry| {
            let bytes = disk::read_start(&entry.path(), MAX_NAME_BYTES as u64).ok()??;
            Some((entry.file_name().into_string().ok()?, OsString::from_vec(bytes)))
        };
        let served = entries.filter_map(mark).collect();
        Self { dir, served }
    }

    /// Whether those on the disk are as many.
    pub fn are_all(&self) -> bool {
        fs::read_dir(&self.dir).map_or(0, Iterator::count) == self.served.len()
    }

    /// One more, that is on the disk already.
    pub fn add(&mut self, row_file: &str, name: &OsStr) {
        self.served.insert(mark(row_file), name.to_owned());
    }

    /// Whether a row was served.
    pub fn is_served(&self, row_file: &str) -> bool {
        self.served.contains_key(&mark(row_file))
    }

    /// The files that served a row.
    pub fn files(&self) -> impl Iterator<Item = &OsString> {
        self.served.values().filter(|name| !name.is_empty())
    }

    /// When a row was last served.
    pub fn last_ns(&self) -> Option<i128> {
        fs::metadata(&self.dir).ok().map(|meta| disk::mtime_ns(&meta))
    }
}

/// Removes marks of lists, and notes of parts that were given back, that are long gone.
pub(super) fn sweep_marks(inbox: &Path) {
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

/// Inode and ctime tell this list from a later one of the same text, whose rows nobody served yet.
fn marks_dir(inbox: &Path, list: &Seen) -> PathBuf {
    inbox.join(CLAIMED_DIR).join(".lists").join(format!("{}-{}", list.inode, list.ctime_ns))
}

fn mark(file: &str) -> String {
    blake3::hash(file.as_bytes()).to_hex()[..32].to_owned()
}

/// How long ago it last changed, seconds.
pub(super) fn age_secs(path: &Path) -> Option<f64> {
    let meta = fs::metadata(path).ok()?;
    Some(meta.modified().ok()?.elapsed().unwrap_or_default().as_secs_f64())
}
