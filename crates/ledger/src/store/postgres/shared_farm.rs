//! The farm of a ledger, which all its nodes are: it is the database that holds the ledger.

use sqlx::PgPool;

use crate::{ServerError, SharedFarm, base::error::Result};

/// The farm of this ledger. A database that was copied is another farm. A standby that took over is the same one, and writes a timeline
/// of its own: where both are in use, each is told from the other.
pub async fn find(pool: &PgPool) -> Result<SharedFarm> {
    let farm = sqlx::query_as(
        "SELECT md5(format('%s %s', system_identifier, oid)), \
         format('postgres %s %s, timeline %s', system_identifier, oid, left(pg_walfile_name(pg_current_wal_lsn()), 8)) \
         FROM pg_control_system(), pg_database WHERE datname = current_database()",
    );
    let (id, database) = farm.fetch_one(pool).await.map_err(ServerError::mark_unreachable)?;
    Ok(SharedFarm { id, database })
}
