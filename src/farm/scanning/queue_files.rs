//! The build files that lie visible in the queue folders of a machine, and whether they should. The entries of the folders are the list,
//! and the ledger is asked by name, so that a look costs no more with a long history. What a file holds is read once, and again only
//! when its stamp has changed.

use std::{
    collections::BTreeMap,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use anyhow::Result;
use build_file::{HeadingMetadata, ReadLimits};

use super::machine_fit::find_misfit;
use crate::{
    intake,
    ledger::{BuildRow, BuildState},
    queue::QueueFolder,
    settings::MachineProfile,
};

/// Maximum number of files of which one look reads the content: after a start, the others are for the next looks.
const MAX_READ_PER_LOOK: usize = 8;

/// What changes when a file is written, replaced or put back: size, times in ns, inode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FileStamp {
    bytes: u64,
    modified: (i64, i64),
    changed: (i64, i64),
    inode: u64,
}

/// What was read of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
enum FileContent {
    /// BLAKE3 of all of it.
    Hash(String),
    /// The name that the build file had whose heading it has; `None` = it is none of a farm.
    OwnName(Option<String>),
}

/// What was read of the files in the queue folders of a machine, by their paths.
#[derive(Debug, Clone, Default)]
pub struct QueueFileMemory(Arc<Mutex<BTreeMap<PathBuf, (FileStamp, FileContent)>>>);

impl QueueFileMemory {
    /// The file is read again at the next look.
    pub(crate) fn forget(&self, file: &Path) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).remove(file);
    }

    fn keep_only(&self, files: &[PathBuf]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|file, _| files.contains(file));
    }

    /// What a file with this stamp holds, if it was read before.
    fn find(&self, file: &Path, stamp: FileStamp) -> Option<FileContent> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.get(file).filter(|(then, _)| *then == stamp).map(|(_, content)| content.clone())
    }

    fn keep(&self, file: &Path, stamp: FileStamp, content: FileContent) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(file.to_owned(), (stamp, content));
    }
}

/// What a look found.
#[derive(Debug, Default)]
pub(crate) struct QueueFileFindings {
    /// What must not be printed as it is, a clause each.
    pub(crate) wrong: Vec<String>,
    /// Builds that were taken and lie in a queue again, each with its printer and the marker of the folder.
    pub(crate) back: Vec<(BuildRow, String, String)>,
}

/// A look at the visible files of a machine.
pub(crate) struct QueueFileLook<'a> {
    /// The machine.
    pub(crate) profile: &'a MachineProfile,
    /// Its open queue folders, by the names of its printers.
    pub(crate) queues: &'a [(String, QueueFolder)],
    /// What earlier looks have read.
    pub(crate) memory: &'a QueueFileMemory,
    /// Finds the build of a machine that has a file of this name.
    pub(crate) find_build: &'a dyn Fn(&str) -> Result<Option<BuildRow>>,
    /// Whether copies of a build were told bad.
    pub(crate) has_bad_copies: &'a dyn Fn(&BuildRow) -> Result<bool>,
}

impl QueueFileLook<'_> {
    /// Looks at every visible build file.
    pub(crate) fn look(&self) -> Result<QueueFileFindings> {
        let (mut found, mut seen, mut reads) = (QueueFileFindings::default(), Vec::new(), MAX_READ_PER_LOOK);
        for (printer, queue) in self.queues {
            // A folder that is away keeps nobody from looking into the others.
            for name in queue.visible_names().unwrap_or_default() {
                self.look_at((printer, queue), &name, &mut reads, &mut found)?;
                seen.push(queue.published_path(&name));
            }
        }
        self.memory.keep_only(&seen);
        found.wrong.sort();
        Ok(found)
    }

    fn look_at(
        &self,
        (printer, queue): (&String, &QueueFolder),
        name: &str,
        reads: &mut usize,
        found: &mut QueueFileFindings,
    ) -> Result<()> {
        let (path, row) = (queue.published_path(name), (self.find_build)(name)?);
        // After the row was read: what lies there now was not taken back before that.
        let Ok(seen) = fs::symlink_metadata(&path) else { return Ok(()) };
        let stamp = stamp_of(&seen);
        let wrong = match row {
            Some(build) if build.place.move_to.is_some() || build.place.withdraw_by.is_some() => None,
            Some(build) if build.profile != self.profile.name => Some(match build.state {
                BuildState::Published => {
                    format!("is build {} of {}: take it to a queue of {1}", build.id, build.profile)
                }
                _ => format!(
                    "is the file of build {} of {} ({}): take it out, or its copies are printed a second time",
                    build.id,
                    build.profile,
                    build.state_word()
                ),
            }),
            Some(build) if build.state == BuildState::Published => {
                let is_proved = seen.is_file() && self.is_proved(&build, &path, stamp, reads);
                let wrong = self.find_fault_of_published(&build, queue, is_proved);
                if wrong.is_none() && build.place.taken_at.is_some() {
                    found.back.push((build, printer.clone(), queue.marker_id().to_owned()));
                }
                wrong
            }
            Some(build) => self.find_fault_of_told(&build)?,
            None => self.find_original(&path, stamp, reads)?.map(|build| {
                let own = build.staged.file_name.as_deref().unwrap_or_default();
                let is_wanted = build.state == BuildState::Published && build.profile == self.profile.name;
                let or_rename = if is_wanted { ", or give it that name back" } else { "" };
                format!(
                    "holds the copies of build {} ({}), whose file is {own}: take it out{or_rename}",
                    build.id,
                    build.state_word()
                )
            }),
        };
        found.wrong.extend(wrong.map(|wrong| format!("{name} at {printer} {wrong}")));
        Ok(())
    }

    fn find_fault_of_published(&self, build: &BuildRow, queue: &QueueFolder, is_proved: bool) -> Option<String> {
        let id = build.id;
        if !is_proved {
            return Some(format!(
                "is not the file that was proved as build {id}: take it out, look whether it was printed, and tell the outcome of build {id}"
            ));
        }
        let is_own = |queue: &QueueFolder| Some(queue.marker_id()) == build.staged.queue_id.as_deref();
        let name = build.staged.file_name.as_deref().unwrap_or_default();
        let own = self.queues.iter().find(|(_, other)| is_own(other) && !is_own(queue));
        if let Some((printer, _)) = own.filter(|(_, own)| own.published_path(name).exists()) {
            return Some(format!("is a second file of build {id}, which lies at {printer}: take it out"));
        }
        let why = find_misfit(self.profile, build)?;
        Some(format!(
            "does not fit, for {why}. `nestd withdraw {id}` takes it out, and its copies are nested for the machine as it is now"
        ))
    }

    /// What is wrong with the file of a build that is not to be printed any more. Where people leave files in the queue when they have
    /// printed them, one that never left it is no fault.
    fn find_fault_of_told(&self, build: &BuildRow) -> Result<Option<String>> {
        let (id, state) = (build.id, build.state_word());
        Ok(match build.state {
            BuildState::Failed => Some(format!(
                "is the file of build {id}, which is {state}: take it out, or its copies are printed a second time"
            )),
            BuildState::Printing | BuildState::Complete | BuildState::Interrupted
                if build.place.taken_at.is_some() || (self.has_bad_copies)(build)? =>
            {
                Some(format!("is the file of build {id} ({state}), which was out of the queue before: take it out"))
            }
            _ => None,
        })
    }

    /// Whether a file is the proved one, as far as it was read.
    fn is_proved(&self, build: &BuildRow, path: &Path, stamp: FileStamp, reads: &mut usize) -> bool {
        if build.staged.file_bytes.is_some_and(|bytes| bytes != stamp.bytes) {
            return false;
        }
        let read = || Ok(FileContent::Hash(intake::hash_file(path)?));
        match (
            self.read_once(path, stamp, reads, |known| matches!(known, FileContent::Hash(_)), read),
            &build.staged.file_hash,
        ) {
            (Some(FileContent::Hash(found)), Some(proved)) => found == *proved,
            _ => true,
        }
    }

    /// The build whose file was copied or renamed to this one.
    fn find_original(&self, path: &Path, stamp: FileStamp, reads: &mut usize) -> Result<Option<BuildRow>> {
        let read = || Ok(FileContent::OwnName(own_name(path)));
        match self.read_once(path, stamp, reads, |known| matches!(known, FileContent::OwnName(_)), read) {
            Some(FileContent::OwnName(Some(name))) => (self.find_build)(&name),
            _ => Ok(None),
        }
    }

    /// What a file holds; `None` = it cannot be read, or is for the next look.
    fn read_once(
        &self,
        path: &Path,
        stamp: FileStamp,
        reads: &mut usize,
        is_wanted: impl Fn(&FileContent) -> bool,
        read: impl FnOnce() -> io::Result<FileContent>,
    ) -> Option<FileContent> {
        if let Some(known) = self.memory.find(path, stamp).filter(is_wanted) {
            return Some(known);
        }
        *reads = reads.checked_sub(1)?;
        let content = read().ok()?;
        self.memory.keep(path, stamp, content.clone());
        Some(content)
    }
}

/// The name that a build file of a farm had when it was published, as its heading says; `None` = it is none.
pub(crate) fn own_name(file: &Path) -> Option<String> {
    let HeadingMetadata { created, profile, build_id, .. } =
        build_file::read_build_heading(file, &ReadLimits::default()).ok()?;
    Some(build_file::build_file_name(created?.parse().ok()?, &profile?, build_id?.parse().ok()?))
}

fn stamp_of(seen: &fs::Metadata) -> FileStamp {
    FileStamp {
        bytes: seen.len(),
        modified: (seen.mtime(), seen.mtime_nsec()),
        changed: (seen.ctime(), seen.ctime_nsec()),
        inode: seen.ino(),
    }
}
