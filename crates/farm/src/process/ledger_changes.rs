//! An idle farm uses almost no CPU, and asks its database almost nothing: it looks for work only when something may have changed.
//! Changes come through the ledger from other processes, too, so the farm watches the ledger's files, or is told by its server. What
//! was not told is found by looking at the numbers of the latest rows now and then.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant, SystemTime},
};

use ledger::Ledger;

/// Interval of the looks at a server that tells of changes.
const LOOK_EVERY: Duration = Duration::from_secs(10);

/// What changes when anybody changes the ledger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LedgerFingerprint {
    /// Size and modification time of the ledger's files.
    Files([Option<(u64, SystemTime)>; 2]),
    /// Of a server.
    Server {
        /// How many changes were told; `None` = none is told at present.
        told: Option<u64>,
        /// Numbers of its latest event and command; `None` = the server cannot be asked.
        rows: Option<(i64, i64)>,
    },
}

/// When the ledger was last looked at for work, and what it was like before that.
#[derive(Debug, Default)]
pub struct LedgerChangeDetector {
    last_asked: Option<(Instant, LedgerFingerprint)>,
    /// When the numbers of the latest rows were read last.
    rows_read: Option<(Instant, Option<(i64, i64)>)>,
}

impl LedgerChangeDetector {
    /// Whether a ledger may have changed since the last look, as far as it concerns these machines, or `at_latest` has passed. If so,
    /// a new look is recorded.
    pub async fn may_have_changed<'m>(
        &mut self,
        ledger: &Ledger,
        machines: impl IntoIterator<Item = &'m str>,
        (now, at_latest): (Instant, Duration),
    ) -> bool {
        let print = match ledger.file() {
            Some(file) => LedgerFingerprint::of_file(file),
            None => {
                let told = ledger.told_changes(machines);
                let is_old = |at: Instant| told.is_none() || now.saturating_duration_since(at) >= LOOK_EVERY;
                let rows = match self.rows_read {
                    Some((at, rows)) if !is_old(at) => rows,
                    _ => self.rows_read.insert((now, ledger.latest_numbers().await.ok())).1,
                };
                LedgerFingerprint::Server { told, rows }
            }
        };
        self.has_changed(print, now, at_latest)
    }

    fn has_changed(&mut self, print: LedgerFingerprint, now: Instant, at_latest: Duration) -> bool {
        let is_old = |(at, seen): &(Instant, LedgerFingerprint)| {
            *seen != print || now.saturating_duration_since(*at) >= at_latest
        };
        let news = self.last_asked.as_ref().is_none_or(is_old);
        if news {
            self.last_asked = Some((now, print));
        }
        news
    }
}

impl LedgerFingerprint {
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
        let (mut quiet, at_latest) = (LedgerChangeDetector::default(), Duration::from_secs(2));
        let start = Instant::now();
        let mut has_changed = |now| quiet.has_changed(LedgerFingerprint::of_file(&ledger), now, at_latest);
        assert!(has_changed(start));
        assert!(!has_changed(start));
        fs::write(dir.path().join("nestd.db-wal"), "a commit").expect("can be written");
        assert!(has_changed(start) && !has_changed(start));
        fs::write(&ledger, "folded in").expect("can be written");
        assert!(has_changed(start) && !has_changed(start));
        assert!(has_changed(start + at_latest));
    }
}
