//! Checks whether the files that this process has open are still the ones at the ledger's path. If a file was removed
//! or replaced, SQLite continues silently in the old one: what is written there is lost when the process ends, and new
//! connections read another database.

use std::{
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use crate::{LedgerError, base::error::Result};

/// Device and inode.
type Identity = (u64, u64);

/// Identities of the ledger files when they were opened.
#[derive(Debug)]
pub struct LedgerFileGuard {
    ledger: OpenedFile,
    sidecars: [OpenedFile; 2],
}

#[derive(Debug)]
struct OpenedFile {
    path: PathBuf,
    /// `None` = SQLite has not created it yet.
    identity: Mutex<Option<Identity>>,
}

impl LedgerFileGuard {
    /// Creates the guard for a ledger that is about to be opened.
    pub fn for_ledger(ledger: &Path) -> Self {
        let opened = |suffix: &str| {
            let mut path = ledger.as_os_str().to_owned();
            path.push(suffix);
            OpenedFile { path: path.into(), identity: Mutex::new(None) }
        };
        Self { ledger: opened(""), sidecars: [opened("-wal"), opened("-shm")] }
    }

    /// Checks that all files are the ones that were opened.
    ///
    /// `Replaced` if one is not.
    pub fn ensure_unchanged(&self) -> Result<()> {
        for opened in [&self.ledger].into_iter().chain(&self.sidecars) {
            if let Some(what) = opened.describe_change() {
                return Err(LedgerError::Replaced { path: self.ledger.path.clone(), what });
            }
        }
        Ok(())
    }
}

impl OpenedFile {
    fn describe_change(&self) -> Option<String> {
        let now = match fs::metadata(&self.path) {
            Ok(meta) => Some((meta.dev(), meta.ino())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            // A file that cannot be inspected now is not necessarily gone.
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
