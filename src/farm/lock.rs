//! One daemon per ledger: a second one is refused, for two would print everything twice, and is told who was first.

use std::{
    fs::File,
    io::{Read, Write},
    path::Path,
};

use anyhow::{Context, Result, bail};
use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};

/// The lock's file in the state directory.
pub const NAME: &str = "nestd.lock";

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
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
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

/// The name of this server.
pub fn host_name() -> String {
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
