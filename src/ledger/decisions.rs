//! How often was decided of the parts of a claim: refused, cancelled or taken back. The count only grows, and the note of the
//! claim beside its stored file carries it too.

use std::collections::BTreeMap;

use sqlx::FromRow;

use super::{Ledger, PartId, change::Change, error::Result};

/// A claim of which more was decided than the ledger knows.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct Decided {
    /// The claim.
    pub claim: String,
    /// Machine profile.
    pub profile: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// Order or kit, "" = none.
    pub order_name: String,
    /// How often was decided, by its note.
    pub decisions: u32,
}

impl Ledger {
    /// How often was decided of the parts of a claim.
    pub async fn decisions(&self, claim: &str) -> Result<u32> {
        let query = sqlx::query_scalar("SELECT coalesce(sum(decisions), 0) FROM part WHERE claim = ?");
        Ok(query.bind(claim).fetch_one(self.reader()?).await?)
    }

    /// Of which of these claims, each with a count of decisions, the ledger knows fewer; claims without a part are left out.
    pub async fn decided_since(&self, noted: &BTreeMap<String, u32>) -> Result<Vec<Decided>> {
        if noted.is_empty() {
            return Ok(Vec::new());
        }
        let query = sqlx::query_as(
            "SELECT p.claim, p.profile, p.name, p.order_name, n.value AS decisions \
             FROM json_each(?) n CROSS JOIN part p ON p.claim = n.key \
             GROUP BY p.claim HAVING sum(p.decisions) < n.value ORDER BY min(p.id)",
        );
        Ok(query.bind(serde_json::json!(noted).to_string()).fetch_all(self.reader()?).await?)
    }

    /// Counts at least so many decisions of a claim from now on.
    pub async fn raise_decisions(&self, claim: &str, least: u32) -> Result<()> {
        let mut change = self.change().await?;
        let raise = sqlx::query(
            "UPDATE part SET decisions = decisions + max(0, ?2 - (SELECT sum(decisions) FROM part WHERE claim = ?1)) \
             WHERE id = (SELECT min(id) FROM part WHERE claim = ?1)",
        );
        raise.bind(claim).bind(least).execute(change.db()).await?;
        change.commit().await
    }
}

impl Change {
    /// Counts a decision of a part.
    pub async fn count_decision(&mut self, id: PartId) -> Result<()> {
        let count = sqlx::query("UPDATE part SET decisions = decisions + 1 WHERE id = ?").bind(id);
        count.execute(self.db()).await?;
        Ok(())
    }
}
