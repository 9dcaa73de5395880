//! Disk cache of prepared mesh data, by content, so that each mesh is prepared once and not at every start. An entry
//! that is torn, altered or from another version is dropped and made again; the cache can never make a build wrong.

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

use nester::PreparedMeshCache;
use settings::Settings;
use tracing::{debug, warn};

/// First bytes of an entry; the number changes with the format.
const MAGIC: &[u8; 16] = b"nestd-prepared-1";
/// Size of the header: magic, and BLAKE3 of key and bytes.
const HEADER_BYTES: usize = 16 + 32;
/// End of the names of entries.
const ENDING: &str = ".prepared";
/// Prefix of files that are being written.
const TEMPORARY: &str = "tmp-";
/// When entries are evicted, this share of the capacity stays filled.
const KEEP_SHARE: f64 = 0.9;

/// A folder of entries, `<key>.prepared`, with a maximum size; the entries used longest ago are evicted first.
#[derive(Debug)]
pub struct DiskPreparationCache {
    dir: PathBuf,
    cap_bytes: u64,
    used_bytes: AtomicU64,
    sweeping: Mutex<()>,
}

/// An entry on disk.
struct CacheEntry {
    used_at: SystemTime,
    path: PathBuf,
    bytes: u64,
}

impl DiskPreparationCache {
    /// Opens a cache at `dir`, creates the folder if it is missing, and removes files that a crash left half written.
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
        let used = cache.list_entries()?.iter().map(|entry| entry.bytes).sum();
        cache.used_bytes.store(used, Ordering::Relaxed);
        cache.evict_oldest()?;
        Ok(cache)
    }

    /// The cache of a farm, in its state directory; `None` = the farm works without it, only slower.
    pub fn for_farm(settings: &Settings) -> Option<Self> {
        if settings.resources.cache_bytes == 0 {
            return None;
        }
        let opened = Self::open(settings.state_dir.join("cache"), settings.resources.cache_bytes);
        opened.inspect_err(|error| warn!("Prepared meshes are not stored: {error}.")).ok()
    }

    /// Whether it is the cache that these settings ask for.
    pub fn is_of(&self, settings: &Settings) -> bool {
        (self.dir.as_path(), self.cap_bytes)
            == (settings.state_dir.join("cache").as_path(), settings.resources.cache_bytes)
    }

    /// Total size of all entries, bytes.
    pub fn used_bytes(&self) -> u64 {
        self.used_bytes.load(Ordering::Relaxed)
    }

    fn entry_path(&self, key: &str) -> PathBuf {
        self.dir.join(format!("{key}{ENDING}"))
    }

    fn list_entries(&self) -> io::Result<Vec<CacheEntry>> {
        let mut entries = Vec::new();
        for file in fs::read_dir(&self.dir)? {
            let path = file?.path();
            // Another process may have removed it meanwhile.
            let Ok(data) = fs::metadata(&path) else { continue };
            if data.is_file() && path.to_string_lossy().ends_with(ENDING) {
                entries.push(CacheEntry { used_at: data.modified()?, path, bytes: data.len() });
            }
        }
        Ok(entries)
    }

    /// Evicts the entries used longest ago until the rest fits.
    fn evict_oldest(&self) -> io::Result<()> {
        if self.used_bytes() <= self.cap_bytes {
            return Ok(());
        }
        let _one_at_a_time = self.sweeping.lock().unwrap_or_else(PoisonError::into_inner);
        let mut entries = self.list_entries()?;
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

    fn write_entry(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.entry_path(key);
        let mut file = tempfile::Builder::new().prefix(TEMPORARY).tempfile_in(&self.dir)?;
        file.write_all(MAGIC)?;
        file.write_all(entry_checksum(key, bytes).as_bytes())?;
        file.write_all(bytes)?;
        // Not fsynced: an entry that a crash tears fails its checksum and is made again.
        let replaced = fs::metadata(&path).map_or(0, |data| data.len());
        file.persist(&path).map_err(|error| error.error)?;
        let size = (HEADER_BYTES + bytes.len()) as u64;
        self.used_bytes.fetch_add(size.saturating_sub(replaced), Ordering::Relaxed);
        self.evict_oldest()
    }
}

impl PreparedMeshCache for DiskPreparationCache {
    fn fetch_bytes(&self, key: &str) -> Option<Vec<u8>> {
        let path = self.entry_path(key);
        let mut whole = fs::read(&path).ok()?;
        if !is_intact(key, &whole) {
            debug!("Dropped the damaged entry {}.", path.display());
            let _ = fs::remove_file(&path);
            self.used_bytes.fetch_sub((whole.len() as u64).min(self.used_bytes()), Ordering::Relaxed);
            return None;
        }
        mark_used(&path);
        whole.drain(..HEADER_BYTES);
        Some(whole)
    }

    fn store_bytes(&self, key: &str, bytes: &[u8]) {
        // A very large entry would evict all others, and then itself.
        if 4 * (HEADER_BYTES + bytes.len()) as u64 > self.cap_bytes {
            return;
        }
        if let Err(error) = self.write_entry(key, bytes) {
            debug!("Could not keep {}: {error}.", self.entry_path(key).display());
        }
    }
}

/// The cache of a farm, for a process that only looks: it stores nothing, and removes nothing.
#[derive(Debug)]
pub struct DiskCacheReader {
    dir: PathBuf,
}

impl DiskCacheReader {
    /// The cache of a farm; `None` = the farm has none.
    pub fn of_farm(settings: &Settings) -> Option<Self> {
        (settings.resources.cache_bytes > 0).then(|| Self { dir: settings.state_dir.join("cache") })
    }
}

impl PreparedMeshCache for DiskCacheReader {
    fn fetch_bytes(&self, key: &str) -> Option<Vec<u8>> {
        let mut whole = fs::read(self.dir.join(format!("{key}{ENDING}"))).ok()?;
        is_intact(key, &whole).then(|| {
            whole.drain(..HEADER_BYTES);
            whole
        })
    }

    fn store_bytes(&self, _key: &str, _bytes: &[u8]) {}
}

fn entry_checksum(key: &str, bytes: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(key.as_bytes()).update(&[0]).update(bytes);
    hasher.finalize()
}

fn is_intact(key: &str, file: &[u8]) -> bool {
    let Some((header, bytes)) = file.split_at_checked(HEADER_BYTES) else { return false };
    header[..16] == *MAGIC && header[16..] == *entry_checksum(key, bytes).as_bytes()
}

/// The modification time of the file is the time of the last use. If it cannot be set, the entry is only evicted
/// earlier.
fn mark_used(path: &Path) {
    if let Ok(file) = fs::File::options().append(true).open(path) {
        let _ = file.set_modified(SystemTime::now());
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn cache(cap_bytes: u64) -> (tempfile::TempDir, DiskPreparationCache) {
        let dir = tempfile::tempdir().expect("a folder");
        let cache = DiskPreparationCache::open(dir.path().join("cache"), cap_bytes).expect("opens");
        (dir, cache)
    }

    #[test]
    fn what_is_kept_comes_back_also_after_a_restart() {
        let (dir, cache) = cache(1 << 20);
        cache.store_bytes("guides-1-ab", b"many numbers");
        assert_eq!(cache.fetch_bytes("guides-1-ab").as_deref(), Some(&b"many numbers"[..]));
        assert_eq!(cache.fetch_bytes("guides-1-cd"), None);
        let again = DiskPreparationCache::open(dir.path().join("cache"), 1 << 20).expect("opens");
        assert_eq!(again.used_bytes(), cache.used_bytes());
        assert!(again.fetch_bytes("guides-1-ab").is_some());
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
            cache.store_bytes("outline-1-ab", b"0123456789");
            let path = cache.entry_path("outline-1-ab");
            let mut file = fs::read(&path).expect("is there");
            spoil(&mut file);
            fs::write(&path, file).expect("can be spoilt");
            assert_eq!(cache.fetch_bytes("outline-1-ab"), None);
            assert!(!path.exists());
        }
        cache.store_bytes("outline-1-ab", b"0123456789");
        fs::copy(cache.entry_path("outline-1-ab"), cache.entry_path("outline-1-cd")).expect("copies");
        assert_eq!(cache.fetch_bytes("outline-1-cd"), None);
    }

    #[test]
    fn what_was_used_longest_ago_goes_when_the_room_is_full() {
        let (_dir, cache) = cache(10_000);
        let bytes = [7_u8; 1500];
        for number in 0..6_u64 {
            cache.store_bytes(&format!("k{number}"), &bytes);
            let file =
                fs::File::options().append(true).open(cache.entry_path(&format!("k{number}"))).expect("is there");
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(number)).expect("can be set");
        }
        assert!(cache.fetch_bytes("k0").is_some(), "and with that it is the one used last");
        cache.store_bytes("k6", &bytes);
        assert!(cache.used_bytes() <= 10_000);
        assert!(cache.fetch_bytes("k1").is_none() && cache.fetch_bytes("k2").is_none());
        assert!(
            cache.fetch_bytes("k0").is_some() && cache.fetch_bytes("k5").is_some() && cache.fetch_bytes("k6").is_some()
        );
        cache.store_bytes("huge", &[0; 9000]);
        assert!(cache.fetch_bytes("huge").is_none() && cache.fetch_bytes("k6").is_some());
    }
}
