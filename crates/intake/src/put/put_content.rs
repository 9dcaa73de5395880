//! Files that programs put before they order copies of them: `state/put/<BLAKE3>`, complete and durable, each once. What is arriving has
//! a name of its own. A file is kept for some time after it was last put or ordered, and as long as a line needs it.

use std::{
    collections::HashSet,
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use crate::{
    StoredFile,
    folder::{disk, store::DAMAGED_DIR},
};

/// How the name of a file begins that has not arrived as a whole.
const ARRIVING_PREFIX: &str = "new-";
/// Room that stays free on the disk for the farm itself.
const RESERVED_BYTES: u64 = 256 << 20;
/// The room is looked at again whenever so many bytes have come: others write to the disk, too.
pub(super) const ROOM_CHECK_BYTES: u64 = 8 << 20;

/// Why bytes cannot be put.
#[derive(Debug, thiserror::Error)]
pub enum PutError {
    /// There are more than the farm takes.
    #[error("it is larger than {max_bytes} bytes (limits.max_bytes)")]
    TooLarge {
        /// The limit.
        max_bytes: u64,
    },
    /// The disk has no room for them.
    #[error("the disk of the farm has no room for {bytes} bytes more")]
    NoRoom {
        /// What was announced.
        bytes: u64,
    },
    /// They are not those that were announced.
    #[error("these bytes have the BLAKE3 {found}, not {expected}")]
    OtherContent {
        /// What their BLAKE3 is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// More bytes of an upload have come than it was to have.
    #[error("{bytes} bytes have come of a file of {said}: it is gone, begin it again")]
    TooLong {
        /// What has come.
        bytes: u64,
        /// What was announced.
        said: u64,
    },
    /// They cannot be written.
    #[error("it cannot be written: {0}")]
    Write(#[from] io::Error),
}

/// The folder of the files that were put.
#[derive(Debug, Clone)]
pub struct PutContents {
    dir: PathBuf,
    reserved_bytes: u64,
}

/// A file that is arriving. It is removed unless it is finished.
#[derive(Debug)]
pub struct ArrivingContent {
    contents: PutContents,
    path: PathBuf,
    file: File,
    hasher: blake3::Hasher,
    bytes: u64,
    max_bytes: u64,
    is_finished: bool,
}

/// Whether a text is a BLAKE3 as nestd writes it.
pub fn is_content_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'))
}

impl PutContents {
    /// Those of a farm with this folder of state.
    pub fn of_farm(state_dir: &Path) -> Self {
        Self { dir: state_dir.join("put"), reserved_bytes: RESERVED_BYTES }
    }

    /// The file with this BLAKE3; `None` = it is not there. It is kept from now on as if it was just put.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn use_content(&self, hash: &str) -> io::Result<Option<StoredFile>> {
        let file = match File::options().write(true).open(self.path_of(hash)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            other => other?,
        };
        file.set_modified(SystemTime::now())?;
        Ok(Some(StoredFile { hash: hash.to_owned(), bytes: file.metadata()?.len() }))
    }

    /// Where the file with this BLAKE3 is, if it is there.
    pub fn path_of(&self, hash: &str) -> PathBuf {
        self.dir.join(hash)
    }

    /// The folder of the notes of orders.
    pub fn orders_folder(&self) -> PathBuf {
        self.dir.join("orders")
    }

    /// Makes the folder of the notes of orders.
    ///
    /// # Errors
    /// The folder of state cannot be written.
    pub fn create_orders_folder(&self) -> io::Result<PathBuf> {
        let folder = self.orders_folder();
        disk::create_dirs(&folder)?;
        Ok(folder)
    }

    /// Begins a file of `announced` bytes, 0 = not said. `token` distinguishes it from every other one that is arriving.
    ///
    /// # Errors
    /// `TooLarge`, `NoRoom` or `Write`.
    pub fn begin_content(&self, token: u128, announced: u64, max_bytes: u64) -> Result<ArrivingContent, PutError> {
        self.create_folder()?;
        self.check_room(announced, max_bytes)?;
        let path = self.dir.join(format!("{ARRIVING_PREFIX}{token:032x}"));
        let file = disk::create_fresh_file(&path)?;
        let (contents, hasher) = (self.clone(), blake3::Hasher::new());
        Ok(ArrivingContent { contents, path, file, hasher, bytes: 0, max_bytes, is_finished: false })
    }

    /// Makes the folder.
    ///
    /// # Errors
    /// The folder of state cannot be written.
    pub fn create_folder(&self) -> io::Result<()> {
        disk::create_dirs(&self.dir)
    }

    /// Checks that the farm takes so many bytes more.
    ///
    /// # Errors
    /// `TooLarge`, `NoRoom` or `Write`.
    pub fn check_room(&self, announced: u64, max_bytes: u64) -> Result<(), PutError> {
        if announced > max_bytes {
            return Err(PutError::TooLarge { max_bytes });
        }
        let disk = rustix::fs::statvfs(&self.dir).map_err(io::Error::from)?;
        match disk.f_bavail.saturating_mul(disk.f_frsize) < announced.saturating_add(self.reserved_bytes) {
            true => Err(PutError::NoRoom { bytes: announced }),
            false => Ok(()),
        }
    }

    /// Gives a complete and durable file its name. `expected` = the BLAKE3 that it must have.
    ///
    /// # Errors
    /// `OtherContent` or `Write`; the file stays where it is.
    pub fn keep_content(&self, path: &Path, hash: &str, expected: Option<&str>) -> Result<(), PutError> {
        if let Some(expected) = expected
            && expected != hash
        {
            return Err(PutError::OtherContent { found: hash.to_owned(), expected: expected.to_owned() });
        }
        // One that was put before may be damaged by now.
        fs::rename(path, self.path_of(hash))?;
        Ok(disk::fsync_dir(&self.dir)?)
    }

    /// Moves a file that does not match its BLAKE3 to the folder of damaged files, so that it can be put again. Nothing is deleted.
    ///
    /// # Errors
    /// It cannot be read or moved.
    pub fn move_damaged_aside(&self, hash: &str) -> io::Result<()> {
        let path = self.path_of(hash);
        // It may have been put again meanwhile.
        if disk::hash_file(&path)? == hash {
            return Ok(());
        }
        let damaged = self.dir.with_file_name(DAMAGED_DIR);
        disk::create_dirs(&damaged)?;
        let aside = disk::move_to_free_name(&path, &damaged, hash.as_ref())?;
        tracing::warn!("{} is damaged: it was moved to {}.", path.display(), aside.display());
        Ok(())
    }

    /// Removes what was arriving when a daemon ended, after `quiet_for` without a byte, and files that were last put or ordered
    /// longer than `keep_for` ago and that no line needs.
    ///
    /// # Errors
    /// When the folder cannot be read or written.
    pub fn sweep_contents(&self, quiet_for: Duration, keep_for: Duration, needed: &HashSet<String>) -> io::Result<()> {
        let entries = match fs::read_dir(&self.dir) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            other => other?,
        };
        for entry in entries {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let keep_for = match name.starts_with(ARRIVING_PREFIX) {
                true => quiet_for,
                false if is_content_hash(&name) && !needed.contains(&name) => keep_for,
                false => continue,
            };
            if entry.metadata()?.modified()?.elapsed().is_ok_and(|age| age >= keep_for) {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }
}

impl ArrivingContent {
    /// Adds what has arrived.
    ///
    /// # Errors
    /// `TooLarge` beyond the limit, `NoRoom` where the disk has become too full, or `Write`.
    pub fn write_chunk(&mut self, chunk: &[u8]) -> Result<(), PutError> {
        let (before, more) = (self.bytes, chunk.len() as u64);
        self.bytes += more;
        if self.bytes > self.max_bytes {
            return Err(PutError::TooLarge { max_bytes: self.max_bytes });
        }
        if before / ROOM_CHECK_BYTES != self.bytes / ROOM_CHECK_BYTES {
            self.contents.check_room(more, u64::MAX)?;
        }
        self.hasher.update(chunk);
        Ok(self.file.write_all(chunk)?)
    }

    /// Where it lies until it is kept or dropped.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Keeps the file under its BLAKE3, durably.
    ///
    /// # Errors
    /// `OtherContent` or `Write`; nothing of it is left then.
    pub fn finish_content(mut self, expected: Option<&str>) -> Result<StoredFile, PutError> {
        self.file.sync_all()?;
        let hash = self.hasher.finalize().to_hex().to_string();
        self.contents.keep_content(&self.path, &hash, expected)?;
        self.is_finished = true;
        Ok(StoredFile { hash, bytes: self.bytes })
    }
}

impl Drop for ArrivingContent {
    fn drop(&mut self) {
        if !self.is_finished {
            _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LATER: Duration = Duration::from_secs(3600);

    #[test]
    fn bytes_are_kept_under_their_hash_and_what_does_not_arrive_as_a_whole_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let contents = PutContents::of_farm(folder.path());
        let begin = |token| contents.begin_content(token, 0, 10).unwrap();
        let hash = blake3::hash(b"solid").to_hex().to_string();
        assert!(is_content_hash(&hash) && !is_content_hash(&hash.to_uppercase()) && !is_content_hash("../x"));
        assert_eq!(contents.use_content(&hash).unwrap(), None);
        let mut file = begin(1);
        file.write_chunk(b"so").unwrap();
        file.write_chunk(b"lid").unwrap();
        assert!(matches!(file.finish_content(Some(&"0".repeat(64))), Err(PutError::OtherContent { .. })));
        for _ in 0..2 {
            let mut file = begin(2);
            file.write_chunk(b"solid").unwrap();
            assert_eq!(file.finish_content(Some(&hash)).unwrap(), StoredFile { hash: hash.clone(), bytes: 5 });
        }
        let mut file = begin(3);
        assert!(matches!(file.write_chunk(b"12345678901"), Err(PutError::TooLarge { max_bytes: 10 })));
        drop(file);
        assert!(matches!(contents.begin_content(4, 11, 10), Err(PutError::TooLarge { .. })));
        assert!(matches!(contents.begin_content(4, 1 << 60, u64::MAX), Err(PutError::NoRoom { .. })));
        assert_eq!(fs::read_dir(folder.path().join("put")).unwrap().count(), 1);
        assert_eq!(contents.use_content(&hash).unwrap().unwrap().bytes, 5);
    }

    #[test]
    fn a_disk_that_becomes_full_meanwhile_ends_a_file_that_did_not_say_its_size() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = PutContents::of_farm(folder.path()).begin_content(1, 0, u64::MAX).unwrap();
        let chunk = vec![7; ROOM_CHECK_BYTES as usize / 2];
        file.write_chunk(&chunk).unwrap();
        file.contents.reserved_bytes = u64::MAX;
        assert!(matches!(file.write_chunk(&chunk), Err(PutError::NoRoom { .. })));
        drop(file);
        assert_eq!(fs::read_dir(folder.path().join("put")).unwrap().count(), 0);
    }

    #[test]
    fn what_nobody_needs_goes_after_its_time() {
        let folder = tempfile::tempdir().unwrap();
        let contents = PutContents::of_farm(folder.path());
        let put = |bytes: &[u8]| {
            let mut file = contents.begin_content(1, 0, 10).unwrap();
            file.write_chunk(bytes).unwrap();
            file.finish_content(None).unwrap().hash
        };
        let (needed, other) = (put(b"a"), put(b"b"));
        std::mem::forget(contents.begin_content(2, 0, 10).unwrap());
        fs::write(folder.path().join("put/note"), "of a person").unwrap();
        let left = || fs::read_dir(folder.path().join("put")).unwrap().count();
        let lines = HashSet::from([needed.clone()]);
        contents.sweep_contents(LATER, LATER, &lines).unwrap();
        assert_eq!(left(), 4);
        contents.sweep_contents(Duration::ZERO, Duration::ZERO, &lines).unwrap();
        assert_eq!(left(), 2);
        assert!(contents.use_content(&needed).unwrap().is_some() && contents.use_content(&other).unwrap().is_none());
    }
}
