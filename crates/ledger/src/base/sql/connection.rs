//! Connections to one of the two databases.

use sqlx::{PgConnection, PgPool, Postgres};
use sqlx::{Sqlite, SqliteConnection, SqlitePool, Transaction};

use crate::{ServerError, base::error::Result};

/// A transaction. Dropping it rolls everything back.
#[derive(Debug)]
pub enum SqlTransaction {
    /// Of SQLite.
    Sqlite(Transaction<'static, Sqlite>),
    /// Of PostgreSQL.
    Postgres(Transaction<'static, Postgres>),
}

/// Limits of a transaction that reads or writes all rows: a backup, a copy, a check, a migration. Others have shorter ones.
const OF_WHOLE_LEDGER: &str =
    "SET LOCAL statement_timeout = '6h'; SET LOCAL idle_in_transaction_session_timeout = '10min'";

/// Has a transaction last as long as a transfer of all rows takes.
pub async fn allow_whole_ledger(db: &mut PgConnection) -> Result<()> {
    let allowed = sqlx::raw_sql(OF_WHOLE_LEDGER).execute(db).await;
    Ok(allowed.map(drop).map_err(ServerError::mark_unreachable)?)
}

impl SqlTransaction {
    /// Has it last as long as a transfer of all rows takes. A file has no such limit.
    pub async fn allow_whole_ledger(&mut self) -> Result<()> {
        match self {
            Self::Sqlite(_) => Ok(()),
            Self::Postgres(transaction) => allow_whole_ledger(transaction).await,
        }
    }
}

/// Where a statement runs.
pub enum SqlExecutor<'c> {
    /// On any connection of these to SQLite.
    SqlitePool(&'c SqlitePool),
    /// In a transaction of SQLite.
    Sqlite(&'c mut SqliteConnection),
    /// On any connection of these to PostgreSQL.
    PostgresPool(&'c PgPool),
    /// In a transaction of PostgreSQL.
    Postgres(&'c mut PgConnection),
}

impl<'c> From<&'c mut SqlTransaction> for SqlExecutor<'c> {
    fn from(transaction: &'c mut SqlTransaction) -> Self {
        match transaction {
            SqlTransaction::Sqlite(transaction) => Self::Sqlite(transaction),
            SqlTransaction::Postgres(transaction) => Self::Postgres(transaction),
        }
    }
}
