//! Nodes whose changes the database has lost, because a standby took its place without them, or a backup was put back. What they have
//! printed, or have given to others, is known to their folders alone. So no node goes on before all of these were compared.

use sqlx::{PgConnection, PgPool};

use crate::ledger::{ServerError, error::Result};

/// The nodes that are due, by name. One without machines has nothing to compare.
pub async fn find_due(db: &mut PgConnection) -> Result<Vec<String>> {
    let due = sqlx::query_scalar(
        "SELECT node FROM repair_due WHERE EXISTS (SELECT 1 FROM station WHERE station.node = repair_due.node) ORDER BY node",
    );
    Ok(due.fetch_all(db).await.map_err(ServerError::mark_unreachable)?)
}

/// Whether a node is due.
pub async fn is_due(db: &mut PgConnection, node: &str) -> Result<bool> {
    let is_due = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM repair_due WHERE node = $1)");
    Ok(is_due.bind(node).fetch_one(db).await.map_err(ServerError::mark_unreachable)?)
}

/// A node has seen that changes of it are lost. Those that do not run cannot say whether they have lost any: they are due, too.
pub async fn mark(pool: &PgPool, node: &str) -> Result<()> {
    let mark = sqlx::query(
        "INSERT INTO repair_due (node) SELECT $1 UNION SELECT station.node FROM station WHERE station.node <> '' AND NOT EXISTS \
         (SELECT 1 FROM lease WHERE lease.name = 'node ' || station.node AND until > clock_timestamp()) ON CONFLICT DO NOTHING",
    );
    mark.bind(node).execute(pool).await.map_err(ServerError::mark_unreachable)?;
    Ok(())
}

/// All nodes with machines but this one are due.
pub async fn mark_others(pool: &PgPool, node: &str) -> Result<()> {
    let mark = sqlx::query(
        "INSERT INTO repair_due (node) SELECT DISTINCT node FROM station WHERE node NOT IN ('', $1) ON CONFLICT DO NOTHING",
    );
    mark.bind(node).execute(pool).await.map_err(ServerError::mark_unreachable)?;
    record_repair(pool, node).await
}

/// The folders of a node were compared with the ledger.
pub async fn record_repair(pool: &PgPool, node: &str) -> Result<()> {
    let repaired = sqlx::query("DELETE FROM repair_due WHERE node = $1").bind(node).execute(pool).await;
    repaired.map_err(ServerError::mark_unreachable)?;
    Ok(())
}
