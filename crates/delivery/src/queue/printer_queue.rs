//! What a printer's queue is for the farm, whatever the printer is reached by. A kind of queue is one `impl PrinterQueue` in this
//! room, and a variant of [`QueueAddress`](super::QueueAddress).

use std::{
    fmt,
    fs::File,
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{QueueAddress, QueueError, file_names};

/// An open queue, shared by whoever works with it.
pub type OpenQueue = Arc<dyn PrinterQueue>;

/// Writes a file that is staged.
pub type StageWriter<'w> = Box<dyn FnOnce(&mut File) -> Result<(), Box<dyn std::error::Error + Send + Sync>> + 'w>;

/// Where the file of a build is in a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileState {
    /// nestd has written it, and the printer does not see it: not published yet.
    Staged,
    /// The printer sees it, and has not taken it.
    Visible,
    /// nestd took it back: the printer does not see it any more, and has not taken it.
    TakenBack,
    /// It is not there: the printer took it if it was published; else it was never staged, or somebody removed it.
    Gone,
}

/// Result of publishing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PublishOutcome {
    /// The file was published by this call.
    PublishedNow,
    /// It was not staged any more: the build was published before.
    AlreadyPublished,
}

/// Result of taking a build back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeBackOutcome {
    /// The printer cannot take it any more.
    TakenBack,
    /// The printer took it.
    Gone,
    /// What the printer sees under its name is not the file that was proved. It stays where it is.
    Altered,
}

/// What changes when a visible file is written, replaced or put back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileStamp {
    /// Size.
    pub bytes: u64,
    /// Whether it is a file that can be read.
    pub is_file: bool,
    /// Times in ns and number of the file, as its queue has them.
    pub version: [i64; 5],
}

/// The queue of a printer, in which the file of a build becomes visible exactly once.
///
/// Every error means that nothing is known: a queue that does not answer is never one whose printer took the file. Each operation is
/// on the printer's side, or on disk, when it returns; it may be stopped anywhere, and is safe to repeat.
pub trait PrinterQueue: fmt::Debug + Send + Sync {
    /// What tells it from another one in its place. It is stored in the rows of its builds.
    fn id(&self) -> &str;

    /// Where it is, as the settings say.
    fn address(&self) -> &QueueAddress;

    /// Checks that it is there and is still the one that was opened. Another one would look as if the printer had taken all builds.
    fn check(&self) -> Result<(), QueueError>;

    /// Where the file of a build is. Staged goes before all others: as long as a file is staged, it was not published from there.
    fn state(&self, build_name: &str) -> Result<FileState, QueueError>;

    /// The names of all files that are in this state: of what is visible all that the printer sees, whoever put it there; else the
    /// names of builds, of which some may be other farms'.
    fn names(&self, state: FileState) -> Result<Vec<String>, QueueError>;

    /// The path under which this machine can read a file in this state. It may be missing.
    fn file(&self, name: &str, state: FileState) -> Result<PathBuf, QueueError>;

    /// The stamp of a visible file; `None` = it is not there.
    fn stamp(&self, name: &str) -> Option<FileStamp>;

    /// Writes a file where the printer does not see it; afterwards it is staged completely, or not at all. Sidecars of a build (same
    /// stem, other suffix) are staged in the same way and published with the build. Replaces a staged file of that name, and never
    /// changes a visible one. Returns its path.
    fn stage(&self, name: &str, write: StageWriter<'_>) -> Result<PathBuf, QueueError>;

    /// Makes a staged build visible, after its sidecars, and overwrites nothing.
    fn publish(&self, build_name: &str) -> Result<PublishOutcome, QueueError>;

    /// Removes a staged build and its sidecars, and visible sidecars if the build itself is not visible. A visible build stays. Call it
    /// only for a build that was not published: the printer may have taken a published build and left its sidecars. Returns whether a
    /// staged build existed.
    fn discard(&self, build_name: &str) -> Result<bool, QueueError>;

    /// Removes what nestd staged of builds that are not in `keep`. Returns the names of what was removed.
    fn sweep(&self, keep: &[String]) -> Result<Vec<String>, QueueError>;

    /// Takes a visible build and its sidecars back if it is the proved one, as `is_proved` says of a file; what is not stays visible.
    /// First of all it is put out of the printer's reach, which succeeds or finds that the printer took it: never both.
    fn take_back(&self, build_name: &str, is_proved: IsProved<'_>) -> Result<TakeBackOutcome, QueueError>;

    /// Removes what was taken back; afterwards nothing tells that it ever was here.
    fn remove_taken_back(&self, build_name: &str) -> Result<(), QueueError>;

    /// Whether a build was taken back and is still here.
    fn holds_taken_back(&self, build_name: &str) -> bool {
        self.file(build_name, FileState::TakenBack).is_ok_and(|file| file.exists())
    }

    /// Stages what was taken back out of a queue in this one, which may be the same: the sidecars first.
    fn stage_taken_back(&self, from: &dyn PrinterQueue, build_name: &str) -> Result<(), QueueError> {
        from.check()?;
        for name in file_names::files_of_build(build_name)? {
            let source = from.file(&name, FileState::TakenBack)?;
            let stat = |error| QueueError::Io { what: "stat", path: source.clone(), source: error };
            if source.try_exists().map_err(stat)? {
                self.stage(&name, Box::new(|file| Ok(io::copy(&mut File::open(&source)?, file).map(drop)?)))?;
            }
        }
        Ok(())
    }
}

/// Says of a file whether it is the one that was proved.
pub type IsProved<'p> = &'p dyn Fn(&Path) -> io::Result<bool>;

/// Whether a file with this name is one of a build.
pub fn is_build_name(name: &str) -> bool {
    file_names::build_stem(name).is_ok()
}
