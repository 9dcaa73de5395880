//! One daemon per ledger: a second one is refused, for two would print everything twice, and is told who was first.

use std::{
    fs::File,
    io::{Read, Write},
    path::Path,
    thread,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};

/// The lock's file in the state directory.
pub use crate::ledger::LOCK_NAME as NAME;

/// Whoever only looks whether a daemon runs holds the lock for a moment; who holds it longer is a daemon.
const TRIES: u32 = 10;
const PAUSE: Duration = Duration::from_millis(50);

/// Held for as long as the daemon runs; the kernel lets it go when the process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock of a state directory, and writes into it who did.
    pub fn take(state_dir: &Path, since: Timestamp) -> Result<Self> {
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
        for _ in 1..TRIES {
            if locked != Err(rustix::io::Errno::WOULDBLOCK) {
                break;
            }
            thread::sleep(PAUSE);
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
                // Only told to whoever comes second: on a full disk the lock holds without it.
                let _ = file.set_len(0).and_then(|()| file.write_all(who.as_bytes()));
                Ok(Self { _file: file })
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

/// The name of this server; `NESTD_TEST_HOST` is another one for tests of two servers, and for nothing else.
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
        let first = Lock::take(dir.path(), Timestamp::UNIX_EPOCH).unwrap();
        let refused = Lock::take(dir.path(), Timestamp::now()).unwrap_err().to_string();
        let who = format!("process {} on {} since 1970-01-01 00:00:00 UTC", std::process::id(), host_name());
        assert!(refused.contains(&who), "{refused}");
        drop(first);
        Lock::take(dir.path(), Timestamp::now()).unwrap();
    }
}
