//! What the visible files in the queue folders hold: whether one is the proved file of its build, and whether one was copied or renamed
//! from a build file, whatever its name is. Each file is read once in this process, and again only when its stamp has changed.

use std::{
    collections::{BTreeMap, HashSet},
    ffi::OsStr,
    fs::{self, File},
    io::{self, Read},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use build_file::{HeadingMetadata, ReadLimits};

use crate::queue::QueueFolder;

/// How a ZIP package begins, as a 3MF file is one.
const PACKAGE: &[u8] = b"PK";

/// What changes when a file is written, replaced or put back: size, times in ns, inode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FileStamp {
    bytes: u64,
    modified: (i64, i64),
    changed: (i64, i64),
    inode: u64,
}

impl FileStamp {
    fn of(seen: &fs::Metadata) -> Self {
        Self {
            bytes: seen.len(),
            modified: (seen.mtime(), seen.mtime_nsec()),
            changed: (seen.ctime(), seen.ctime_nsec()),
            inode: seen.ino(),
        }
    }
}

/// What was read of a file.
#[derive(Debug, Clone)]
struct FileContent {
    stamp: FileStamp,
    /// BLAKE3 of all of it.
    hash: Option<String>,
    /// The name that the build file had whose heading it has; inside, `None` = it is none of a farm.
    own_name: Option<Option<String>>,
}

impl FileContent {
    /// What was read of the file with this stamp.
    fn known(path: &Path, seen: &fs::Metadata) -> Self {
        let stamp = FileStamp::of(seen);
        let known = known_contents().get(path).filter(|known| known.stamp == stamp).cloned();
        known.unwrap_or(Self { stamp, hash: None, own_name: None })
    }
}

/// What was read of the files in queue folders, by their paths.
static CONTENTS: Mutex<BTreeMap<PathBuf, FileContent>> = Mutex::new(BTreeMap::new());

/// Reads visible files, of which one look reads a limited number: after a start, the others are for the next looks.
#[derive(Debug)]
pub(crate) struct ContentReader {
    /// Number of files that are still to be read.
    left: usize,
}

impl ContentReader {
    /// A reader that reads so many files.
    pub(crate) fn new(most: usize) -> Self {
        Self { left: most }
    }

    /// BLAKE3 of a file; `None` = it cannot be read, or is for the next look.
    pub(crate) fn hash(&mut self, path: &Path, seen: &fs::Metadata) -> Option<String> {
        let mut known = FileContent::known(path, seen);
        if known.hash.is_none() {
            self.left = self.left.checked_sub(1)?;
            known.hash = Some(intake::hash_file(path).ok()?);
            known_contents().insert(path.to_owned(), known.clone());
        }
        known.hash
    }

    /// The name that a file had when it was published as a build, as its heading says; `None` = it is no such file, cannot be read, or is
    /// for the next look.
    pub(crate) fn own_name(&mut self, path: &Path, seen: &fs::Metadata) -> Option<String> {
        if !seen.is_file() {
            return None;
        }
        let mut known = FileContent::known(path, seen);
        if known.own_name.is_none() {
            let name = if starts_as_package(path).ok()? {
                self.left = self.left.checked_sub(1)?;
                read_own_name(path)
            } else {
                None
            };
            known.own_name = Some(name);
            known_contents().insert(path.to_owned(), known.clone());
        }
        known.own_name.flatten()
    }
}

fn known_contents() -> MutexGuard<'static, BTreeMap<PathBuf, FileContent>> {
    CONTENTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The file is read again at the next look.
pub(crate) fn forget(file: &Path) {
    known_contents().remove(file);
}

/// Nothing more is known of files of a queue folder that are not there any more.
pub(crate) fn forget_others(queue: &QueueFolder, names: &[String]) {
    let names: HashSet<&OsStr> = names.iter().map(OsStr::new).collect();
    known_contents().retain(|file, _| {
        file.parent() != Some(queue.folder_path()) || file.file_name().is_some_and(|name| names.contains(name))
    });
}

/// The name, other than its own, under which a build file lies visible in a queue folder.
pub(crate) fn find_copy(queue: &QueueFolder, name: &str) -> Option<String> {
    let mut reader = ContentReader::new(usize::MAX);
    let names = queue.visible_names().ok()?;
    names.into_iter().filter(|other| other != name).find(|other| {
        let path = queue.published_path(other);
        let seen = fs::symlink_metadata(&path);
        seen.is_ok_and(|seen| reader.own_name(&path, &seen).as_deref() == Some(name))
    })
}

fn starts_as_package(file: &Path) -> io::Result<bool> {
    let mut start = Vec::new();
    File::open(file)?.take(PACKAGE.len() as u64).read_to_end(&mut start)?;
    Ok(start == PACKAGE)
}

fn read_own_name(file: &Path) -> Option<String> {
    let HeadingMetadata { created, profile, build_id, .. } =
        build_file::read_build_heading(file, &ReadLimits::default()).ok()?;
    Some(build_file::build_file_name(created?.parse().ok()?, &profile?, build_id?.parse().ok()?))
}
