//! A ledger in a PostgreSQL database.

use sqlx::{
    PgPool, Postgres, Transaction,
    postgres::{PgConnectOptions, PgPoolOptions},
};

use super::schema;
use crate::ledger::{LedgerError, error::Result, sql::SqlExecutor};

/// Number of connections of a process.
const CONNECTIONS: u32 = 8;
/// Key of the lock that each change takes, so that the numbers of events are committed in their order, and a check and
/// the act that follows it are one. A farm has its database for itself.
const CHANGE_LOCK: i64 = 0x6e65_7374_6400;

/// An open database. A clone is cheap and refers to the same connections.
#[derive(Clone)]
pub struct PostgresStore {
    pool: PgPool,
}

impl PostgresStore {
    /// Opens the database and migrates its schema.
    pub async fn open(options: PgConnectOptions) -> Result<Self> {
        let store = Self::connect(options).await?;
        schema::bring_up_to_date(&store.pool).await?;
        Ok(store)
    }

    async fn connect(options: PgConnectOptions) -> Result<Self> {
        let pool = PgPoolOptions::new().max_connections(CONNECTIONS).connect_with(options).await;
        Ok(Self { pool: pool.map_err(LedgerError::from)? })
    }

    /// Closes all connections.
    pub async fn close(&self) {
        self.pool.close().await;
    }

    /// The connections for single statements that read.
    pub fn reader(&self) -> SqlExecutor<'_> {
        SqlExecutor::PostgresPool(&self.pool)
    }

    /// Begins a consistent read of several tables.
    pub async fn begin_snapshot(&self) -> Result<Transaction<'static, Postgres>> {
        Ok(self.pool.begin_with("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY").await?)
    }

    /// Begins a change, after all changes that have begun before.
    pub async fn begin_change(&self) -> Result<Transaction<'static, Postgres>> {
        let mut transaction = self.pool.begin_with("BEGIN").await?;
        sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(CHANGE_LOCK).execute(&mut *transaction).await?;
        Ok(transaction)
    }
}
