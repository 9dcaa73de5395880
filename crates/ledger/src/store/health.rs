//! Checks the ledger for damage before it is used. SQLite itself notices damage only in the pages that it reads and
//! then continues with the rest. A lost row could mean that a part is printed twice.
//!
//! Three things are looked at: the seal of an orderly stop ([`seal`], every byte), whether changes were lost with the write-ahead
//! log that a crash left ([`lost_changes`]), and, where no seal vouches for the file, SQLite's own check of all pages, indexes
//! and constraints.

mod checksum;
mod lost_changes;

#[cfg(test)]
mod tests;

use std::path::Path;

use sqlx::SqlitePool;

use self::checksum::{ChecksumStatus, verify_checksum};
pub use self::checksum::{checkpoint_with_checksum, checksum_path, remove_checksum, write_checksum};
use self::lost_changes::find_lost_changes;
pub use self::lost_changes::{
    CHANGES_NOTED, clear_note, has_content, note_changes, note_loss, noted_change, noted_loss,
};
use crate::{LedgerError, base::error::Result};

/// Maximum number of SQLite's error messages that are reported.
const MAX_COMPLAINTS: u32 = 3;

/// Looks at the files before the ledger is opened to be changed: what is left of a damaged write-ahead log is cleared away by
/// that. Returns whether the ledger is known to be whole, byte for byte.
pub async fn check_files(path: &Path) -> Result<bool> {
    let damaged = |what: String| LedgerError::Damaged { path: path.to_owned(), what };
    ensure_no_noted_loss(path)?;
    match verify_checksum(path) {
        Ok(ChecksumStatus::Matches) => return Ok(true),
        Ok(ChecksumStatus::Missing) => {}
        Ok(ChecksumStatus::Differs) => {
            let what =
                "it changed since nestd shut down in an orderly way, perhaps because a backup was copied over it";
            return Err(damaged(what.to_owned()));
        }
        Err(source) => return Err(LedgerError::Folder { path: path.to_owned(), source }),
    }
    find_lost_changes(path).await?.map_or(Ok(false), |what| Err(damaged(what)))
}

/// Fails if a process has found that changes are missing.
///
/// `Overwritten`.
pub fn ensure_no_noted_loss(path: &Path) -> Result<()> {
    noted_loss(path).map_or(Ok(()), |what| Err(LedgerError::Overwritten { path: path.to_owned(), what }))
}

/// Runs SQLite's check of all pages, indexes, constraints and references. Reads the whole file.
pub async fn check_database(path: &Path, pool: &SqlitePool) -> Result<()> {
    let damaged = |what: String| LedgerError::Damaged { path: path.to_owned(), what };
    let text = format!("PRAGMA integrity_check({MAX_COMPLAINTS})");
    let findings: Vec<String> = sqlx::query_scalar(sqlx::AssertSqlSafe(text)).fetch_all(pool).await?;
    if findings != ["ok"] {
        return Err(damaged(findings.join("; ").replace('\n', " ")));
    }
    let orphans =
        sqlx::query_as::<_, (String, Option<i64>)>("SELECT \"table\", rowid FROM pragma_foreign_key_check LIMIT 3");
    let orphans = orphans.fetch_all(pool).await?;
    if let Some((table, row)) = orphans.first() {
        let row = row.map(|row| row.to_string()).unwrap_or_default();
        return Err(damaged(format!("row {row} of {table} refers to a row that is not there")));
    }
    Ok(())
}
