//! Counts the refused files in an error folder that somebody must still handle. Not counted are files that were
//! cancelled on purpose, dismissed, or can no longer be taken back, and those of which no copy is wanted any more: another file took
//! their place, or their order was closed without them. That is in the row of the part; a file that was refused before it became a
//! part has none.

use std::{
    collections::HashMap,
    fs, io,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use ledger::{LedgerError, PartId, PartRow, PartState, RETRY_PERIOD, RefusalCause};

use super::error_folder::find_part_number;

/// A file in the error folder: refusals older than its modification time are dismissed.
const DISMISSED: &str = ".nestd-dismissed";

/// What is known of the reasons in an error folder.
#[derive(Debug, Default)]
pub struct RefusedFiles {
    /// Reason -> when it was written, and whether its part asks for a person.
    known: HashMap<PathBuf, (SystemTime, bool)>,
}

impl RefusedFiles {
    /// Number of files in the error folder of a machine that somebody must handle. `find_part` finds the row of a part;
    /// it is asked for each reason until its part asks
    /// nobody any more.
    pub fn count_unresolved(
        &mut self,
        error_dir: &Path,
        machine: &str,
        find_part: impl Fn(PartId) -> Result<Option<PartRow>, LedgerError>,
    ) -> usize {
        let dismissed = fs::metadata(error_dir.join(DISMISSED)).and_then(|meta| meta.modified()).ok();
        let before = std::mem::take(&mut self.known);
        for reason in intake::files_below(error_dir).unwrap_or_default() {
            if !intake::is_reason_file(&reason) {
                continue;
            }
            let Ok(written) = fs::symlink_metadata(&reason).and_then(|meta| meta.modified()) else { continue };
            let known = before.get(&reason).filter(|(when, asks)| *when == written && !asks);
            let asks = known.map(|(_, asks)| *asks).or_else(|| asks_for_person(&reason, machine, &find_part));
            if let Some(asks) = asks {
                self.known.insert(reason, (written, asks));
            }
        }
        let is_old = |written: &SystemTime| written.elapsed().is_ok_and(|age| age > refused_retention());
        let needs_person = |(written, asks): &&(SystemTime, bool)| {
            *asks && dismissed.is_none_or(|at| *written > at) && !is_old(written)
        };
        self.known.values().filter(needs_person).count()
    }
}

/// How long a refused part can be taken back.
fn refused_retention() -> Duration {
    RETRY_PERIOD.unsigned_abs()
}

/// Whether copies of the part that a reason names are wanted, and it was not cancelled; `None` = its row does not say so yet, or it was
/// taken back.
fn asks_for_person(
    reason: &Path,
    machine: &str,
    find_part: impl Fn(PartId) -> Result<Option<PartRow>, LedgerError>,
) -> Option<bool> {
    let text = intake::read_reason(reason).ok().flatten().unwrap_or_default();
    let Some(part) = find_part_number(&text, machine) else { return Some(true) };
    match find_part(part).ok()? {
        Some(row) if row.state != PartState::Refused => None,
        // Nobody prints a document, and somebody should see that it came.
        Some(row) if row.refused.refusal == Some(RefusalCause::Document) => Some(true),
        Some(row) => Some(row.wanted_copies() > 0 && !row.refused.refusal.is_some_and(RefusalCause::is_intended)),
        None => Some(true),
    }
}

/// Dismisses all refused files so far: the files stay, but nobody is reminded of them.
///
/// # Errors
/// The error folder cannot be written.
pub fn dismiss_refused(error_dir: &Path) -> io::Result<()> {
    let marker = error_dir.join(DISMISSED);
    match fs::remove_file(&marker) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    fs::File::create_new(&marker)?.set_modified(SystemTime::now())
}

#[cfg(test)]
mod tests {
    use ledger_fixtures::{fresh, waiting};

    use super::*;

    #[tokio::test(flavor = "multi_thread")]
    async fn what_was_cancelled_or_dismissed_or_is_old_needs_nobody() {
        let ledger = fresh().await;
        let (cancelled, retried) = (waiting(&ledger.ledger, "a", 1).await, waiting(&ledger.ledger, "b", 1).await);
        ledger.ledger.cancel_part(cancelled, RefusalCause::Cancelled, "Not needed.").await.unwrap();
        let machine = ledger.ledger.find_part(cancelled).await.unwrap().unwrap().machine;
        let runtime = tokio::runtime::Handle::current();
        let find_part = |part| tokio::task::block_in_place(|| runtime.block_on(ledger.ledger.find_part(part)));
        let dir = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).expect("can be written");
        let mut refused = RefusedFiles::default();
        let mut count = || refused.count_unresolved(dir.path(), &machine, find_part);
        assert_eq!(count(), 0);
        let reason =
            |part: PartId| format!("Not needed.\n\nPart {part} of the machine {machine}. To take it back: ..\n");
        fs::create_dir(dir.path().join("part-3")).expect("a folder");
        write("part-3/a.stl.reason.txt", &reason(cancelled));
        // As an earlier version wrote it.
        write("c.stl.reason.txt", &reason(retried).replace("of the machine", "of the profile"));
        assert_eq!(count(), 0, "the second one is not refused any more");
        write("b.pdf.reason.txt", "b.pdf was refused.\n\nIt is a PDF file. Cancelled by nobody.\n");
        write("b.pdf", "x");
        assert_eq!(count(), 1);
        write("part-9.reason.txt", &reason(PartId(999)));
        assert_eq!(count(), 2, "a part that the ledger does not know");
        ledger.ledger.cancel_part(retried, RefusalCause::TooLarge, "Cancelled by its size.").await.unwrap();
        assert_eq!(count(), 3, "it is refused now");
        dismiss_refused(dir.path()).expect("can be written");
        assert_eq!(count(), 0);
        dismiss_refused(dir.path()).expect("can be written again");
        std::thread::sleep(Duration::from_millis(20));
        write("c.obj.reason.txt", "c.obj was refused.\n");
        assert_eq!(count(), 1);
        let old = SystemTime::now() - refused_retention() - Duration::from_secs(60);
        let reason = fs::File::options().write(true).open(dir.path().join("c.obj.reason.txt")).expect("is there");
        reason.set_modified(old).expect("can be set");
        assert_eq!(count(), 0);
    }
}
