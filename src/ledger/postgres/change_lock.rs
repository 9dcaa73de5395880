//! The lock that each change takes.

use sqlx::{PgPool, Postgres, Transaction};

use crate::ledger::{ServerError, error::Result};

/// Key of the lock that each change takes, so that the numbers of events are committed in their order, and a check and
/// the act that follows it are one. A farm has its database for itself.
const CHANGE_LOCK: i64 = 0x6e65_7374_6400;

/// Begins a transaction that has the lock, after all that have begun before.
pub async fn begin_locked(pool: &PgPool) -> Result<Transaction<'static, Postgres>> {
    let begin = async {
        let mut transaction = pool.begin_with("BEGIN").await?;
        sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(CHANGE_LOCK).execute(&mut *transaction).await?;
        Ok(transaction)
    };
    Ok(begin.await.map_err(ServerError::mark_unreachable)?)
}
