//! The write-ahead log after a crash. Commits that are not folded into the database stand only there; SQLite replays it up to
//! the first frame that does not fit and forgets the rest without a word, as a log that a power cut ended may end anywhere.
//! But its index beside it (`-shm`) still says how far the last commit reached, as long as the machine was not rebooted.
//!
//! Formats: <https://www.sqlite.org/fileformat2.html#walformat>, <https://www.sqlite.org/walformat.html>.

use std::{
    fs::{self, File},
    io::{self, BufReader, Read},
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

/// Version in the index.
const INDEX_VERSION: u32 = 3_007_000;
/// Bytes of one of the two copies of the index's header.
const HEADER: usize = 48;
/// Where the index says how much is folded in.
const FOLDED_AT: usize = 96;
/// Bytes before the first frame, and before each page.
const LOG_HEADER: usize = 32;
const FRAME_HEADER: usize = 24;

/// The log of a ledger.
pub fn log_of(ledger: &Path) -> PathBuf {
    beside(ledger, "-wal")
}

/// Whether a file is there and holds something.
pub fn holds_something(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|meta| meta.len() > 0)
}

fn beside(ledger: &Path, suffix: &str) -> PathBuf {
    let mut name = ledger.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// What is known to be lost of the log, in words; `None` = nothing is known to be.
pub fn lost(ledger: &Path) -> io::Result<Option<String>> {
    let index_file = beside(ledger, "-shm");
    let index = match fs::read(&index_file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        other => other?,
    };
    let Some(index) = Index::read(&index).filter(|index| index.frames > index.folded) else { return Ok(None) };
    if is_from_before_this_boot(&index_file)? {
        return Ok(None);
    }
    let log = match File::open(log_of(ledger)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(Some("its write-ahead log (-wal) is gone, and the last changes with it".to_owned()));
        }
        other => other?,
    };
    let whole = whole_frames(BufReader::new(log), &index)?;
    Ok((whole < index.frames).then(|| {
        let (have, had) = (whole, index.frames);
        format!("its write-ahead log (-wal) is damaged: {have} of {had} pages are whole, and the last changes are lost")
    }))
}

/// The index as its last commit left it.
#[derive(Debug, PartialEq, Eq)]
struct Index {
    page_bytes: usize,
    /// Frames of the log that are committed.
    frames: u32,
    /// Those of them that are in the database already.
    folded: u32,
    salts: [u8; 8],
    is_big_endian: bool,
}

impl Index {
    /// `None` when it says nothing for certain: it was never used, or a crash caught it between its two copies.
    fn read(bytes: &[u8]) -> Option<Self> {
        let (one, other) = (bytes.get(..HEADER)?, bytes.get(HEADER..2 * HEADER)?);
        let word = |at: usize| Some(u32::from_ne_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
        let is_whole = checksum((0, 0), &one[..40], u32::from_ne_bytes) == (word(40)?, word(44)?);
        if one != other || !is_whole || word(0)? != INDEX_VERSION || one[12] == 0 {
            return None;
        }
        let page = u16::from_ne_bytes([one[14], one[15]]);
        Some(Self {
            page_bytes: if page == 1 { 65_536 } else { usize::from(page) },
            frames: word(16)?,
            folded: word(FOLDED_AT)?,
            salts: one[32..40].try_into().ok()?,
            is_big_endian: one[13] != 0,
        })
    }
}

/// How many frames of the log are whole, each with all before it; as many as asked for a log that was begun anew since.
fn whole_frames(mut log: impl Read, index: &Index) -> io::Result<u32> {
    let mut header = [0; LOG_HEADER];
    if !read_all(&mut log, &mut header)? {
        return Ok(0);
    }
    let big = |at: usize, bytes: &[u8]| u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let word = if index.is_big_endian { u32::from_be_bytes } else { u32::from_le_bytes };
    let mut sum = checksum((0, 0), &header[..24], word);
    if sum != (big(24, &header), big(28, &header)) {
        return Ok(0);
    }
    if header[16..24] != index.salts {
        // The first salt is counted up whenever the log, all of it folded in, is begun anew.
        let is_newer = big(16, &header).wrapping_sub(big(0, &index.salts)) as i32 > 0;
        return Ok(if is_newer { index.frames } else { 0 });
    }
    let mut frame = vec![0; FRAME_HEADER + index.page_bytes];
    for whole in 0..index.frames {
        if !read_all(&mut log, &mut frame)? || frame[8..16] != index.salts {
            return Ok(whole);
        }
        sum = checksum(checksum(sum, &frame[..8], word), &frame[FRAME_HEADER..], word);
        if sum != (big(16, &frame), big(20, &frame)) {
            return Ok(whole);
        }
    }
    Ok(index.frames)
}

/// SQLite's checksum of the log, over pairs of words.
fn checksum((mut a, mut b): (u32, u32), bytes: &[u8], word: fn([u8; 4]) -> u32) -> (u32, u32) {
    for pair in bytes.chunks_exact(8) {
        a = a.wrapping_add(word([pair[0], pair[1], pair[2], pair[3]])).wrapping_add(b);
        b = b.wrapping_add(word([pair[4], pair[5], pair[6], pair[7]])).wrapping_add(a);
    }
    (a, b)
}

/// Fills the buffer; `false` = the file ends before.
fn read_all(from: &mut impl Read, buffer: &mut [u8]) -> io::Result<bool> {
    match from.read_exact(buffer) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        other => other.map(|()| true),
    }
}

/// The index is memory of the kernel, not fsynced: after a reboot it may be older than the log.
fn is_from_before_this_boot(index: &Path) -> io::Result<bool> {
    let up = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
    let up = Duration::from_secs(u64::try_from(up.tv_sec).unwrap_or(0));
    let boot = SystemTime::now().checked_sub(up).unwrap_or(SystemTime::UNIX_EPOCH);
    Ok(fs::metadata(index)?.modified()? < boot)
}
