//! One daemon per ledger: a second one would print everything twice, so it is refused and told who holds the lock.

use std::{
    fs::File,
    io::{Read, Write},
    path::Path,
    sync::Arc,
    thread,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};

/// Name of the lock file in the state directory.
pub use ledger::LOCK_NAME as NAME;

/// A process that only checks whether a daemon runs holds the lock for a moment; a process that holds it longer is a
/// daemon.
const LOCK_ATTEMPTS: u32 = 10;
const LOCK_RETRY_DELAY: Duration = Duration::from_millis(50);

/// Held as long as the daemon runs, also between two attempts to open the farm; the kernel releases it when the process ends, in whatever
/// way. All copies are one lock.
#[derive(Debug, Clone)]
pub struct StateDirLock {
    _file: Arc<File>,
}

impl StateDirLock {
    /// Acquires the lock of a state directory, and writes the holder into the file.
    pub fn acquire(state_dir: &Path, since: Timestamp) -> Result<Self> {
        let path = state_dir.join(NAME);
        let mut file = File::options()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .with_context(|| format!("opening the lock {}", path.display()))?;
        let lock = || flock(&file, FlockOperation::NonBlockingLockExclusive);
        let mut locked = lock();
        for _ in 1..LOCK_ATTEMPTS {
            if locked != Err(rustix::io::Errno::WOULDBLOCK) {
                break;
            }
            thread::sleep(LOCK_RETRY_DELAY);
            locked = lock();
        }
        match locked {
            Ok(()) => {
                let who = format!(
                    "process {} on {} since {}\n",
                    std::process::id(),
                    host_name(),
                    since.strftime("%F %T UTC")
                );
                // Only information for a second daemon: on a full disk the lock works without it.
                let _ = file.set_len(0).and_then(|()| file.write_all(who.as_bytes()));
                Ok(Self { _file: Arc::new(file) })
            }
            Err(rustix::io::Errno::WOULDBLOCK) => {
                let mut who = String::new();
                let _ = file.read_to_string(&mut who);
                let who = if who.trim().is_empty() { "a process that is not known" } else { who.trim() };
                bail!("another nestd serves {} already: {who}. Stop that one first", state_dir.display())
            }
            Err(error) => Err(error).with_context(|| format!("locking {}", path.display())),
        }
    }
}

/// Whether a daemon holds the lock of a state directory; `false` if this cannot be determined.
pub fn is_held(state_dir: &Path) -> bool {
    let lock = File::open(state_dir.join(NAME));
    lock.is_ok_and(|lock| flock(&lock, FlockOperation::NonBlockingLockShared) == Err(rustix::io::Errno::WOULDBLOCK))
}

/// The name of this server. `NESTD_TEST_HOST` replaces it in tests of two servers; it is for tests only.
pub fn host_name() -> String {
    if let Ok(name) = std::env::var("NESTD_TEST_HOST") {
        return name;
    }
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_is_told_who_was_first() {
        let dir = tempfile::tempdir().unwrap();
        let first = StateDirLock::acquire(dir.path(), Timestamp::UNIX_EPOCH).unwrap();
        let refused = StateDirLock::acquire(dir.path(), Timestamp::now()).unwrap_err().to_string();
        let who = format!("process {} on {} since 1970-01-01 00:00:00 UTC", std::process::id(), host_name());
        assert!(refused.contains(&who), "{refused}");
        drop(first);
        StateDirLock::acquire(dir.path(), Timestamp::now()).unwrap();
    }
}
