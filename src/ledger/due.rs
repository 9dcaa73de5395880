//! Due dates that come at risk: an event once, for all parts of an order that are due at the same time.

use jiff::Timestamp;
use sqlx::FromRow;

use super::{Ledger, PartId, Utc, error::Result};

/// A part with a due date that is not published yet, and of which nobody was told.
#[derive(Debug, Clone, PartialEq, FromRow)]
pub struct DuePart {
    /// Which part.
    pub id: PartId,
    /// Machine profile.
    pub profile: String,
    /// File name as dropped.
    pub name: String,
    /// Order, "" = none.
    pub order_name: String,
    /// When it is due.
    pub due_at: Utc,
    /// Height of the build that it was taken into, mm, as far as it is known.
    pub height_mm: Option<f64>,
}

impl Ledger {
    /// The parts that are due until then, the first due first.
    pub async fn due_parts(&self, until: Timestamp) -> Result<Vec<DuePart>> {
        let query = sqlx::query_as(
            "SELECT p.id, p.profile, p.name, p.order_name, p.due_at, \
             (SELECT max(b.height_mm) FROM placement l JOIN build b ON b.id = l.build_id \
             WHERE l.part_id = p.id AND b.published_at IS NULL) AS height_mm \
             FROM part p WHERE p.due_at IS NOT NULL AND p.at_risk_at IS NULL \
             AND p.state IN ('claimed', 'waiting', 'batched') AND p.due_at <= ? ORDER BY p.due_at, p.id",
        );
        Ok(query.bind(Utc(until)).fetch_all(self.reader()?).await?)
    }

    /// The due date of these parts, which are of one order, is at risk: one event, which names the first.
    pub async fn at_risk(&self, profile: &str, parts: &[PartId], detail: &str) -> Result<()> {
        let mut change = self.change().await?;
        let now = change.now;
        for part in parts {
            let told = sqlx::query("UPDATE part SET at_risk_at = ? WHERE id = ?").bind(now).bind(part);
            told.execute(change.db()).await?;
        }
        change.event("at_risk", profile, parts.first().copied(), None, detail).await?;
        change.commit().await
    }
}
