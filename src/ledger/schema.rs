//! The schema: migrations that are part of the binary. One that was released is never edited.

use std::path::Path;

use sqlx::{
    SqlitePool,
    migrate::{MigrateError, Migrator},
};

use super::{LedgerError, error::Result};

pub(super) static MIGRATIONS: Migrator = sqlx::migrate!();

/// The newest schema that this binary knows.
pub(super) fn known() -> i64 {
    MIGRATIONS.iter().map(|m| m.version).max().unwrap_or(0)
}

/// Applies the missing migrations, all or none. Two daemons that start at once wait for each other: the second one
/// finds the work done.
pub async fn bring_up_to_date(path: &Path, writer: &SqlitePool) -> Result<()> {
    let mut transaction = writer.begin_with("BEGIN IMMEDIATE").await?;
    super::health::break_seal(path).map_err(|source| LedgerError::Folder { path: path.to_owned(), source })?;
    let applied = MIGRATIONS.run_direct(None, &mut *transaction, false).await;
    match applied {
        Ok(()) => Ok(transaction.commit().await?),
        Err(MigrateError::VersionMissing(_)) => {
            drop(transaction);
            demand(path, writer).await
        }
        Err(error) => Err(LedgerError::Migrate { path: path.to_owned(), error }),
    }
}

/// Demands exactly the schema of this binary.
pub async fn demand(path: &Path, writer: &SqlitePool) -> Result<()> {
    let failed = |error| LedgerError::Open { path: path.to_owned(), error };
    let is_ledger = "SELECT count(*) FROM sqlite_schema WHERE name = '_sqlx_migrations'";
    let found: i64 = match sqlx::query_scalar::<_, i64>(is_ledger).fetch_one(writer).await.map_err(failed)? {
        0 => 0,
        _ => sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations")
            .fetch_one(writer)
            .await
            .map_err(failed)?,
    };
    let (path, known) = (path.to_owned(), known());
    match found.cmp(&known) {
        std::cmp::Ordering::Less => Err(LedgerError::OlderSchema { path, found, known }),
        std::cmp::Ordering::Equal => Ok(()),
        std::cmp::Ordering::Greater => Err(LedgerError::NewerSchema { path, found, known }),
    }
}
