//! Whether the files that this process has open are those that stand in the ledger's place. SQLite goes on without a word in
//! a file that was removed or replaced; what is written there is gone with the process, and a connection that is made later
//! reads another database.

use std::{
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use super::{LedgerError, error::Result};

/// Device and inode.
type Identity = (u64, u64);

/// The files as they were when they were opened.
#[derive(Debug)]
pub struct InPlace {
    ledger: Opened,
    beside: [Opened; 2],
}

#[derive(Debug)]
struct Opened {
    path: PathBuf,
    /// `None` = SQLite has not made it yet.
    identity: Mutex<Option<Identity>>,
}

impl InPlace {
    /// Of a ledger that is about to be opened.
    pub fn of(ledger: &Path) -> Self {
        let opened = |suffix: &str| {
            let mut path = ledger.as_os_str().to_owned();
            path.push(suffix);
            Opened { path: path.into(), identity: Mutex::new(None) }
        };
        Self { ledger: opened(""), beside: [opened("-wal"), opened("-shm")] }
    }

    /// Whether all files are those that were opened.
    ///
    /// # Errors
    /// `Replaced` when one is not.
    pub fn demand(&self) -> Result<()> {
        for opened in [&self.ledger].into_iter().chain(&self.beside) {
            if let Some(what) = opened.changed() {
                return Err(LedgerError::Replaced { path: self.ledger.path.clone(), what });
            }
        }
        Ok(())
    }
}

impl Opened {
    fn changed(&self) -> Option<String> {
        let now = match fs::metadata(&self.path) {
            Ok(meta) => Some((meta.dev(), meta.ino())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            // What cannot be looked at now is not gone.
            Err(_) => return None,
        };
        let mut known = self.identity.lock().unwrap_or_else(PoisonError::into_inner);
        match (*known, now) {
            (None, _) => *known = now,
            (Some(was), Some(now)) if was == now => {}
            (Some(_), Some(_)) => return Some(format!("{} is another file now", self.path.display())),
            (Some(_), None) => return Some(format!("{} was removed", self.path.display())),
        }
        None
    }
}
