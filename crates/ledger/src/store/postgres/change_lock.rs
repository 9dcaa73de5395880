//! The lock that each change takes, and who has it.

use sqlx::{PgPool, Postgres, Transaction};

use crate::{ServerError, base::error::Result};

/// Key of the lock that each change takes, so that the numbers of events are committed in their order, and a check and
/// the act that follows it are one. A farm has its database for itself.
const CHANGE_LOCK: i64 = 0x6e65_7374_6400;

/// The connection that has the lock, or the one that this waits for in turn.
const FIND_HOLDER: &str = "WITH RECURSIVE holder (pid, depth) AS ( \
     SELECT pid, 0 FROM pg_locks WHERE locktype = 'advisory' AND granted AND objsubid = 1 \
     AND (CAST(classid AS bigint) << 32) + CAST(objid AS bigint) = $1 \
     AND database = (SELECT oid FROM pg_database WHERE datname = current_database()) \
     UNION SELECT unnest(pg_blocking_pids(pid)), depth + 1 FROM holder WHERE depth < 8) \
     SELECT format('%s (server process %s, %s, %s)', \
     coalesce(nullif(a.application_name, ''), a.usename), a.pid, coalesce('from ' || host(a.client_addr), 'on its server'), \
     coalesce(a.state || ', since ' || to_char(a.xact_start AT TIME ZONE 'UTC', 'YYYY-MM-DD HH24:MI:SS \"UTC\"'), 'state unknown')) \
     FROM holder JOIN pg_stat_activity a USING (pid) ORDER BY depth DESC LIMIT 1";

/// Begins a transaction that has the lock, after all that have begun before.
///
/// `ChangesWait` if it is not its turn in time.
pub async fn begin_locked(pool: &PgPool) -> Result<Transaction<'static, Postgres>> {
    let begin = async {
        let mut transaction = pool.begin_with("BEGIN").await?;
        sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(CHANGE_LOCK).execute(&mut *transaction).await?;
        Ok(transaction)
    };
    match begin.await {
        Err(error) if ServerError::is_lock_timeout(&error) => {
            let holder = sqlx::query_scalar(FIND_HOLDER).bind(CHANGE_LOCK).fetch_optional(pool).await;
            let holder: Option<String> = holder.map_err(ServerError::mark_unreachable)?;
            Err(ServerError::ChangesWait { holder: holder.unwrap_or_else(|| "many others".to_owned()) }.into())
        }
        other => Ok(other.map_err(ServerError::mark_unreachable)?),
    }
}
