//! An idle farm uses almost no CPU: it queries the ledger for work only when something may have changed. Commands come
//! through the ledger from other processes, so the farm watches the ledger's files, or asks its server for the numbers of the
//! latest rows. It also queries the ledger at
//! intervals, for work that only depends on the time.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant, SystemTime},
};

use ledger::Ledger;

/// Maximum interval of the queries.
const ASK_EVERY: Duration = Duration::from_secs(2);

/// What changes when anybody changes the ledger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LedgerFingerprint {
    /// Size and modification time of the ledger's files.
    Files([Option<(u64, SystemTime)>; 2]),
    /// Numbers of its latest event and command; `None` = the server cannot be asked.
    Rows(Option<(i64, i64)>),
}

/// When the ledger was last queried for work, and the state of its files before that.
#[derive(Debug, Default)]
pub struct LedgerChangeDetector {
    last_asked: Option<(Instant, LedgerFingerprint)>,
}

impl LedgerChangeDetector {
    /// Whether the ledger has changed since the last query, or the interval has passed. If so, records a new
    /// query.
    pub fn has_changed(&mut self, print: LedgerFingerprint, now: Instant) -> bool {
        let is_old = |(at, seen): &(Instant, LedgerFingerprint)| *seen != print || now.duration_since(*at) >= ASK_EVERY;
        let news = self.last_asked.as_ref().is_none_or(is_old);
        if news {
            self.last_asked = Some((now, print));
        }
        news
    }
}

impl LedgerFingerprint {
    /// That of a ledger now.
    pub async fn take(ledger: &Ledger) -> Self {
        match ledger.file() {
            Some(file) => Self::of_file(file),
            None => Self::Rows(ledger.latest_numbers().await.ok()),
        }
    }

    /// The write-ahead log grows or restarts with every commit of any process; the database itself changes at a checkpoint.
    fn of_file(ledger: &Path) -> Self {
        let mut log = ledger.as_os_str().to_owned();
        log.push("-wal");
        Self::Files([ledger, Path::new(&log)].map(|file| {
            let data = fs::metadata(file).ok()?;
            Some((data.len(), data.modified().ok()?))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ledger_is_asked_when_its_files_change_and_when_it_is_time() {
        let dir = tempfile::tempdir().expect("a folder");
        let ledger = dir.path().join("nestd.db");
        let mut quiet = LedgerChangeDetector::default();
        let start = Instant::now();
        assert!(quiet.has_changed(LedgerFingerprint::of_file(&ledger), start));
        assert!(!quiet.has_changed(LedgerFingerprint::of_file(&ledger), start));
        fs::write(dir.path().join("nestd.db-wal"), "a commit").expect("can be written");
        assert!(
            quiet.has_changed(LedgerFingerprint::of_file(&ledger), start)
                && !quiet.has_changed(LedgerFingerprint::of_file(&ledger), start)
        );
        fs::write(&ledger, "folded in").expect("can be written");
        assert!(
            quiet.has_changed(LedgerFingerprint::of_file(&ledger), start)
                && !quiet.has_changed(LedgerFingerprint::of_file(&ledger), start)
        );
        assert!(quiet.has_changed(LedgerFingerprint::of_file(&ledger), start + ASK_EVERY));
    }
}
