//! A refused part is taken back: as it is, or with its mesh mended.

use crate::{
    Ledger, LedgerError, PartId, PartState,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

impl Ledger {
    /// refused -> claimed: the part is read again.
    pub async fn retry_part(&self, id: PartId) -> Result<()> {
        self.take_back(id, None).await
    }

    /// refused -> claimed: the part is read again, and somebody said that its mesh may be mended.
    pub async fn mend_part(&self, id: PartId, by: &str) -> Result<()> {
        self.take_back(id, Some(by)).await
    }

    async fn take_back(&self, id: PartId, mend_allowed_by: Option<&str>) -> Result<()> {
        let mut change = self.begin_change().await?;
        let state = change.require_part(id).await?.state;
        if state != PartState::Refused {
            return Err(LedgerError::NotRefused { part: id, state });
        }
        let wanted_again = copies_lost_by_refusal(&mut change, id).await?;
        let why = mend_allowed_by
            .map_or("taken back".to_owned(), |by| format!("taken back; {by} says that its mesh may be mended"));
        change.move_part(id, PartState::Claimed, None, &why).await?;
        if let Some(by) = mend_allowed_by {
            let allow = sql::query("UPDATE part SET mend_allowed_by = $1 WHERE id = $2").bind(by).bind(id);
            allow.execute(change.db()).await?;
        }
        // A revision that is taken back is wanted beside the newer one. One that was never read is read in the unit that its machine has
        // by now.
        let now = change.now;
        let set = sql::query(
            "UPDATE part SET replaced_by = NULL, waits_since = $1, \
             read_unit = CASE WHEN size_x_mm IS NOT NULL THEN read_unit END WHERE id = $2",
        );
        set.bind(now).bind(id).execute(change.db()).await?;
        if wanted_again > 0 {
            change.note_wanted_change(wanted_again).await?;
            change.change_cancelled(id, -wanted_again).await?;
        }
        change.count_decision(id).await?;
        change.update_orders_of([id]).await?;
        change.commit().await
    }
}

/// By how many the copies wanted of a part fell when it was last refused, or replaced after that.
pub(super) async fn copies_lost_by_refusal(change: &mut LedgerChange, id: PartId) -> Result<i64> {
    let last = sql::query_scalar(
        "SELECT coalesce(-wanted_change, 0) FROM event WHERE part_id = $1 AND (kind IN ('refused', 'order_closed') \
         OR kind = 'revised' AND wanted_change IS NOT NULL) ORDER BY id DESC LIMIT 1",
    );
    Ok(last.bind(id).fetch_optional(change.db()).await?.unwrap_or(0))
}
