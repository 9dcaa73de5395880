//! What the visible files in the queues hold: whether one is the proved file of its build, and whether one was copied or renamed
//! from a build file, whatever its name is. Each file is read once in this process, and again only when its stamp has changed.

use std::{
    collections::{BTreeMap, HashSet},
    fmt,
    fs::File,
    io::{self, Read},
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
};

use build_file::ReadLimits;
use delivery::queue::{FileStamp, FileState, OpenQueue, PrinterQueue, QueueAddress, is_build_name};
use ledger::{BuildRow, StagedFile};

/// How a ZIP package begins, as a 3MF file is one.
const PACKAGE: &[u8] = b"PK";

/// Bytes of the title of an STL.
const STL_TITLE_BYTES: u64 = 80;

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
            let own = if may_be_build(&file, stamp).ok()? {
                self.left = self.left.checked_sub(1)?;
                build_file::read_own_name(&file, &ReadLimits::default()).ok().flatten()
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

/// The file of a build that is looked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SoughtFile<'a> {
    /// Its name.
    pub(crate) name: &'a str,
    /// Marker of the queue folder where it was published.
    pub(crate) queue_id: Option<&'a str>,
    /// Where second files were seen, as people are told: none of these is its own.
    pub(crate) second: &'a [String],
}

impl<'a> SoughtFile<'a> {
    /// The file of a build; `None` = it was never written.
    pub(crate) fn of(build: &'a BuildRow, second: &'a [String]) -> Option<Self> {
        let StagedFile { file_name, queue_id, .. } = &build.staged;
        Some(Self { name: file_name.as_deref()?, queue_id: queue_id.as_deref(), second })
    }
}

/// A visible file that holds the copies of a build.
#[derive(Debug, Clone)]
pub(crate) struct VisibleFile {
    pub(crate) name: String,
    pub(crate) printer: String,
    pub(crate) queue: OpenQueue,
}

impl VisibleFile {
    /// Whether it is still there. A file that somebody moves while the queues are looked at, one after the other, is seen in two places.
    fn is_there(&self) -> bool {
        self.queue.stamp(&self.name).is_some()
    }
}

impl fmt::Display for VisibleFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&told_place(&self.name, &self.printer))
    }
}

/// Where a file lies, as people are told, and as the ledger keeps it: `job.3mf at left`.
pub(crate) fn told_place(name: &str, printer: &str) -> String {
    format!("{name} at {printer}")
}

/// Whether such a place is in the queue of a printer.
pub(crate) fn is_at(place: &str, printer: &str) -> bool {
    place.ends_with(&told_place("", printer))
}

/// Where the files of a build are in the queues of its machine. A queue that is away keeps nobody from looking into the others.
#[derive(Debug, Default)]
pub(crate) struct BuildFiles {
    /// Its own, under its own name.
    pub(crate) own: Option<VisibleFile>,
    /// The printer from whose queue it was taken back, where it still is, and that queue.
    pub(crate) taken_back: Option<(String, OpenQueue)>,
    /// All others that are visible.
    pub(crate) others: Vec<VisibleFile>,
}

impl BuildFiles {
    /// Looks into all queues for files of this name.
    pub(crate) fn find_named(queues: &[(String, OpenQueue)], sought: &SoughtFile<'_>) -> Self {
        let name = sought.name;
        let taken_back = queues.iter().find(|(_, queue)| queue.holds_taken_back(name)).cloned();
        let is_visible = |(_, queue): &&(String, OpenQueue)| queue.state(name).is_ok() && queue.stamp(name).is_some();
        let mut others: Vec<VisibleFile> =
            queues.iter().filter(is_visible).map(|named| visible_file(name, named)).collect();
        if others.len() > 1 {
            others.retain(VisibleFile::is_there);
        }
        // Where it was published, or else the first.
        others.sort_by_key(|file| Some(file.queue.id()) != sought.queue_id);
        let own = others.iter().position(|file| !sought.second.contains(&file.to_string()));
        let own = own.map(|own| others.remove(own));
        Self { own, taken_back, others }
    }

    /// The same, and looks for its copies under other names.
    pub(crate) fn find(queues: &[(String, OpenQueue)], sought: &SoughtFile<'_>) -> Self {
        let (name, mut reader) = (sought.name, ContentReader::new(usize::MAX));
        let mut found = Self::find_named(queues, sought);
        for named in queues {
            let queue = &named.1;
            let names = queue.names(FileState::Visible).unwrap_or_default();
            let copies = names.into_iter().filter(|other| other != name).filter(|other| {
                let stamp = queue.stamp(other);
                stamp.is_some_and(|stamp| reader.own_name(&**queue, other, stamp).as_deref() == Some(name))
            });
            found.others.extend(copies.map(|other| visible_file(&other, named)));
        }
        if !found.others.is_empty() {
            found.own = found.own.filter(VisibleFile::is_there);
            found.others.retain(VisibleFile::is_there);
        }
        found
    }

    /// Where all but its own are, as people are told.
    pub(crate) fn other_places(&self) -> Vec<String> {
        self.others.iter().map(ToString::to_string).collect()
    }
}

fn visible_file(name: &str, (printer, queue): &(String, OpenQueue)) -> VisibleFile {
    VisibleFile { name: name.to_owned(), printer: printer.clone(), queue: queue.clone() }
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

/// Whether a file may be a build, as its beginning tells: of an STL, the title.
fn may_be_build(file: &Path, stamp: FileStamp) -> io::Result<bool> {
    let mut start = Vec::new();
    File::open(file)?.take(STL_TITLE_BYTES).read_to_end(&mut start)?;
    let title = String::from_utf8_lossy(&start);
    let is_titled = stamp.bytes > STL_TITLE_BYTES && is_build_name(title.trim_end_matches('\0'));
    Ok(start.starts_with(PACKAGE) || is_titled)
}
