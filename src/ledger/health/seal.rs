//! The seal: the hash of the whole ledger, beside it, from an orderly stop until the next change. With it, damage of any
//! byte is noticed; SQLite keeps no checksums of its own. A backup has one too.
//!
//! Who changes the ledger breaks the seal first, and who seals does so while nobody can change it: both hold the write
//! lock. So a seal that is there is true.

use std::{
    fs::{self, File},
    io::{self, Read, Write},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use sqlx::SqlitePool;

use super::lost_changes::{holds_something, log_of};
use crate::ledger::{error::Result, place};

/// Ends the name of the seal; its content is as `b3sum` writes and checks it.
const SUFFIX: &str = ".b3";
/// Readers of other processes may keep the log from being folded in; they take milliseconds.
const ATTEMPTS: u32 = 20;
const PAUSE: Duration = Duration::from_millis(50);
/// An orderly stop has not longer than this for the seal of a large ledger; without one, the next start looks through it.
const SEAL_WITHIN: Duration = Duration::from_secs(4);
/// Bytes that are hashed between two looks at the clock.
const CHUNK_BYTES: u64 = 16 << 20;

/// What the seal says of the ledger.
#[derive(Debug, PartialEq, Eq)]
pub enum Sealed {
    /// Every byte is as it was.
    Whole,
    /// It holds other bytes than it did.
    Changed,
    /// There is no seal: the ledger is in use, or was not closed in order.
    Not,
}

/// Where the seal of a ledger is.
pub fn seal_of(ledger: &Path) -> PathBuf {
    let mut name = ledger.as_os_str().to_owned();
    name.push(SUFFIX);
    name.into()
}

/// Compares the ledger with its seal.
pub fn sealed(ledger: &Path) -> io::Result<Sealed> {
    let text = match fs::read_to_string(seal_of(ledger)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Sealed::Not),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => return Ok(Sealed::Changed),
        other => other?,
    };
    // A log beside a sealed ledger would be played into it.
    if holds_something(&log_of(ledger)) {
        return Ok(Sealed::Changed);
    }
    match hash(ledger, None) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Sealed::Changed),
        other => {
            Ok(if text.split_whitespace().next() == Some(other?.as_str()) { Sealed::Whole } else { Sealed::Changed })
        }
    }
}

/// Breaks the seal; to be called with the write lock held, before anything is written.
pub fn break_seal(ledger: &Path) -> io::Result<()> {
    match fs::remove_file(seal_of(ledger)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        // A power cut must not bring the seal back when the change stays.
        other => other.and_then(|()| File::open(place::folder(ledger))?.sync_all()),
    }
}

/// Folds the log in and seals the ledger, while nobody can write. `false` = others use it, so that it stays without a seal.
pub async fn seal(ledger: &Path, writer: &SqlitePool) -> Result<bool> {
    for _ in 0..ATTEMPTS {
        let (busy, ..): (i64, i64, i64) = sqlx::query_as("PRAGMA wal_checkpoint(TRUNCATE)").fetch_one(writer).await?;
        if busy == 0 {
            let lock = writer.begin_with("BEGIN IMMEDIATE").await?;
            // Between the two somebody may have written.
            if !holds_something(&log_of(ledger)) {
                let written = write_seal(ledger, Some(Instant::now() + SEAL_WITHIN));
                lock.rollback().await?;
                return Ok(written.is_ok());
            }
            lock.rollback().await?;
        }
        tokio::time::sleep(PAUSE).await;
    }
    Ok(false)
}

/// Writes the seal of a file that nobody changes; an error when the time is over before.
pub fn write_seal(ledger: &Path, deadline: Option<Instant>) -> io::Result<()> {
    let name = ledger.file_name().unwrap_or_default().to_string_lossy();
    let text = format!("{}  {name}\n", hash(ledger, deadline)?);
    let folder = place::folder(ledger);
    let mut file = tempfile::Builder::new().prefix(".nestd-seal-").tempfile_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(seal_of(ledger))?;
    File::open(folder)?.sync_all()
}

fn hash(file: &Path, deadline: Option<Instant>) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut file = File::open(file)?;
    loop {
        let before = hasher.count();
        hasher.update_reader((&mut file).take(CHUNK_BYTES))?;
        if hasher.count() == before {
            return Ok(hasher.finalize().to_hex().to_string());
        }
        if deadline.is_some_and(|deadline| Instant::now() > deadline) {
            return Err(io::ErrorKind::TimedOut.into());
        }
    }
}
