//! Number of decisions about the parts of a claim: refusals, cancellations and retries. The number only grows. The note
//! of the claim beside its stored file carries it too.

use std::collections::BTreeMap;

use crate::{
    Ledger, NewTerms, PartId, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    parts::material::material_key,
    store::change::LedgerChange,
};

/// A claim with more decisions than the ledger knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClaimDecisions {
    /// The claim.
    pub claim: String,
    /// Machine.
    pub machine: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// Order or kit, "" = none.
    pub order_name: String,
    /// Number of decisions according to the note of the claim.
    pub decisions: u32,
}

sql_row!(ClaimDecisions { claim, machine, name, order_name, decisions });

impl Ledger {
    /// Number of decisions about the parts of a claim.
    pub async fn decision_count(&self, claim: &str) -> Result<u32> {
        let query = sql::query_scalar("SELECT CAST(coalesce(sum(decisions), 0) AS BIGINT) FROM part WHERE claim = $1");
        Ok(query.bind(claim).fetch_one(self.reader()?).await?)
    }

    /// Returns those of the given claims for which the ledger knows fewer decisions than given. Claims without a part
    /// are left out.
    pub async fn claims_with_more_decisions(&self, noted: &BTreeMap<String, u32>) -> Result<Vec<ClaimDecisions>> {
        if noted.is_empty() {
            return Ok(Vec::new());
        }
        let query = sql::query_as(
            "SELECT p.claim, p.machine, p.name, p.order_name, CAST(n.value AS BIGINT) AS decisions \
             FROM json_each($1) n JOIN part p ON p.claim = n.key AND p.object_index = 0 \
             WHERE (SELECT sum(s.decisions) FROM part s WHERE s.claim = n.key) < CAST(n.value AS BIGINT) ORDER BY p.id",
        );
        Ok(query.bind(serde_json::json!(noted).to_string()).fetch_all(self.reader()?).await?)
    }

    /// Takes in what was last asked for with the part of a claim, as its note says. What its unit makes of its size is found when it is read
    /// again. Its order stays.
    pub async fn take_noted_terms(&self, claim: &str, terms: &NewTerms) -> Result<()> {
        let mut change = self.begin_change().await?;
        let set = sql::query(
            "UPDATE part SET customer = $1, material = $2, material_key = $3, priority = $4, due_at = $5, due_text = $6, orientation = $7, \
             tilts = $8, clearance_mm = $9, unit = $10, read_unit = coalesce($11, read_unit), note = $12, email = $13, \
             mend_allowed_by = $14, finish = $15 WHERE claim = $16",
        );
        set.bind(&terms.customer)
            .bind(&terms.material)
            .bind(material_key(&terms.material))
            .bind(terms.priority)
            .bind(terms.due_at.map(UtcTimestamp))
            .bind(&terms.due_text)
            .bind(terms.orientation)
            .bind(terms.tilts.to_string())
            .bind(terms.clearance_mm)
            .bind(terms.unit)
            .bind(terms.read_unit)
            .bind(&terms.note)
            .bind(&terms.email)
            .bind(&terms.mend_allowed_by)
            .bind(&terms.finish)
            .bind(claim)
            .execute(change.db())
            .await?;
        change.commit().await
    }

    /// Raises the number of decisions of a claim to at least `least`.
    pub async fn raise_decision_count(&self, claim: &str, least: u32) -> Result<()> {
        let mut change = self.begin_change().await?;
        let raise = sql::query(
            "UPDATE part SET decisions = $2 - (SELECT sum(s.decisions) - part.decisions FROM part s WHERE s.claim = $1) \
             WHERE id = (SELECT min(id) FROM part WHERE claim = $1) \
             AND (SELECT sum(decisions) FROM part WHERE claim = $1) < $2",
        );
        raise.bind(claim).bind(least).execute(change.db()).await?;
        change.commit().await
    }
}

impl LedgerChange {
    /// Counts a decision about a part.
    pub async fn count_decision(&mut self, id: PartId) -> Result<()> {
        let count = sql::query("UPDATE part SET decisions = decisions + 1 WHERE id = $1").bind(id);
        count.execute(self.db()).await?;
        Ok(())
    }
}
