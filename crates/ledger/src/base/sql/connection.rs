//! Connections to one of the two databases.

use std::{io, time::Duration};

use sqlx::{PgConnection, PgPool, Postgres};
use sqlx::{Sqlite, SqliteConnection, SqlitePool, Transaction};

use crate::{ServerError, base::error::Result};

/// A transaction. Dropping it rolls everything back.
#[derive(Debug)]
pub enum SqlTransaction {
    /// Of SQLite.
    Sqlite(Transaction<'static, Sqlite>),
    /// Of PostgreSQL, and within what time each of its statements is answered.
    Postgres(Transaction<'static, Postgres>, Duration),
}

/// Limits of a transaction that reads or writes all rows: a backup, a copy, a check, a migration. Others have shorter ones.
const OF_WHOLE_LEDGER: &str =
    "SET LOCAL statement_timeout = '6h'; SET LOCAL idle_in_transaction_session_timeout = '10min'";

/// The same for whoever waits for the answer.
const WHOLE_LEDGER_ANSWERED: Duration = Duration::from_secs(6 * 3600 + 60);

/// Waits for the answer of a server. A link that has fallen silent tells neither side: the network drops packets, or a firewall has
/// forgotten the connection. Then the work ends with an error after `limit`.
pub async fn answered_within<T, E: From<sqlx::Error>>(
    limit: Duration,
    work: impl Future<Output = Result<T, E>>,
) -> Result<T, E> {
    tokio::time::timeout(limit, work).await.unwrap_or_else(|_| {
        let silent = io::Error::new(io::ErrorKind::TimedOut, format!("no answer within {} s", limit.as_secs()));
        Err(ServerError::mark_unreachable(sqlx::Error::Io(silent)).into())
    })
}

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
            Self::Postgres(transaction, limit) => {
                answered_within(*limit, allow_whole_ledger(transaction)).await?;
                *limit = WHOLE_LEDGER_ANSWERED;
                Ok(())
            }
        }
    }
}

/// Where a statement runs.
pub enum SqlExecutor<'c> {
    /// On any connection of these to SQLite.
    SqlitePool(&'c SqlitePool),
    /// In a transaction of SQLite.
    Sqlite(&'c mut SqliteConnection),
    /// On any connection of these to PostgreSQL, answered within this time.
    PostgresPool(&'c PgPool, Duration),
    /// In a transaction of PostgreSQL, answered within this time.
    Postgres(&'c mut PgConnection, Duration),
}

impl<'c> From<&'c mut SqlTransaction> for SqlExecutor<'c> {
    fn from(transaction: &'c mut SqlTransaction) -> Self {
        match transaction {
            SqlTransaction::Sqlite(transaction) => Self::Sqlite(transaction),
            SqlTransaction::Postgres(transaction, limit) => Self::Postgres(transaction, *limit),
        }
    }
}
