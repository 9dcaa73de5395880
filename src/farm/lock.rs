//! One daemon per ledger: a second one is refused, for two would print everything twice.

use std::{fs::File, path::Path};

use anyhow::{Context, Result, bail};
use rustix::fs::{FlockOperation, flock};

/// Held for as long as the daemon runs; the kernel lets it go when the process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock of a state directory.
    pub fn take(state_dir: &Path) -> Result<Self> {
        let path = state_dir.join("nestd.lock");
        let file = File::options()
            .create(true)
            .append(true)
            .open(&path)
            .with_context(|| format!("opening the lock {}", path.display()))?;
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(Self { _file: file }),
            Err(rustix::io::Errno::WOULDBLOCK) => {
                bail!("another nestd serves {} already; stop it first", state_dir.display())
            }
            Err(error) => Err(error).with_context(|| format!("locking {}", path.display())),
        }
    }
}
