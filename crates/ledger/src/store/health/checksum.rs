//! The checksum file: the hash of the whole ledger, stored beside it from an orderly shutdown until the next change. It
//! reveals damage of any byte; SQLite itself has no checksums. A backup has a checksum file too.
//!
//! Every change removes the checksum file before it writes, and the checksum is written only while no change is
//! possible. Both hold the write lock. So an existing checksum file is always valid.

use std::{
    fs::{self, File},
    io::{self, Read, Write},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use sqlx::SqlitePool;

use super::lost_changes::{has_content, log_of};
use crate::{base::error::Result, store::location};

/// Suffix of the checksum file. Its content has the format of `b3sum`.
const CHECKSUM_SUFFIX: &str = ".b3";
/// Number of attempts to fold the write-ahead log into the ledger. Readers in other processes may block it, for
/// milliseconds.
const ATTEMPTS: u32 = 20;
const PAUSE: Duration = Duration::from_millis(50);
/// Time limit for the checksum of a large ledger during an orderly shutdown. Without a checksum, the next start checks
/// the ledger instead.
const CHECKSUM_TIME_LIMIT: Duration = Duration::from_secs(4);
/// Number of bytes hashed between two checks of the time limit.
const CHUNK_BYTES: u64 = 16 << 20;

/// Result of comparing the ledger with its checksum.
#[derive(Debug, PartialEq, Eq)]
pub enum ChecksumStatus {
    /// Every byte is unchanged.
    Matches,
    /// The bytes differ.
    Differs,
    /// There is no checksum: the ledger is in use, or was not closed in an orderly way.
    Missing,
}

/// Path of the checksum file of a ledger.
pub fn checksum_path(ledger: &Path) -> PathBuf {
    let mut name = ledger.as_os_str().to_owned();
    name.push(CHECKSUM_SUFFIX);
    name.into()
}

/// Compares the ledger with its checksum.
pub fn verify_checksum(ledger: &Path) -> io::Result<ChecksumStatus> {
    let text = match fs::read_to_string(checksum_path(ledger)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(ChecksumStatus::Missing),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => return Ok(ChecksumStatus::Differs),
        other => other?,
    };
    // SQLite would apply a write-ahead log that is beside the ledger, although the checksum does not cover it.
    if has_content(&log_of(ledger)) {
        return Ok(ChecksumStatus::Differs);
    }
    match hash_until(ledger, None) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(ChecksumStatus::Differs),
        other => Ok(if text.split_whitespace().next() == Some(other?.as_str()) {
            ChecksumStatus::Matches
        } else {
            ChecksumStatus::Differs
        }),
    }
}

/// Removes the checksum file. Call this with the write lock held, before anything is written.
pub fn remove_checksum(ledger: &Path) -> io::Result<()> {
    match fs::remove_file(checksum_path(ledger)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        // A power cut must not restore the checksum file while the change stays.
        other => other.and_then(|()| File::open(location::parent_folder(ledger))?.sync_all()),
    }
}

/// Folds the write-ahead log into the ledger and writes the checksum while nobody can write. Returns `false` if other
/// processes use the ledger, so it stays without a checksum.
pub async fn checkpoint_with_checksum(ledger: &Path, writer: &SqlitePool) -> Result<bool> {
    for _ in 0..ATTEMPTS {
        let (busy, ..): (i64, i64, i64) = sqlx::query_as("PRAGMA wal_checkpoint(TRUNCATE)").fetch_one(writer).await?;
        if busy == 0 {
            let lock = writer.begin_with("BEGIN IMMEDIATE").await?;
            // Another process may have written between the checkpoint and the lock.
            if !has_content(&log_of(ledger)) {
                let written = write_checksum(ledger, Some(Instant::now() + CHECKSUM_TIME_LIMIT));
                lock.rollback().await?;
                return Ok(written.is_ok());
            }
            lock.rollback().await?;
        }
        tokio::time::sleep(PAUSE).await;
    }
    Ok(false)
}

/// Writes the checksum of a file that nobody changes. It is an error if the deadline passes first.
pub fn write_checksum(ledger: &Path, deadline: Option<Instant>) -> io::Result<()> {
    let name = ledger.file_name().unwrap_or_default().to_string_lossy();
    let text = format!("{}  {name}\n", hash_until(ledger, deadline)?);
    let folder = location::parent_folder(ledger);
    let mut file = tempfile::Builder::new().prefix(".nestd-seal-").tempfile_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(checksum_path(ledger))?;
    File::open(folder)?.sync_all()
}

fn hash_until(file: &Path, deadline: Option<Instant>) -> io::Result<String> {
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
