//! What the visible files in the queues hold: whether one is the proved file of its build, and whether one was copied or renamed
//! from a build file, whatever its name is. Each file is read once in this process, and again only when its stamp has changed.

use std::{
    collections::{BTreeMap, HashSet},
    fs::File,
    io::{self, Read},
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
};

use build_file::{HeadingMetadata, ReadLimits};
use ledger::BuildRow;

use crate::queue::{FileStamp, FileState, OpenQueue, PrinterQueue, QueueAddress};

/// How a ZIP package begins, as a 3MF file is one.
const PACKAGE: &[u8] = b"PK";

/// What was read of a file.
#[derive(Debug, Clone)]
struct FileContent {
    stamp: FileStamp,
    /// BLAKE3 of all of it.
    hash: Option<String>,
    /// The name that the build file had whose heading it has; inside, `None` = it is none of a farm.
    own_name: Option<Option<String>>,
}

/// A visible file: its queue, and its name there.
type FilePlace = (QueueAddress, String);

fn place_of(queue: &dyn PrinterQueue, name: &str) -> FilePlace {
    (queue.address().clone(), name.to_owned())
}

impl FileContent {
    /// What was read of the file with this stamp.
    fn known(place: &FilePlace, stamp: FileStamp) -> Self {
        let known = known_contents().get(place).filter(|known| known.stamp == stamp).cloned();
        known.unwrap_or(Self { stamp, hash: None, own_name: None })
    }
}

/// What was read of the files in queues.
static CONTENTS: Mutex<BTreeMap<FilePlace, FileContent>> = Mutex::new(BTreeMap::new());

/// Reads visible files, of which one look reads a limited number: after a start, the others are for the next looks.
#[derive(Debug)]
pub(crate) struct ContentReader {
    /// Number of files that are still to be read.
    left: usize,
}

impl ContentReader {
    /// A reader that reads so many files.
    pub(crate) fn new(most: usize) -> Self {
        Self { left: most }
    }

    /// BLAKE3 of a file; `None` = it cannot be read, or is for the next look.
    pub(crate) fn hash(&mut self, queue: &dyn PrinterQueue, name: &str, stamp: FileStamp) -> Option<String> {
        let place = place_of(queue, name);
        let mut known = FileContent::known(&place, stamp);
        if known.hash.is_none() {
            self.left = self.left.checked_sub(1)?;
            known.hash = Some(intake::hash_file(&queue.file(name, FileState::Visible).ok()?).ok()?);
            known_contents().insert(place, known.clone());
        }
        known.hash
    }

    /// The name that a file had when it was published as a build, as its heading says; `None` = it is no such file, cannot be read, or is
    /// for the next look.
    pub(crate) fn own_name(&mut self, queue: &dyn PrinterQueue, name: &str, stamp: FileStamp) -> Option<String> {
        if !stamp.is_file {
            return None;
        }
        let place = place_of(queue, name);
        let mut known = FileContent::known(&place, stamp);
        if known.own_name.is_none() {
            let file = queue.file(name, FileState::Visible).ok()?;
            let own = if starts_as_package(&file).ok()? {
                self.left = self.left.checked_sub(1)?;
                read_own_name(&file)
            } else {
                None
            };
            known.own_name = Some(own);
            known_contents().insert(place, known.clone());
        }
        known.own_name.flatten()
    }
}

fn known_contents() -> MutexGuard<'static, BTreeMap<FilePlace, FileContent>> {
    CONTENTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The file is read again at the next look.
pub(crate) fn forget(queue: &dyn PrinterQueue, name: &str) {
    known_contents().remove(&place_of(queue, name));
}

/// Nothing more is known of files of a queue that are not there any more.
pub(crate) fn forget_others(queue: &dyn PrinterQueue, names: &[String]) {
    let names: HashSet<&String> = names.iter().collect();
    known_contents().retain(|(address, name), _| address != queue.address() || names.contains(name));
}

/// Where the copies of a build lie visible in the queues of its machine.
#[derive(Debug, Default)]
pub(crate) struct VisibleFiles {
    /// The printer in whose queue its file lies under its own name, and that queue.
    pub(crate) own: Option<(String, OpenQueue)>,
    /// All others, under that name or any other, as people are told: `job.3mf at left`.
    pub(crate) others: Vec<String>,
}

impl VisibleFiles {
    /// Looks into all queues of the machine of a build for the file of this name. `queue_id` = the queue where it was published. A queue
    /// that is away keeps nobody from looking into the others.
    pub(crate) fn find(queues: &[(String, OpenQueue)], name: &str, queue_id: Option<&str>) -> Self {
        let mut reader = ContentReader::new(usize::MAX);
        let (mut found, mut named) = (Self::default(), Vec::new());
        for (printer, queue) in queues {
            if matches!(queue.state(name), Ok(FileState::Visible)) {
                named.push((printer, queue));
            }
            let names = queue.names(FileState::Visible).unwrap_or_default();
            let copies = names.into_iter().filter(|other| other != name).filter(|other| {
                let stamp = queue.stamp(other);
                stamp.is_some_and(|stamp| reader.own_name(&**queue, other, stamp).as_deref() == Some(name))
            });
            found.others.extend(copies.map(|other| format!("{other} at {printer}")));
        }
        // Where it was published, or else the first.
        named.sort_by_key(|(_, queue)| Some(queue.id()) != queue_id);
        let mut named = named.into_iter();
        found.own = named.next().map(|(printer, queue)| (printer.clone(), queue.clone()));
        found.others.extend(named.map(|(printer, _)| format!("{name} at {printer}")));
        found
    }
}

/// Whether a visible file is the one that was proved as a build, as far as it was read.
pub(crate) fn is_proved(
    build: &BuildRow,
    (queue, name, stamp): (&dyn PrinterQueue, &str, FileStamp),
    reader: &mut ContentReader,
) -> bool {
    if !stamp.is_file || build.staged.file_bytes.is_some_and(|bytes| bytes != stamp.bytes) {
        return false;
    }
    match (reader.hash(queue, name, stamp), &build.staged.file_hash) {
        (Some(found), Some(proved)) => found == *proved,
        _ => true,
    }
}

fn starts_as_package(file: &Path) -> io::Result<bool> {
    let mut start = Vec::new();
    File::open(file)?.take(PACKAGE.len() as u64).read_to_end(&mut start)?;
    Ok(start == PACKAGE)
}

fn read_own_name(file: &Path) -> Option<String> {
    let HeadingMetadata { created, machine, build_id, .. } =
        build_file::read_build_heading(file, &ReadLimits::default()).ok()?;
    Some(build_file::build_file_name(created?.parse().ok()?, &machine?, build_id?.parse().ok()?))
}
