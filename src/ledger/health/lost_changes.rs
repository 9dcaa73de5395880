//! Changes that were committed and are gone. What is not folded into the database stands only in its write-ahead log; after a
//! crash SQLite replays the log up to the first frame that does not fit and forgets the rest without a word, as a log that a
//! power cut ended may end anywhere.
//!
//! So the ledger counts its changes, and after each commit the count is noted in a file beside it. The note is not fsynced, the
//! commit is: the note may be behind the ledger, but it is ahead of it only when changes are lost. It is believed only beside
//! SQLite's index of the log (`-shm`), which an orderly stop removes and a crash leaves: without one, somebody put another
//! ledger in place, or the note is of an earlier time.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use sqlx::{
    SqliteConnection, SqlitePool,
    sqlite::{SqliteConnectOptions, SqlitePoolOptions},
};

use crate::ledger::{LedgerError, error::Result};

/// Ends the name of the note.
pub const CHANGES_NOTED: &str = "-changes";

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

/// Counts a change that is about to be committed; returns how many that makes.
pub async fn count_change(db: &mut SqliteConnection) -> Result<i64> {
    let count = sqlx::query_scalar("UPDATE change_count SET changes = changes + 1 WHERE id = 1 RETURNING changes");
    Ok(count.fetch_one(db).await?)
}

/// Notes how many changes are committed. Where it cannot be written the note stays behind, which does no harm.
pub fn note_changes(ledger: &Path, changes: i64) {
    let note = beside(ledger, CHANGES_NOTED);
    // Always as long, so that it is overwritten in place.
    let text = format!("{changes:020}\n");
    let write =
        || fs::OpenOptions::new().write(true).create(true).truncate(false).open(&note)?.write_all(text.as_bytes());
    // Another user who may change the ledger made it.
    if write().is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied) && fs::remove_file(&note).is_ok() {
        let _ = write();
    }
}

/// Removes a note that does not count any more, before the ledger is opened.
pub fn clear_note(ledger: &Path) {
    if !beside(ledger, "-shm").exists() {
        let _ = fs::remove_file(beside(ledger, CHANGES_NOTED));
    }
}

/// What is known to be lost of the changes, in words; `None` = nothing is known to be. The files stay as they are.
pub async fn find_lost_changes(ledger: &Path) -> Result<Option<String>> {
    if !beside(ledger, "-shm").exists() {
        return Ok(None);
    }
    // It is read first: others may change the ledger meanwhile.
    let note = match fs::read_to_string(beside(ledger, CHANGES_NOTED)) {
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

/// How many changes a ledger counts, with those in its log. A connection that only reads does not fold the log in and does not
/// remove it at its end.
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
        // The schema that counts was in the log, too.
        0 => Ok(0),
        _ => Ok(sqlx::query_scalar("SELECT changes FROM change_count WHERE id = 1").fetch_one(pool).await?),
    }
}
