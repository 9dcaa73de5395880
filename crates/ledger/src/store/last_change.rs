//! Detects that a ledger was overwritten inside its file while it is open, as `sqlite3 nestd.db ".restore BACKUP"` does through SQLite's
//! backup interface: the file is the same, and what it holds has gone back in time. Each change counts; of what a process has seen last,
//! nothing may be missing. The changes of other processes only add to the count.

use std::sync::{Mutex, PoisonError};

use sqlx::{SqliteConnection, SqliteExecutor};

use crate::base::sqlite_code::{SQLITE_ERROR, sqlite_code};

/// The last change of a ledger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LastChange {
    /// Random number of the ledger.
    pub line: i64,
    /// How many changes were made.
    pub changes: i64,
    /// Random number of this one; `None` = it is known from the note beside the ledger.
    stamp: Option<i64>,
}

/// The last change that this process has seen.
#[derive(Debug, Default)]
pub struct LastChangeSeen(Mutex<Option<LastChange>>);

impl LastChangeSeen {
    /// Compares the last change of the ledger with the one that was seen. Returns what is wrong, if anything is.
    pub async fn find_loss(&self, db: impl SqliteExecutor<'_>) -> Result<Option<String>, sqlx::Error> {
        // Before the query: another connection of this process may commit a change meanwhile.
        let seen = *self.lock();
        let last = sqlx::query_as("SELECT line, changes, stamp FROM change_count WHERE id = 1").fetch_optional(db);
        let found = match last.await {
            // Another database, or a ledger of an older nestd.
            Err(error) if sqlite_code(&error) == Some(SQLITE_ERROR) => None,
            other => other?.map(LastChange::of_columns),
        };
        let loss = seen.and_then(|seen| describe_loss(seen, found));
        if let (None, Some(found)) = (&loss, found) {
            self.record(found);
        }
        Ok(loss)
    }

    /// Records a change that is in the ledger.
    pub fn record(&self, change: LastChange) {
        let mut seen = self.lock();
        if seen.is_none_or(|seen| seen.changes < change.changes) {
            *seen = Some(change);
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<LastChange>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Counts a change that is about to be committed.
pub async fn count_change(db: &mut SqliteConnection) -> Result<LastChange, sqlx::Error> {
    let count = sqlx::query_as(
        "UPDATE change_count SET changes = changes + 1, stamp = random() WHERE id = 1 RETURNING line, changes, stamp",
    );
    Ok(LastChange::of_columns(count.fetch_one(db).await?))
}

impl LastChange {
    fn of_columns((line, changes, stamp): (i64, i64, i64)) -> Self {
        Self { line, changes, stamp: Some(stamp) }
    }

    /// One that is noted beside the ledger.
    pub fn noted(line: i64, changes: i64) -> Self {
        Self { line, changes, stamp: None }
    }
}

fn describe_loss(seen: LastChange, found: Option<LastChange>) -> Option<String> {
    match found {
        None => Some("it holds no ledger of this nestd any more".to_owned()),
        Some(found) if found.line == seen.line && found.changes >= seen.changes => {
            let is_other = found.changes == seen.changes && seen.stamp.is_some_and(|seen| found.stamp != Some(seen));
            is_other.then(|| format!("its change {} is another one than this nestd has seen", seen.changes))
        }
        Some(found) if found.changes < seen.changes => Some(format!(
            "it was put back to an earlier time inside its file: it counts {} changes, and this nestd has seen {}",
            found.changes, seen.changes
        )),
        Some(_) => Some("another ledger was written into its file".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_of_others_are_no_loss_and_whatever_was_seen_must_be_there() {
        let seen = LastChange { line: 7, changes: 20, stamp: Some(3) };
        for same in [seen, LastChange { changes: 21, stamp: Some(9), ..seen }, LastChange { changes: 900, ..seen }] {
            assert_eq!(describe_loss(seen, Some(same)), None);
            assert_eq!(describe_loss(LastChange::noted(7, 20), Some(same)), None);
        }
        for (found, said) in [
            (None, "holds no ledger"),
            (Some(LastChange { changes: 19, ..seen }), "counts 19 changes, and this nestd has seen 20"),
            (Some(LastChange { stamp: Some(4), ..seen }), "its change 20 is another one"),
            (Some(LastChange { line: 8, changes: 21, ..seen }), "another ledger"),
            (Some(LastChange { line: 8, changes: 2, ..seen }), "counts 2 changes"),
        ] {
            assert!(describe_loss(seen, found).unwrap().contains(said), "{found:?}");
        }
    }
}
