//! Detects committed changes that are lost. Changes that are not yet copied into the database file exist only in its
//! write-ahead log. After a crash, SQLite replays the log up to the first invalid frame. It silently ignores the rest,
//! because after a power failure a log may end anywhere.
//!
//! Therefore the ledger counts its changes. After each commit, nestd writes the count into a note file beside the
//! ledger. The commit is fsynced, the note is not: the note may be behind the ledger, but it is ahead only if changes
//! are lost. The note is trusted only if SQLite's index of the log (`-shm`) exists. An orderly stop removes the index,
//! a crash leaves it. Without the index, somebody has replaced the ledger, or the note is from an earlier time.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use sqlx::{
    SqlitePool,
    sqlite::{SqliteConnectOptions, SqlitePoolOptions},
};

use crate::ledger::{LedgerError, error::Result};

/// Suffix of the note's file name.
pub const CHANGES_NOTED: &str = "-changes";

/// Path of a ledger's write-ahead log.
pub fn log_of(ledger: &Path) -> PathBuf {
    sidecar_path(ledger, "-wal")
}

/// Whether a file exists and is not empty.
pub fn has_content(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|meta| meta.len() > 0)
}

fn sidecar_path(ledger: &Path, suffix: &str) -> PathBuf {
    let mut name = ledger.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Writes the number of committed changes into the note. If this fails, the note stays behind, which does no harm.
pub fn note_changes(ledger: &Path, changes: i64) {
    let note = sidecar_path(ledger, CHANGES_NOTED);
    // The text always has the same length, so that it is overwritten in place.
    let text = format!("{changes:020}\n");
    let write =
        || fs::OpenOptions::new().write(true).create(true).truncate(false).open(&note)?.write_all(text.as_bytes());
    // Another user who may change the ledger created the note.
    if write().is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied) && fs::remove_file(&note).is_ok() {
        let _ = write();
    }
}

/// Removes a note that is not valid any more, before the ledger is opened.
pub fn clear_note(ledger: &Path) {
    if !sidecar_path(ledger, "-shm").exists() {
        let _ = fs::remove_file(sidecar_path(ledger, CHANGES_NOTED));
    }
}

/// Describes the changes that are known to be lost; `None` = no loss is known. The files are not changed.
pub async fn find_lost_changes(ledger: &Path) -> Result<Option<String>> {
    if !sidecar_path(ledger, "-shm").exists() {
        return Ok(None);
    }
    // The note is read before the ledger, because others may change the ledger meanwhile.
    let note = match fs::read_to_string(sidecar_path(ledger, CHANGES_NOTED)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        other => other.map_err(|source| LedgerError::Folder { path: ledger.to_owned(), source })?,
    };
    let Ok(noted) = note.trim_end().parse::<i64>() else { return Ok(None) };
    let is_log_gone = !log_of(ledger).exists();
    let lost = noted - changes_of(ledger).await?;
    Ok((lost > 0).then(|| match is_log_gone {
        true => format!("its write-ahead log (-wal) is gone, and the last changes with it: {lost} of {noted}"),
        false => format!("its write-ahead log (-wal) is damaged, and the last changes are lost: {lost} of {noted}"),
    }))
}

/// The change count of a ledger, including the changes in its log. A read-only connection does not copy the log into
/// the database file, and does not remove the log when it closes.
async fn changes_of(ledger: &Path) -> Result<i64> {
    let options = SqliteConnectOptions::new().filename(ledger).read_only(true);
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await?;
    let counted = count_of(&pool).await;
    pool.close().await;
    counted
}

async fn count_of(pool: &SqlitePool) -> Result<i64> {
    let is_counted = "SELECT count(*) FROM sqlite_schema WHERE name = 'change_count'";
    match sqlx::query_scalar::<_, i64>(is_counted).fetch_one(pool).await? {
        // The log also contained the schema change that created the count.
        0 => Ok(0),
        _ => Ok(sqlx::query_scalar("SELECT changes FROM change_count WHERE id = 1").fetch_one(pool).await?),
    }
}
