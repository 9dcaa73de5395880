//! Detects committed changes that are lost. Changes that are not yet copied into the database file exist only in its
//! write-ahead log. After a crash, SQLite replays the log up to the first invalid frame. It silently ignores the rest,
//! because after a power failure a log may end anywhere. Changes are lost, too, when somebody writes an earlier state into the file of
//! an open ledger.
//!
//! Therefore the ledger counts its changes. After each commit, nestd writes the count and the line into a note file beside the
//! ledger. The commit is fsynced, the note is not: the note may be behind the ledger, but it is ahead only if changes
//! are lost. The note is trusted only if SQLite's index of the log (`-shm`) exists. An orderly stop removes the index,
//! a crash leaves it. Without the index, somebody has replaced the ledger, or the note is from an earlier time.
//!
//! A process that finds that its changes are missing writes so into the note. From then on no process uses the ledger, until another one
//! is put in its place, which removes the note.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use sqlx::{
    SqlitePool,
    sqlite::{SqliteConnectOptions, SqlitePoolOptions},
};

use crate::{LedgerError, base::error::Result, store::last_change::LastChange};

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

/// Writes the last committed change into the note. If this fails, the note stays behind, which does no harm.
pub fn note_changes(ledger: &Path, last: LastChange) {
    let note = sidecar_path(ledger, CHANGES_NOTED);
    let LastChange { line, changes, .. } = last;
    // The text always has the same length, so that it is overwritten in place.
    let text = format!("{changes:020} {line:+020}\n");
    let write =
        || fs::OpenOptions::new().write(true).create(true).truncate(false).open(&note)?.write_all(text.as_bytes());
    // Another user who may change the ledger created the note.
    if write().is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied) && fs::remove_file(&note).is_ok() {
        let _ = write();
    }
}

/// Writes into the note that changes are missing, and which.
pub fn note_loss(ledger: &Path, loss: &str) {
    let note = sidecar_path(ledger, CHANGES_NOTED);
    let text = fs::read_to_string(&note).unwrap_or_default();
    let _ = fs::write(&note, format!("{}\n{}\n", text.lines().next().unwrap_or_default(), loss.replace('\n', " ")));
}

/// What a process has found to be missing in a ledger.
pub fn noted_loss(ledger: &Path) -> Option<String> {
    let note = fs::read_to_string(sidecar_path(ledger, CHANGES_NOTED)).ok()?;
    note.lines().nth(1).filter(|loss| !loss.is_empty()).map(str::to_owned)
}

/// The last change that the note of a ledger in use tells.
pub fn noted_change(ledger: &Path) -> Option<LastChange> {
    let note = fs::read_to_string(sidecar_path(ledger, CHANGES_NOTED)).ok()?;
    let (changes, line) = note.lines().next()?.split_once(' ')?;
    Some(LastChange::noted(line.parse().ok()?, changes.parse().ok()?))
}

/// Removes a note that is not valid any more, before the ledger is opened.
pub fn clear_note(ledger: &Path) {
    if !sidecar_path(ledger, "-shm").exists() && noted_loss(ledger).is_none() {
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
    // An older nestd wrote the number alone.
    let Some(noted) = note.split_whitespace().next().and_then(|changes| changes.parse::<i64>().ok()) else {
        return Ok(None);
    };
    let is_log_gone = !log_of(ledger).exists();
    let lost = noted - changes_of(ledger).await?;
    Ok((lost > 0).then(|| match is_log_gone {
        true => format!("its write-ahead log (-wal) is gone, and the last changes with it: {lost} of {noted}"),
        false => format!(
            "its write-ahead log (-wal) is damaged, or an earlier state was written into its file, and the last changes are lost: {lost} \
             of {noted}"
        ),
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
