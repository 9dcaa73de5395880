//! An idle farm uses next to no CPU: the ledger is asked for work only when something may have changed. Orders by hand
//! come through the ledger from other processes, so its files are looked at; and now and then it is asked anyway, for
//! what only the clock brings.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant, SystemTime},
};

/// The ledger is asked at least so often.
const ASK_EVERY: Duration = Duration::from_secs(2);

/// Size and time of change of the ledger's files.
type Print = [Option<(u64, SystemTime)>; 2];

/// When the ledger was last asked for work, and what its files looked like before that.
#[derive(Debug, Default)]
pub struct Quiet {
    asked: Option<(Instant, Print)>,
}

impl Quiet {
    /// Whether the ledger's files have changed since they were last asked, or it is time to ask anyway. Notes that it is
    /// asked now when so.
    pub fn has_news(&mut self, ledger: &Path, now: Instant) -> bool {
        let print = print(ledger);
        let is_old = |(at, seen): &(Instant, Print)| *seen != print || now.duration_since(*at) >= ASK_EVERY;
        let news = self.asked.as_ref().is_none_or(is_old);
        if news {
            self.asked = Some((now, print));
        }
        news
    }
}

/// The write-ahead log grows or is begun anew with every commit of any process; the database itself changes when it is
/// folded in.
fn print(ledger: &Path) -> Print {
    let mut log = ledger.as_os_str().to_owned();
    log.push("-wal");
    [ledger, Path::new(&log)].map(|file| {
        let data = fs::metadata(file).ok()?;
        Some((data.len(), data.modified().ok()?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ledger_is_asked_when_its_files_change_and_when_it_is_time() {
        let dir = tempfile::tempdir().expect("a folder");
        let ledger = dir.path().join("nestd.db");
        let mut quiet = Quiet::default();
        let start = Instant::now();
        assert!(quiet.has_news(&ledger, start));
        assert!(!quiet.has_news(&ledger, start));
        fs::write(dir.path().join("nestd.db-wal"), "a commit").expect("can be written");
        assert!(quiet.has_news(&ledger, start) && !quiet.has_news(&ledger, start));
        fs::write(&ledger, "folded in").expect("can be written");
        assert!(quiet.has_news(&ledger, start) && !quiet.has_news(&ledger, start));
        assert!(quiet.has_news(&ledger, start + ASK_EVERY));
    }
}
