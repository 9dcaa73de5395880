//! Due dates at risk. One event is written for all parts of an order that are due at the same time.

use jiff::Timestamp;

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
    /// Height of the build that holds the part, mm, if known.
    pub height_mm: Option<f64>,
}

sql_row!(DuePartRow { id, machine, name, order_name, due_at, due_text, height_mm });

impl Ledger {
    /// The parts that are due until a time, by due date.
    pub async fn due_parts(&self, until: Timestamp) -> Result<Vec<DuePartRow>> {
        let query = sql::query_as(
            "SELECT p.id, p.machine, p.name, p.order_name, p.due_at, p.due_text, \
             (SELECT max(b.height_mm) FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = p.id AND b.published_at IS NULL) AS height_mm \
             FROM part p WHERE p.due_at IS NOT NULL AND p.at_risk_at IS NULL \
             AND p.state IN ('claimed', 'waiting', 'batched') AND p.due_at <= $1 ORDER BY p.due_at, p.id",
        );
        Ok(query.bind(UtcTimestamp(until)).fetch_all(self.reader()?).await?)
    }

    /// The parts that are not printed yet and whose due date was reported as at risk, by due date.
    pub async fn parts_at_risk(&self) -> Result<Vec<DuePartRow>> {
        let query = sql::query_as(
            "SELECT p.id, p.machine, p.name, p.order_name, p.due_at, p.due_text, CAST(NULL AS DOUBLE PRECISION) AS height_mm \
             FROM part p WHERE p.due_at IS NOT NULL AND p.at_risk_at IS NOT NULL \
             AND p.state IN ('claimed', 'waiting', 'batched') ORDER BY p.due_at, p.id",
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
