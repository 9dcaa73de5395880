//! The content-addressed store: claimed files by the hash of their bytes, on the disk of the state directory.
//!
//! Files are always copied into the store, never linked or renamed, because the program that dropped a file may still
//! have it open for writing.

use std::{
    fs,
    io::{self, Read, Write},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use thiserror::Error;
use tracing::warn;

use super::disk;
use crate::ClaimedPart;

/// Prefix of the name of an unfinished copy.
const TEMPORARY_PREFIX: &str = "tmp-";
/// Folder beside the store for damaged files.
pub(crate) const DAMAGED_DIR: &str = "damaged";
const BUFFER_BYTES: usize = 1 << 20;

/// The store, `state/store/ab/<BLAKE3, 64 hex digits>`.
#[derive(Debug, Clone)]
pub struct ContentStore {
    dir: PathBuf,
}

/// A file in the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// BLAKE3 of its bytes, 64 hex digits.
    pub hash: String,
    /// Its size, bytes.
    pub bytes: u64,
}

/// Why an operation of the store failed.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The file changed during the copy; it must settle again.
    #[error("{} changed while it was copied to the store", .0.display())]
    Changed(PathBuf),
    /// It is not a regular file, or nestd may not read it. Retrying does not help.
    #[error("{} cannot be read", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
    /// The text is not 64 hex digits.
    #[error("{0:?} is no BLAKE3 hash")]
    InvalidHash(String),
    /// The stored bytes do not match their hash: the disk is failing.
    #[error("{} is damaged: its bytes do not match its hash", .0.display())]
    Damaged(PathBuf),
    /// The operating system reported an error.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// The operation that failed.
        what: &'static str,
        /// The path that it was applied to.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

impl StoreError {
    /// Whether the stored file is missing or has other bytes. Only a new copy of the same file helps.
    pub fn is_lost(&self) -> bool {
        match self {
            Self::Damaged(_) => true,
            // The error of `open_regular_file` for a folder or link in place of the file.
            Self::Io { what: "open" | "read", source, .. } => {
                matches!(source.kind(), io::ErrorKind::NotFound | io::ErrorKind::InvalidInput)
            }
            _ => false,
        }
    }

    /// Whether reading the stored file failed with an I/O error. A bad sector is permanent; a loose cable or a network
    /// share may recover.
    pub fn is_unreadable(&self) -> bool {
        let io = rustix::io::Errno::IO.raw_os_error();
        matches!(self, Self::Io { what: "open" | "read", source, .. } if source.raw_os_error() == Some(io))
    }
}

fn io_error<'a>(what: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> StoreError + 'a {
    move |source| StoreError::Io { what, path: path.to_owned(), source }
}

fn open_error(file: &Path, source: io::Error) -> StoreError {
    use io::ErrorKind::{InvalidInput, PermissionDenied};
    let path = file.to_owned();
    match source.kind() {
        PermissionDenied | InvalidInput => StoreError::Unreadable { path, source },
        // The error code for a link when links are not followed.
        _ if source.raw_os_error() == Some(rustix::io::Errno::LOOP.raw_os_error()) => {
            StoreError::Unreadable { path, source }
        }
        _ => StoreError::Io { what: "open", path, source },
    }
}

impl ContentStore {
    /// Opens the store at `dir`, creates it if needed, and removes unfinished copies of a crash. Only one daemon uses a
    /// store.
    pub fn open(dir: impl Into<PathBuf>) -> Result<Self, StoreError> {
        let dir = dir.into();
        disk::create_dirs(&dir).map_err(io_error("create", &dir))?;
        for entry in fs::read_dir(&dir).map_err(io_error("list", &dir))? {
            let path = entry.map_err(io_error("list", &dir))?.path();
            if path.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(TEMPORARY_PREFIX.as_bytes())) {
                fs::remove_file(&path).map_err(io_error("remove", &path))?;
            }
        }
        Ok(Self { dir })
    }

    /// Refers to the store at `dir` without changing it, for read-only users.
    pub fn from_dir(dir: impl Into<PathBuf>) -> Self {
        Self { dir: dir.into() }
    }

    /// Copies a regular file into the store and computes its hash. The copy is durable on return. Storing the same
    /// bytes again changes nothing, unless the stored file was damaged: then the damaged one is moved aside.
    pub fn store_file(&self, file: &Path) -> Result<StoredFile, StoreError> {
        self.store_opened(file, disk::open_regular_file(file), &mut || {})
    }

    /// Copies a claimed part into the store. Links are not followed, because a user who can write into the hot folder
    /// could replace a folder above the part by a link.
    pub fn store_claimed(&self, claim: &ClaimedPart) -> Result<StoredFile, StoreError> {
        let relative = claim.part.strip_prefix(&claim.inbox).unwrap_or(&claim.part);
        self.store_opened(&claim.part, disk::open_beneath(&claim.inbox, relative), &mut || {})
    }

    fn store_opened(
        &self,
        file: &Path,
        opened: io::Result<fs::File>,
        step: &mut dyn FnMut(),
    ) -> Result<StoredFile, StoreError> {
        let mut source = opened.map_err(|source| open_error(file, source))?;
        let before = file_fingerprint(&source).map_err(io_error("stat", file))?;
        let mut copy = self.temporary_file()?;
        step();
        let stored = copy_and_hash(&mut source, copy.as_file_mut()).map_err(io_error("copy to the store", file))?;
        let after = file_fingerprint(&source).map_err(io_error("stat", file))?;
        if after != before || stored.bytes != before.0 {
            return Err(StoreError::Changed(file.to_owned()));
        }
        step();
        self.keep_copy(copy, &stored, step)?;
        Ok(stored)
    }

    /// Copies what a reader gives into the store. The copy is durable on return.
    ///
    /// Reading or writing fails, or other bytes come than those with this hash.
    pub fn store_received(&self, mut source: impl Read, hash: &str) -> Result<(), StoreError> {
        let to = self.file_path(hash)?;
        let mut copy = self.temporary_file()?;
        let stored = copy_and_hash(&mut source, copy.as_file_mut()).map_err(io_error("receive", &to))?;
        if stored.hash != hash {
            return Err(io_error("receive", &to)(io::Error::other("other bytes came than were asked for")));
        }
        self.keep_copy(copy, &stored, &mut || {})
    }

    fn temporary_file(&self) -> Result<tempfile::NamedTempFile, StoreError> {
        let made = tempfile::Builder::new().prefix(TEMPORARY_PREFIX).tempfile_in(&self.dir);
        made.map_err(io_error("create a file in", &self.dir))
    }

    /// Puts a complete copy to its place in the store, durably.
    fn keep_copy(
        &self,
        copy: tempfile::NamedTempFile,
        stored: &StoredFile,
        step: &mut dyn FnMut(),
    ) -> Result<(), StoreError> {
        let to = self.file_path(&stored.hash)?;
        let folder = to.parent().unwrap_or(&self.dir);
        let is_whole = match disk::try_path_exists(&to).map_err(io_error("look at", &to))? {
            false => false,
            true => match self.verify_hash(&stored.hash) {
                Ok(()) => true,
                // The same bytes are being stored now, so moving the damaged or unreadable file aside loses nothing.
                // Where the store as a whole is out of reach, it stays.
                Err(error) if error.is_lost() || error.is_unreadable() => {
                    self.move_damaged_aside(&stored.hash)?;
                    false
                }
                Err(error) => return Err(error),
            },
        };
        if !is_whole {
            copy.as_file().sync_all().map_err(io_error("fsync", copy.path()))?;
            disk::create_dirs(folder).map_err(io_error("create", folder))?;
            step();
            copy.persist(&to).map_err(|e| io_error("store", &to)(e.error))?;
        }
        step();
        disk::fsync_dir(folder).map_err(io_error("fsync", folder))
    }

    /// Path of the file with this hash; if it does not exist, the path that it would have.
    pub fn file_path(&self, hash: &str) -> Result<PathBuf, StoreError> {
        let is_hash = hash.len() == 64 && hash.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        match is_hash {
            true => Ok(self.dir.join(&hash[..2]).join(hash)),
            false => Err(StoreError::InvalidHash(hash.to_owned())),
        }
    }

    /// Reads the stored file and compares its hash.
    pub fn verify_hash(&self, hash: &str) -> Result<(), StoreError> {
        let path = self.file_path(hash)?;
        let mut file = disk::open_regular_file(&path).map_err(io_error("open", &path))?;
        let stored = copy_and_hash(&mut file, &mut io::sink()).map_err(io_error("read", &path))?;
        if stored.hash == hash { Ok(()) } else { Err(StoreError::Damaged(path)) }
    }

    /// Folder of the store.
    pub(crate) fn dir(&self) -> &Path {
        &self.dir
    }

    /// Moves a stored file that does not match its hash, or cannot be read, to the folder `damaged` beside the store. Nothing is deleted.
    /// Returns the new path; `None` = there was no file.
    pub fn move_damaged_aside(&self, hash: &str) -> Result<Option<PathBuf>, StoreError> {
        let path = self.file_path(hash)?;
        if !disk::try_path_exists(&path).map_err(io_error("look at", &path))? {
            return Ok(None);
        }
        let damaged = self.dir.with_file_name(DAMAGED_DIR);
        disk::create_dirs(&damaged).map_err(io_error("create", &damaged))?;
        let aside = disk::move_to_free_name(&path, &damaged, hash.as_ref()).map_err(io_error("set aside", &path))?;
        warn!(
            "{} is damaged: its bytes do not match its hash, or cannot be read. It was moved to {}.",
            path.display(),
            aside.display()
        );
        Ok(Some(aside))
    }

    /// Removes the notes beside a stored file and then the file. A missing file is not an error.
    pub fn remove_content(&self, hash: &str) -> Result<(), StoreError> {
        let path = self.file_path(hash)?;
        self.remove_notes(&path).map_err(io_error("remove the notes of", &path))?;
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error("remove", &path)(error)),
            _ => Ok(()),
        }
    }
}

/// Size, ctime and mtime of an open file. Every write changes at least one of them.
fn file_fingerprint(file: &fs::File) -> io::Result<(u64, i128, i128)> {
    let meta = file.metadata()?;
    Ok((meta.size(), disk::ctime_ns(&meta), disk::mtime_ns(&meta)))
}

fn copy_and_hash(from: &mut impl Read, to: &mut impl Write) -> io::Result<StoredFile> {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; BUFFER_BYTES];
    let mut bytes = 0;
    loop {
        let count = match from.read(&mut buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            other => other?,
        };
        if count == 0 {
            return Ok(StoredFile { hash: hasher.finalize().to_hex().to_string(), bytes });
        }
        hasher.update(&buffer[..count]);
        to.write_all(&buffer[..count])?;
        bytes += count as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    fn farm() -> (tempfile::TempDir, PathBuf, ContentStore) {
        let dir = tempfile::tempdir().unwrap();
        let part = dir.path().join("part.stl");
        fs::write(&part, vec![7; 3_000_000]).unwrap();
        let store = ContentStore::open(dir.path().join("state/store")).unwrap();
        (dir, part, store)
    }

    #[test]
    fn what_is_put_is_found_by_its_hash_and_twice_is_once() {
        let (dir, part, store) = farm();
        let stored = store.store_file(&part).unwrap();
        assert_eq!(stored.hash, blake3::hash(&fs::read(&part).unwrap()).to_hex().to_string());
        assert_eq!(stored.bytes, 3_000_000);
        let path = store.file_path(&stored.hash).unwrap();
        assert_eq!(path, dir.path().join("state/store").join(&stored.hash[..2]).join(&stored.hash));
        let inode = fs::metadata(&path).unwrap().ino();
        assert_ne!(inode, fs::metadata(&part).unwrap().ino());
        assert_eq!(store.store_file(&part).unwrap(), stored);
        assert_eq!(fs::metadata(&path).unwrap().ino(), inode);
        store.verify_hash(&stored.hash).unwrap();
        store.remove_content(&stored.hash).unwrap();
        store.remove_content(&stored.hash).unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn a_damaged_file_is_noticed_and_a_short_one_replaced() {
        let (_dir, part, store) = farm();
        let stored = store.store_file(&part).unwrap();
        let path = store.file_path(&stored.hash).unwrap();
        fs::write(&path, vec![8; 3_000_000]).unwrap();
        assert!(matches!(store.verify_hash(&stored.hash), Err(StoreError::Damaged(_))));
        fs::write(&path, "short").unwrap();
        store.store_file(&part).unwrap();
        store.verify_hash(&stored.hash).unwrap();
    }

    #[test]
    fn a_good_copy_heals_a_damaged_file_which_is_set_aside() {
        let (dir, part, store) = farm();
        let stored = store.store_file(&part).unwrap();
        let path = store.file_path(&stored.hash).unwrap();
        for (number, spoilt) in [vec![8; 3_000_000], vec![7; 2_999_999], Vec::new()].into_iter().enumerate() {
            fs::write(&path, &spoilt).unwrap();
            assert!(store.verify_hash(&stored.hash).unwrap_err().is_lost());
            assert_eq!(store.store_file(&part).unwrap(), stored);
            store.verify_hash(&stored.hash).unwrap();
            let aside = disk::files_below(&dir.path().join("state/damaged")).unwrap();
            assert_eq!(aside.len(), number + 1);
            assert!(aside.iter().any(|file| fs::read(file).unwrap() == spoilt), "what was damaged is kept");
        }
        store.remove_content(&stored.hash).unwrap();
        assert!(store.verify_hash(&stored.hash).unwrap_err().is_lost());
        assert_eq!(store.move_damaged_aside(&stored.hash).unwrap(), None);
    }

    #[test]
    fn a_file_that_is_written_while_it_is_copied_is_not_stored() {
        let (dir, part, store) = farm();
        let mut steps = 0;
        let result = store.store_opened(&part, disk::open_regular_file(&part), &mut || {
            steps += 1;
            if steps == 1 {
                fs::OpenOptions::new().append(true).open(&part).unwrap().write_all(b"more").unwrap();
            }
        });
        assert!(matches!(result, Err(StoreError::Changed(_))), "{result:?}");
        assert_eq!(fs::read_dir(dir.path().join("state/store")).unwrap().count(), 0);
    }

    #[test]
    fn a_copy_that_stopped_anywhere_is_swept_and_done_again() {
        for stop in 1..=4 {
            let (dir, part, store) = farm();
            let mut steps = 0;
            let stopped = catch_unwind(AssertUnwindSafe(|| {
                store.store_opened(&part, disk::open_regular_file(&part), &mut || {
                    steps += 1;
                    assert!(steps < stop, "stop here");
                })
            }));
            assert!(stopped.is_err(), "step {stop} is not reached");
            fs::write(dir.path().join("state/store/tmp-killed"), "half").unwrap();
            let store = ContentStore::open(dir.path().join("state/store")).unwrap();
            let stored = store.store_file(&part).unwrap();
            store.verify_hash(&stored.hash).unwrap();
            assert_eq!(disk::files_below(&dir.path().join("state/store")).unwrap().len(), 1);
        }
    }

    #[test]
    fn what_is_no_file_or_no_hash_is_an_error() {
        let (dir, part, store) = farm();
        let link = dir.path().join("link.stl");
        std::os::unix::fs::symlink(&part, &link).unwrap();
        assert!(matches!(store.store_file(&link), Err(StoreError::Unreadable { .. })));
        assert!(matches!(store.store_file(dir.path()), Err(StoreError::Unreadable { .. })));
        assert!(matches!(store.store_file(&dir.path().join("gone")), Err(StoreError::Io { .. })));
        for text in ["", "../../etc/passwd", &"A".repeat(64), &"a".repeat(63)] {
            assert!(matches!(store.file_path(text), Err(StoreError::InvalidHash(_))), "{text}");
        }
    }
}
