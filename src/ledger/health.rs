//! Whether the ledger is whole, before anything is done with it. SQLite itself notices damage only where it happens to
//! look, and then goes on with the rest: a lost row is a part printed twice.
//!
//! Three things are looked at: the seal of an orderly stop ([`seal`], every byte), whether changes were lost with the write-ahead
//! log that a crash left ([`lost_changes`]), and, where no seal vouches for the file, SQLite's own check of all pages, indexes
//! and constraints.

mod lost_changes;
mod seal;

#[cfg(test)]
mod tests;

use std::path::Path;

use sqlx::SqlitePool;

use self::lost_changes::find_lost_changes;
pub use self::lost_changes::{CHANGES_NOTED, clear_note, count_change, holds_something, note_changes};
use self::seal::{Sealed, sealed};
pub use self::seal::{break_seal, seal, seal_of, write_seal};
use super::{LedgerError, error::Result};

/// So many complaints of SQLite are told at most.
const MAX_COMPLAINTS: u32 = 3;

/// Looks at the files before the ledger is opened to be changed: what is left of a damaged write-ahead log is cleared away by
/// that. Returns whether the ledger is known to be whole, byte for byte.
pub async fn look_at_files(path: &Path) -> Result<bool> {
    let damaged = |what: String| LedgerError::Damaged { path: path.to_owned(), what };
    match sealed(path) {
        Ok(Sealed::Whole) => return Ok(true),
        Ok(Sealed::Not) => {}
        Ok(Sealed::Changed) => {
            let what = "it is not as nestd left it when it stopped in order";
            return Err(damaged(what.to_owned()));
        }
        Err(source) => return Err(LedgerError::Folder { path: path.to_owned(), source }),
    }
    find_lost_changes(path).await?.map_or(Ok(false), |what| Err(damaged(what)))
}

/// SQLite's check of every page, index, constraint and reference; reads the whole file.
pub async fn check_all(path: &Path, pool: &SqlitePool) -> Result<()> {
    let damaged = |what: String| LedgerError::Damaged { path: path.to_owned(), what };
    let text = format!("PRAGMA integrity_check({MAX_COMPLAINTS})");
    let said: Vec<String> = sqlx::query_scalar(sqlx::AssertSqlSafe(text)).fetch_all(pool).await?;
    if said != ["ok"] {
        return Err(damaged(said.join("; ").replace('\n', " ")));
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
