//! Counts the refused files in an error folder that somebody must still handle. Not counted are files that were
//! cancelled on purpose, dismissed, or can no longer be taken back.

use std::{
    collections::HashMap,
    fs, io,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use crate::{intake, ledger::RETRY_PERIOD};

/// A file in the error folder: refusals older than its modification time are dismissed.
const DISMISSED: &str = ".nestd-dismissed";
/// Start of the reason of a cancelled part.
pub(super) const CANCELLED: &str = "Cancelled by ";
/// End of the name of a reason.
const REASON: &[u8] = b".reason.txt";

/// What is known of the reasons in an error folder.
#[derive(Debug, Default)]
pub struct RefusedFiles {
    /// Reason -> when it was written, and whether the part was cancelled.
    known: HashMap<PathBuf, (SystemTime, bool)>,
}

impl RefusedFiles {
    /// Number of files that somebody must handle.
    pub fn count_unresolved(&mut self, error_dir: &Path) -> usize {
        let dismissed = fs::metadata(error_dir.join(DISMISSED)).and_then(|meta| meta.modified()).ok();
        let before = std::mem::take(&mut self.known);
        for reason in intake::files_below(error_dir).unwrap_or_default() {
            if !reason.as_os_str().as_encoded_bytes().ends_with(REASON) {
                continue;
            }
            let Ok(written) = fs::symlink_metadata(&reason).and_then(|meta| meta.modified()) else { continue };
            let known = before.get(&reason).filter(|(when, _)| *when == written).copied();
            let known = known.unwrap_or_else(|| (written, is_cancelled_reason(&reason)));
            self.known.insert(reason, known);
        }
        let is_old = |written: &SystemTime| written.elapsed().is_ok_and(|age| age > refused_retention());
        let needs_person = |(written, is_cancelled): &&(SystemTime, bool)| {
            !is_cancelled && dismissed.is_none_or(|at| *written > at) && !is_old(written)
        };
        self.known.values().filter(needs_person).count()
    }
}

/// How long a refused part can be taken back.
fn refused_retention() -> Duration {
    RETRY_PERIOD.unsigned_abs()
}

fn is_cancelled_reason(reason: &Path) -> bool {
    let text = intake::read_reason(reason).ok().flatten().unwrap_or_default();
    text.starts_with(CANCELLED)
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
    use super::*;

    #[test]
    fn what_was_cancelled_or_dismissed_or_is_old_needs_nobody() {
        let dir = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).expect("can be written");
        let mut refused = RefusedFiles::default();
        assert_eq!(refused.count_unresolved(dir.path()), 0);
        fs::create_dir(dir.path().join("part-3")).expect("a folder");
        write(
            "part-3/a.stl.reason.txt",
            "Cancelled by ann@pc.\n\nPart 3 of the profile p. To take it back: nestd retry 3\n",
        );
        write("b.pdf.reason.txt", "b.pdf was refused.\n\nIt is a PDF file.\n");
        write("b.pdf", "x");
        assert_eq!(refused.count_unresolved(dir.path()), 1);
        assert_eq!(refused.count_unresolved(dir.path()), 1);
        dismiss_refused(dir.path()).expect("can be written");
        assert_eq!(refused.count_unresolved(dir.path()), 0);
        dismiss_refused(dir.path()).expect("can be written again");
        std::thread::sleep(Duration::from_millis(20));
        write("c.obj.reason.txt", "c.obj was refused.\n");
        assert_eq!(refused.count_unresolved(dir.path()), 1);
        let old = SystemTime::now() - refused_retention() - Duration::from_secs(60);
        let reason = fs::File::options().write(true).open(dir.path().join("c.obj.reason.txt")).expect("is there");
        reason.set_modified(old).expect("can be set");
        assert_eq!(refused.count_unresolved(dir.path()), 0);
    }
}
