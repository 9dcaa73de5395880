//! Nodes whose changes the database has lost, because a standby took its place without them, or a backup was put back. What they have
//! printed, or have given to others, is known to their folders alone. So no node goes on before all of these were compared.

use sqlx::{PgConnection, PgPool};

use crate::{ServerError, base::error::Result};

/// The nodes that are due, by name. One without machines has nothing to compare.
pub async fn find_due(db: &mut PgConnection) -> Result<Vec<String>> {
    let due = sqlx::query_scalar(
        "SELECT node FROM repair_due WHERE EXISTS (SELECT 1 FROM station WHERE station.node = repair_due.node) ORDER BY node",
    );
    Ok(due.fetch_all(db).await.map_err(ServerError::mark_unreachable)?)
}

/// A node has seen that changes of it are lost. `with_others` = so are all other nodes with machines: one that runs, and has lost nothing,
/// says so within a renewal of its lease; one that does not run cannot.
pub async fn mark(pool: &PgPool, node: &str, with_others: bool) -> Result<()> {
    let mark = sqlx::query(
        "INSERT INTO repair_due (node) SELECT DISTINCT node FROM station WHERE node <> '' AND ($2 OR node = $1) \
         ON CONFLICT DO NOTHING",
    );
    mark.bind(node).bind(with_others).execute(pool).await.map_err(ServerError::mark_unreachable)?;
    Ok(())
}

/// The folders of a node were compared with the ledger, or it knows that nothing of its own is lost.
pub async fn record_repair(pool: &PgPool, node: &str) -> Result<()> {
    let repaired = sqlx::query("DELETE FROM repair_due WHERE node = $1").bind(node).execute(pool).await;
    repaired.map_err(ServerError::mark_unreachable)?;
    Ok(())
}
