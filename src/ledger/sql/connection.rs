//! Connections to one of the two databases.

#[cfg(feature = "postgres")]
use sqlx::{PgConnection, PgPool, Postgres};
use sqlx::{Sqlite, SqliteConnection, SqlitePool, Transaction};

/// A transaction. Dropping it rolls everything back.
#[derive(Debug)]
pub enum SqlTransaction {
    /// Of SQLite.
    Sqlite(Transaction<'static, Sqlite>),
    /// Of PostgreSQL.
    #[cfg(feature = "postgres")]
    Postgres(Transaction<'static, Postgres>),
}

/// Where a statement runs.
pub enum SqlExecutor<'c> {
    /// On any connection of these to SQLite.
    SqlitePool(&'c SqlitePool),
    /// In a transaction of SQLite.
    Sqlite(&'c mut SqliteConnection),
    /// On any connection of these to PostgreSQL.
    #[cfg(feature = "postgres")]
    PostgresPool(&'c PgPool),
    /// In a transaction of PostgreSQL.
    #[cfg(feature = "postgres")]
    Postgres(&'c mut PgConnection),
}

impl<'c> From<&'c mut SqlTransaction> for SqlExecutor<'c> {
    fn from(transaction: &'c mut SqlTransaction) -> Self {
        match transaction {
            SqlTransaction::Sqlite(transaction) => Self::Sqlite(transaction),
            #[cfg(feature = "postgres")]
            SqlTransaction::Postgres(transaction) => Self::Postgres(transaction),
        }
    }
}
