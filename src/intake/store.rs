//! The content-addressed store: what was claimed, by the hash of its bytes, on the state directory's own disk.
//!
//! Always a copy, never a link or a rename: whoever dropped the file may still have it open for writing.

use std::{
    fs,
    io::{self, Read, Write},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use thiserror::Error;
use tracing::warn;

use super::{Claim, disk};

/// What is being copied has this prefix.
const TEMPORARY: &str = "tmp-";
/// Beside the store: what was found damaged in it.
const DAMAGED: &str = "damaged";
const BUFFER_BYTES: usize = 1 << 20;

/// The store, `state/store/ab/<BLAKE3, 64 hex digits>`.
#[derive(Debug, Clone)]
pub struct Store {
    dir: PathBuf,
}

/// A file in the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stored {
    /// BLAKE3 of its bytes, 64 hex digits.
    pub hash: String,
    /// Its size, bytes.
    pub bytes: u64,
}

/// Why the store did not do it.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The file changed while it was copied; it must settle again.
    #[error("{} changed while it was copied to the store", .0.display())]
    Changed(PathBuf),
    /// It is no file, or nestd may not read it: trying again will not help.
    #[error("{} cannot be read", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
    /// Not 64 hex digits.
    #[error("{0:?} is no BLAKE3 hash")]
    NoHash(String),
    /// The stored bytes are not those of their hash: the disk is failing.
    #[error("{} does not hold what its name says", .0.display())]
    Damaged(PathBuf),
    /// The system said no.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

impl StoreError {
    /// Whether the stored file is gone or holds other bytes: only the same file from elsewhere helps.
    pub fn is_lost(&self) -> bool {
        match self {
            Self::Damaged(_) => true,
            // What `open_regular` says of a folder or link in its place.
            Self::Io { what: "open" | "read", source, .. } => {
                matches!(source.kind(), io::ErrorKind::NotFound | io::ErrorKind::InvalidInput)
            }
            _ => false,
        }
    }

    /// Whether the disk cannot read the stored file: a bad sector says so for ever, a cable or a share in passing.
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
        // How a link is told when none is followed.
        _ if source.raw_os_error() == Some(rustix::io::Errno::LOOP.raw_os_error()) => {
            StoreError::Unreadable { path, source }
        }
        _ => StoreError::Io { what: "open", path, source },
    }
}

impl Store {
    /// Opens the store at `dir` and creates it if needed; removes what a crash left half copied. A store has one daemon.
    pub fn open(dir: impl Into<PathBuf>) -> Result<Self, StoreError> {
        let dir = dir.into();
        disk::create_dirs(&dir).map_err(io_error("create", &dir))?;
        for entry in fs::read_dir(&dir).map_err(io_error("list", &dir))? {
            let path = entry.map_err(io_error("list", &dir))?.path();
            if path.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(TEMPORARY.as_bytes())) {
                fs::remove_file(&path).map_err(io_error("remove", &path))?;
            }
        }
        Ok(Self { dir })
    }

    /// Names the store at `dir` without touching it, for whoever only looks.
    pub fn at(dir: impl Into<PathBuf>) -> Self {
        Self { dir: dir.into() }
    }

    /// Copies a regular file in, hashing; on disk when it returns. Putting the same bytes again changes nothing, unless what is
    /// stored was damaged: that is set aside.
    pub fn put(&self, file: &Path) -> Result<Stored, StoreError> {
        self.put_opened(file, disk::open_regular(file), &mut || {})
    }

    /// Copies a claimed part in. Who can write into the hot folder can make a link of what is above it there: none is
    /// followed.
    pub fn put_claimed(&self, claim: &Claim) -> Result<Stored, StoreError> {
        let relative = claim.part.strip_prefix(&claim.inbox).unwrap_or(&claim.part);
        self.put_opened(&claim.part, disk::open_beneath(&claim.inbox, relative), &mut || {})
    }

    fn put_opened(
        &self,
        file: &Path,
        opened: io::Result<fs::File>,
        step: &mut dyn FnMut(),
    ) -> Result<Stored, StoreError> {
        let mut source = opened.map_err(|source| open_error(file, source))?;
        let before = print(&source).map_err(io_error("stat", file))?;
        let mut copy = tempfile::Builder::new()
            .prefix(TEMPORARY)
            .tempfile_in(&self.dir)
            .map_err(io_error("create a file in", &self.dir))?;
        step();
        let stored = copy_hashing(&mut source, copy.as_file_mut()).map_err(io_error("copy to the store", file))?;
        let after = print(&source).map_err(io_error("stat", file))?;
        if after != before || stored.bytes != before.0 {
            return Err(StoreError::Changed(file.to_owned()));
        }
        step();
        let to = self.path(&stored.hash)?;
        let folder = to.parent().unwrap_or(&self.dir);
        let is_whole = match disk::try_is_there(&to).map_err(io_error("look at", &to))? {
            false => false,
            true => match self.verify(&stored.hash) {
                Ok(()) => true,
                // Its bytes are at hand, so that nothing is lost by it; what only cannot be looked at now stays.
                Err(error) if error.is_lost() || error.is_unreadable() => {
                    self.set_damaged_aside(&stored.hash)?;
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
        disk::fsync_dir(folder).map_err(io_error("fsync", folder))?;
        Ok(stored)
    }

    /// Where the bytes of a hash are, or would be.
    pub fn path(&self, hash: &str) -> Result<PathBuf, StoreError> {
        let is_hash = hash.len() == 64 && hash.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        match is_hash {
            true => Ok(self.dir.join(&hash[..2]).join(hash)),
            false => Err(StoreError::NoHash(hash.to_owned())),
        }
    }

    /// Reads the bytes of a hash and compares.
    pub fn verify(&self, hash: &str) -> Result<(), StoreError> {
        let path = self.path(hash)?;
        let mut file = disk::open_regular(&path).map_err(io_error("open", &path))?;
        let stored = copy_hashing(&mut file, &mut io::sink()).map_err(io_error("read", &path))?;
        if stored.hash == hash { Ok(()) } else { Err(StoreError::Damaged(path)) }
    }

    /// Its folder.
    pub(super) fn dir(&self) -> &Path {
        &self.dir
    }

    /// Moves what is stored under a hash, and does not hold its bytes, to the folder `damaged` beside the store: nothing is
    /// deleted. Returns where it is; `None` = nothing was there.
    pub fn set_damaged_aside(&self, hash: &str) -> Result<Option<PathBuf>, StoreError> {
        let path = self.path(hash)?;
        if !disk::try_is_there(&path).map_err(io_error("look at", &path))? {
            return Ok(None);
        }
        let damaged = self.dir.with_file_name(DAMAGED);
        disk::create_dirs(&damaged).map_err(io_error("create", &damaged))?;
        let aside = disk::move_to_free_name(&path, &damaged, hash.as_ref()).map_err(io_error("set aside", &path))?;
        warn!("{} does not hold what was stored; it is kept as {}.", path.display(), aside.display());
        Ok(Some(aside))
    }

    /// Removes the bytes of a hash, and before them the notes beside them; that they are not there is no error.
    pub fn remove(&self, hash: &str) -> Result<(), StoreError> {
        let path = self.path(hash)?;
        self.remove_notes(&path).map_err(io_error("remove the notes of", &path))?;
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error("remove", &path)(error)),
            _ => Ok(()),
        }
    }
}

/// Size, ctime and mtime of an open file: whoever writes into it changes them.
fn print(file: &fs::File) -> io::Result<(u64, i128, i128)> {
    let meta = file.metadata()?;
    Ok((meta.size(), disk::ctime_ns(&meta), disk::mtime_ns(&meta)))
}

fn copy_hashing(from: &mut impl Read, to: &mut impl Write) -> io::Result<Stored> {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; BUFFER_BYTES];
    let mut bytes = 0;
    loop {
        let count = match from.read(&mut buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            other => other?,
        };
        if count == 0 {
            return Ok(Stored { hash: hasher.finalize().to_hex().to_string(), bytes });
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

    fn farm() -> (tempfile::TempDir, PathBuf, Store) {
        let dir = tempfile::tempdir().unwrap();
        let part = dir.path().join("part.stl");
        fs::write(&part, vec![7; 3_000_000]).unwrap();
        let store = Store::open(dir.path().join("state/store")).unwrap();
        (dir, part, store)
    }

    #[test]
    fn what_is_put_is_found_by_its_hash_and_twice_is_once() {
        let (dir, part, store) = farm();
        let stored = store.put(&part).unwrap();
        assert_eq!(stored.hash, blake3::hash(&fs::read(&part).unwrap()).to_hex().to_string());
        assert_eq!(stored.bytes, 3_000_000);
        let path = store.path(&stored.hash).unwrap();
        assert_eq!(path, dir.path().join("state/store").join(&stored.hash[..2]).join(&stored.hash));
        let inode = fs::metadata(&path).unwrap().ino();
        assert_ne!(inode, fs::metadata(&part).unwrap().ino());
        assert_eq!(store.put(&part).unwrap(), stored);
        assert_eq!(fs::metadata(&path).unwrap().ino(), inode);
        store.verify(&stored.hash).unwrap();
        store.remove(&stored.hash).unwrap();
        store.remove(&stored.hash).unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn a_damaged_file_is_noticed_and_a_short_one_replaced() {
        let (_dir, part, store) = farm();
        let stored = store.put(&part).unwrap();
        let path = store.path(&stored.hash).unwrap();
        fs::write(&path, vec![8; 3_000_000]).unwrap();
        assert!(matches!(store.verify(&stored.hash), Err(StoreError::Damaged(_))));
        fs::write(&path, "short").unwrap();
        store.put(&part).unwrap();
        store.verify(&stored.hash).unwrap();
    }

    #[test]
    fn a_good_copy_heals_a_damaged_file_which_is_set_aside() {
        let (dir, part, store) = farm();
        let stored = store.put(&part).unwrap();
        let path = store.path(&stored.hash).unwrap();
        for (number, spoilt) in [vec![8; 3_000_000], vec![7; 2_999_999], Vec::new()].into_iter().enumerate() {
            fs::write(&path, &spoilt).unwrap();
            assert!(store.verify(&stored.hash).unwrap_err().is_lost());
            assert_eq!(store.put(&part).unwrap(), stored);
            store.verify(&stored.hash).unwrap();
            let aside = disk::files_below(&dir.path().join("state/damaged")).unwrap();
            assert_eq!(aside.len(), number + 1);
            assert!(aside.iter().any(|file| fs::read(file).unwrap() == spoilt), "what was damaged is kept");
        }
        store.remove(&stored.hash).unwrap();
        assert!(store.verify(&stored.hash).unwrap_err().is_lost());
        assert_eq!(store.set_damaged_aside(&stored.hash).unwrap(), None);
    }

    #[test]
    fn a_file_that_is_written_while_it_is_copied_is_not_stored() {
        let (dir, part, store) = farm();
        let mut steps = 0;
        let result = store.put_opened(&part, disk::open_regular(&part), &mut || {
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
                store.put_opened(&part, disk::open_regular(&part), &mut || {
                    steps += 1;
                    assert!(steps < stop, "stop here");
                })
            }));
            assert!(stopped.is_err(), "step {stop} is not reached");
            fs::write(dir.path().join("state/store/tmp-killed"), "half").unwrap();
            let store = Store::open(dir.path().join("state/store")).unwrap();
            let stored = store.put(&part).unwrap();
            store.verify(&stored.hash).unwrap();
            assert_eq!(disk::files_below(&dir.path().join("state/store")).unwrap().len(), 1);
        }
    }

    #[test]
    fn what_is_no_file_or_no_hash_is_an_error() {
        let (dir, part, store) = farm();
        let link = dir.path().join("link.stl");
        std::os::unix::fs::symlink(&part, &link).unwrap();
        assert!(matches!(store.put(&link), Err(StoreError::Unreadable { .. })));
        assert!(matches!(store.put(dir.path()), Err(StoreError::Unreadable { .. })));
        assert!(matches!(store.put(&dir.path().join("gone")), Err(StoreError::Io { .. })));
        for text in ["", "../../etc/passwd", &"A".repeat(64), &"a".repeat(63)] {
            assert!(matches!(store.path(text), Err(StoreError::NoHash(_))), "{text}");
        }
    }
}
