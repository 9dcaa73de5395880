//! Who holds the write lock of a ledger in a file, and since when this process waits for it. SQLite only says that the database is locked;
//! the kernel says by whom.

use std::{
    fs,
    os::unix::fs::MetadataExt,
    path::Path,
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

/// Byte of SQLite's index of the write-ahead log (`-shm`) that a writer locks.
const WRITE_LOCK_BYTE: u64 = 120;
/// Time that a writer waits for another process before it gives up. Changes take milliseconds.
pub const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
/// A holder whom the kernel does not name is asked for again after this time.
const ASK_AGAIN: Duration = Duration::from_secs(2);
/// From here on, somebody is told what is waited for.
pub const TOLD_AFTER: Duration = Duration::from_secs(1);

/// What is known of a lock that is waited for, or was waited for in vain.
#[derive(Debug, Default)]
pub struct LockWait(Mutex<Option<HeldLock>>);

#[derive(Debug, Clone)]
struct HeldLock {
    holder: Option<LockHolder>,
    is_given_up: bool,
    seen_at: Instant,
}

/// A process that holds the write lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LockHolder {
    /// Its number.
    pub pid: u32,
    name: String,
}

impl std::fmt::Display for LockHolder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "process {} ({})", self.pid, self.name)
    }
}

/// A holder in words.
pub fn describe_holder(holder: Option<&LockHolder>) -> String {
    holder.map_or_else(|| "another process".to_owned(), LockHolder::to_string)
}

impl LockWait {
    /// The lock of `ledger` is being waited for, or that was given up. Returns its holder.
    pub fn note(&self, ledger: &Path, is_given_up: bool) -> Option<LockHolder> {
        let holder = find_holder(ledger);
        *self.lock() = Some(HeldLock { holder: holder.clone(), is_given_up, seen_at: Instant::now() });
        holder
    }

    /// The lock was taken.
    pub fn end(&self) {
        *self.lock() = None;
    }

    /// Whether the lock is waited for at this moment, and its holder in words.
    pub fn waited_for(&self) -> Option<String> {
        self.lock().as_ref().filter(|held| !held.is_given_up).map(|held| describe_holder(held.holder.as_ref()))
    }

    /// The holder, if it was given up to wait for the lock, and it is still held as far as anybody knows.
    pub fn given_up(&self, ledger: &Path) -> Option<Option<LockHolder>> {
        let held = self.lock().clone().filter(|held| held.is_given_up)?;
        // The kernel's list is read in pieces while others change it: a lock that is held may be missing once.
        let now = find_holder(ledger).or_else(|| find_holder(ledger));
        if now.is_some() || held.holder.is_none() && held.seen_at.elapsed() < ASK_AGAIN {
            return Some(now);
        }
        self.end();
        None
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<HeldLock>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The process that holds the write lock of a ledger, by the kernel's list of locks. The file itself is not opened: to close it would
/// release the locks that SQLite has on it in this process.
pub fn find_holder(ledger: &Path) -> Option<LockHolder> {
    let mut index = ledger.as_os_str().to_owned();
    index.push("-shm");
    let inode = fs::metadata(index).ok()?.ino();
    let pid = fs::read_to_string("/proc/locks").ok()?.lines().find_map(|line| write_lock_pid(line, inode))?;
    let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    Some(LockHolder { pid, name: name.trim_end().to_owned() })
}

/// The process that holds the write lock of the index with this inode, if a line of `/proc/locks` says so:
/// `1: POSIX  ADVISORY  WRITE 4711 fd:01:1234567 120 120`.
fn write_lock_pid(line: &str, inode: u64) -> Option<u32> {
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let [_, "POSIX" | "OFDLCK", _, "WRITE", pid, file, from, to] = fields[..] else { return None };
    let is_file = file.rsplit(':').next()?.parse() == Ok(inode);
    let covers = from.parse::<u64>().ok()? <= WRITE_LOCK_BYTE
        && to.parse::<u64>().map_or(to == "EOF", |to| to >= WRITE_LOCK_BYTE);
    (is_file && covers).then(|| pid.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_holder_of_the_write_lock_is_read_from_the_list_of_the_kernel() {
        for (line, pid) in [
            ("1: POSIX  ADVISORY  WRITE 4711 fd:01:77 120 120", Some(4711)),
            ("1: POSIX  ADVISORY  WRITE 4711 fd:01:77 0 EOF", Some(4711)),
            ("1: POSIX  ADVISORY  READ 4711 fd:01:77 120 120", None),
            ("1: POSIX  ADVISORY  WRITE 4711 fd:01:77 123 123", None),
            ("1: POSIX  ADVISORY  WRITE 4711 fd:01:78 120 120", None),
            // One that waits for the lock.
            ("1: -> POSIX  ADVISORY  WRITE 4711 fd:01:77 120 120", None),
        ] {
            assert_eq!(write_lock_pid(line, 77), pid, "{line}");
        }
    }
}
