//! Work on meshes, kept on disk by content, so that it is paid once per mesh and not once per start. Whatever is torn,
//! altered or of another version is dropped and made again; nothing in here can make a build wrong.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::SystemTime,
};

use nester::Cache;
use tracing::{debug, warn};

use crate::settings::Settings;

/// The first bytes of an entry; another number for another form.
const MAGIC: &[u8; 16] = b"nestd-prepared-1";
/// Magic and BLAKE3 of the key and the bytes.
const HEADER_BYTES: usize = 16 + 32;
/// What the names of entries end in.
const ENDING: &str = ".prepared";
/// What is being written has this prefix.
const TEMPORARY: &str = "tmp-";
/// When entries are dropped, so much of the room stays filled.
const KEEP_SHARE: f64 = 0.9;

/// A folder of entries, `<key>.prepared`, no larger than a cap; what was used longest ago goes first.
#[derive(Debug)]
pub struct DiskCache {
    dir: PathBuf,
    cap_bytes: u64,
    used_bytes: AtomicU64,
    sweeping: Mutex<()>,
}

/// An entry as it lies in the folder.
struct Entry {
    used_at: SystemTime,
    path: PathBuf,
    bytes: u64,
}

impl DiskCache {
    /// Opens a cache at `dir`, makes the folder where it is missing, and removes what a crash left half written.
    pub fn open(dir: impl Into<PathBuf>, cap_bytes: u64) -> io::Result<Self> {
        let dir = dir.into();
        fs::create_dir_all(&dir)?;
        for file in fs::read_dir(&dir)? {
            let file = file?;
            if file.file_name().as_encoded_bytes().starts_with(TEMPORARY.as_bytes()) {
                fs::remove_file(file.path())?;
            }
        }
        let cache = Self { dir, cap_bytes, used_bytes: AtomicU64::new(0), sweeping: Mutex::new(()) };
        let used = cache.entries()?.iter().map(|entry| entry.bytes).sum();
        cache.used_bytes.store(used, Ordering::Relaxed);
        cache.sweep()?;
        Ok(cache)
    }

    /// The cache of a farm, in its state directory; without one the farm works as well, only later.
    pub fn of_farm(settings: &Settings) -> Option<Self> {
        if settings.cache_bytes == 0 {
            return None;
        }
        let opened = Self::open(settings.state_dir.join("cache"), settings.cache_bytes);
        opened.inspect_err(|error| warn!("Prepared meshes are not kept: {error}.")).ok()
    }

    /// Whether it is the cache that these settings ask for.
    pub fn is_of(&self, settings: &Settings) -> bool {
        (self.dir.as_path(), self.cap_bytes) == (settings.state_dir.join("cache").as_path(), settings.cache_bytes)
    }

    /// Bytes that all entries take up.
    pub fn used_bytes(&self) -> u64 {
        self.used_bytes.load(Ordering::Relaxed)
    }

    fn path(&self, key: &str) -> PathBuf {
        self.dir.join(format!("{key}{ENDING}"))
    }

    fn entries(&self) -> io::Result<Vec<Entry>> {
        let mut entries = Vec::new();
        for file in fs::read_dir(&self.dir)? {
            let path = file?.path();
            // Another process may have dropped it meanwhile.
            let Ok(data) = fs::metadata(&path) else { continue };
            if data.is_file() && path.to_string_lossy().ends_with(ENDING) {
                entries.push(Entry { used_at: data.modified()?, path, bytes: data.len() });
            }
        }
        Ok(entries)
    }

    /// Drops what was used longest ago until the rest fits.
    fn sweep(&self) -> io::Result<()> {
        if self.used_bytes() <= self.cap_bytes {
            return Ok(());
        }
        let _one_at_a_time = self.sweeping.lock().unwrap_or_else(PoisonError::into_inner);
        let mut entries = self.entries()?;
        entries.sort_by(|a, b| (a.used_at, &a.path).cmp(&(b.used_at, &b.path)));
        let mut used: u64 = entries.iter().map(|entry| entry.bytes).sum();
        let wanted = (self.cap_bytes as f64 * KEEP_SHARE) as u64;
        for entry in entries {
            if used <= wanted {
                break;
            }
            match fs::remove_file(&entry.path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => used -= entry.bytes,
            }
        }
        self.used_bytes.store(used, Ordering::Relaxed);
        Ok(())
    }

    fn write(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.path(key);
        let mut file = tempfile::Builder::new().prefix(TEMPORARY).tempfile_in(&self.dir)?;
        file.write_all(MAGIC)?;
        file.write_all(checksum(key, bytes).as_bytes())?;
        file.write_all(bytes)?;
        // Not flushed to the disk: what a crash tears fails its checksum and is made again.
        let replaced = fs::metadata(&path).map_or(0, |data| data.len());
        file.persist(&path).map_err(|error| error.error)?;
        let size = (HEADER_BYTES + bytes.len()) as u64;
        self.used_bytes.fetch_add(size.saturating_sub(replaced), Ordering::Relaxed);
        self.sweep()
    }
}

impl Cache for DiskCache {
    fn fetch(&self, key: &str) -> Option<Vec<u8>> {
        let path = self.path(key);
        let mut whole = fs::read(&path).ok()?;
        if !is_whole(key, &whole) {
            debug!("Dropped the damaged entry {}.", path.display());
            let _ = fs::remove_file(&path);
            self.used_bytes.fetch_sub((whole.len() as u64).min(self.used_bytes()), Ordering::Relaxed);
            return None;
        }
        note_use(&path);
        whole.drain(..HEADER_BYTES);
        Some(whole)
    }

    fn keep(&self, key: &str, bytes: &[u8]) {
        // What fills the whole room would push out everything else and then itself.
        if 4 * (HEADER_BYTES + bytes.len()) as u64 > self.cap_bytes {
            return;
        }
        if let Err(error) = self.write(key, bytes) {
            debug!("Could not keep {}: {error}.", self.path(key).display());
        }
    }
}

fn checksum(key: &str, bytes: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(key.as_bytes()).update(&[0]).update(bytes);
    hasher.finalize()
}

fn is_whole(key: &str, file: &[u8]) -> bool {
    let Some((header, bytes)) = file.split_at_checked(HEADER_BYTES) else { return false };
    header[..16] == *MAGIC && header[16..] == *checksum(key, bytes).as_bytes()
}

/// The time of the last use is the file's time of change; where it cannot be set, the entry only goes sooner.
fn note_use(path: &Path) {
    if let Ok(file) = fs::File::options().append(true).open(path) {
        let _ = file.set_modified(SystemTime::now());
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn cache(cap_bytes: u64) -> (tempfile::TempDir, DiskCache) {
        let dir = tempfile::tempdir().expect("a folder");
        let cache = DiskCache::open(dir.path().join("cache"), cap_bytes).expect("opens");
        (dir, cache)
    }

    #[test]
    fn what_is_kept_comes_back_also_after_a_restart() {
        let (dir, cache) = cache(1 << 20);
        cache.keep("guides-1-ab", b"many numbers");
        assert_eq!(cache.fetch("guides-1-ab").as_deref(), Some(&b"many numbers"[..]));
        assert_eq!(cache.fetch("guides-1-cd"), None);
        let again = DiskCache::open(dir.path().join("cache"), 1 << 20).expect("opens");
        assert_eq!(again.used_bytes(), cache.used_bytes());
        assert!(again.fetch("guides-1-ab").is_some());
    }

    #[test]
    fn an_entry_that_is_torn_altered_or_of_another_key_is_dropped() {
        let (_dir, cache) = cache(1 << 20);
        let spoil: [fn(&mut Vec<u8>); 5] = [
            |file| file.truncate(file.len() - 1),
            |file| file.truncate(20),
            |file| file.clear(),
            |file| *file.last_mut().expect("has bytes") ^= 1,
            |file| file[3] ^= 1,
        ];
        for spoil in spoil {
            cache.keep("outline-1-ab", b"0123456789");
            let path = cache.path("outline-1-ab");
            let mut file = fs::read(&path).expect("is there");
            spoil(&mut file);
            fs::write(&path, file).expect("can be spoilt");
            assert_eq!(cache.fetch("outline-1-ab"), None);
            assert!(!path.exists());
        }
        cache.keep("outline-1-ab", b"0123456789");
        fs::copy(cache.path("outline-1-ab"), cache.path("outline-1-cd")).expect("copies");
        assert_eq!(cache.fetch("outline-1-cd"), None);
    }

    #[test]
    fn what_was_used_longest_ago_goes_when_the_room_is_full() {
        let (_dir, cache) = cache(10_000);
        let bytes = [7_u8; 1500];
        for number in 0..6_u64 {
            cache.keep(&format!("k{number}"), &bytes);
            let file = fs::File::options().append(true).open(cache.path(&format!("k{number}"))).expect("is there");
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(number)).expect("can be set");
        }
        assert!(cache.fetch("k0").is_some(), "and with that it is the one used last");
        cache.keep("k6", &bytes);
        assert!(cache.used_bytes() <= 10_000);
        assert!(cache.fetch("k1").is_none() && cache.fetch("k2").is_none());
        assert!(cache.fetch("k0").is_some() && cache.fetch("k5").is_some() && cache.fetch("k6").is_some());
        cache.keep("huge", &[0; 9000]);
        assert!(cache.fetch("huge").is_none() && cache.fetch("k6").is_some());
    }
}
