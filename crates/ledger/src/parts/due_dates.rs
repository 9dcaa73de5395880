//! Due dates at risk. One event is written for all parts of an order that are due at the same time.

use crate::{
    EventKind, Ledger, PartId, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// An unpublished part with a due date that was not reported as at risk yet.
#[derive(Debug, Clone, PartialEq)]
pub struct DuePartRow {
    /// Number of the part.
    pub id: PartId,
    /// Machine.
    pub machine: String,
    /// File name as dropped.
    pub name: String,
    /// Order, "" = none.
    pub order_name: String,
    /// When it is due.
    pub due_at: UtcTimestamp,
    /// The due date as it was given, "" = not known.
    pub due_text: String,
}

sql_row!(DuePartRow { id, machine, name, order_name, due_at, due_text });

impl Ledger {
    /// The parts with a due date that are not printed yet, and of which nobody was warned, by due date.
    pub async fn unwarned_due_parts(&self) -> Result<Vec<DuePartRow>> {
        let query = sql::select_as(
            "FROM part WHERE due_at IS NOT NULL AND at_risk_at IS NULL AND state IN ('claimed', 'waiting', 'batched') \
             ORDER BY due_at, id",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// Records that the due date of these parts of one order is at risk. Writes one event, which refers to the first
    /// part.
    pub async fn record_at_risk(&self, machine: &str, parts: &[PartId], detail: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        for part in parts {
            let update = sql::query("UPDATE part SET at_risk_at = $1 WHERE id = $2").bind(now).bind(part);
            update.execute(change.db()).await?;
        }
        change.write_event(EventKind::AtRisk, machine, parts.first().copied(), None, detail).await?;
        change.commit().await
    }
}
