//! Files that an order list names and that never came. Each is a refused part of its order, so that the order is not complete without it.
//! The file that comes after all takes its place, with what was asked.

use super::claim::{insert_claim, insert_ticket};
use crate::{
    Ledger, NewPartRow, PartId, PartRow, RefusalCause,
    base::{error::Result, sql},
    rows::part_row::is_missing_file,
    store::change::LedgerChange,
};

impl Ledger {
    /// Records that the file of a row never came. What an earlier list asked for of the same name in the same order is not wanted any more.
    /// `cause` says whether its copies are known. Returns whether it is new; recording it again changes nothing.
    pub async fn record_missing_file(&self, part: &NewPartRow, cause: RefusalCause, reason: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let Some(id) = insert_claim(&mut change, part).await? else { return Ok(false) };
        if let Some(ticket) = &part.ticket {
            let now = change.now;
            insert_ticket(&mut change, id, ticket, now).await?;
        }
        change.open_order(&part.terms.order_name).await?;
        if !part.terms.customer.is_empty() {
            change.update_customer(&part.terms.order_name).await?;
        }
        for earlier in change.missing_namesakes(id).await? {
            change.settle_refused(&earlier, id).await?;
        }
        change.refuse_part(id, cause, reason).await?;
        change.commit().await?;
        Ok(true)
    }
}

impl LedgerChange {
    /// What lists asked for before under the name of a part, in its order or one whose folder holds that of its order, and what never came.
    /// The rows of lists may write a name in other letters, and without its extension.
    pub(super) async fn missing_namesakes(&mut self, part: PartId) -> Result<Vec<PartRow>> {
        let new = self.require_part(part).await?;
        let (name, order) = (new.name.to_lowercase(), &new.terms.order_name);
        let is_named = |row: &PartRow| {
            let rest = name.strip_prefix(&row.name.to_lowercase()).map(str::to_owned);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.') && !rest[1..].contains('.'))
        };
        let above = order.match_indices('/').map(|(at, _)| &order[..at]).chain([order.as_str()]);
        let mut found = Vec::new();
        for order in above.filter(|order| !order.is_empty()) {
            let query = sql::select_as(
                "FROM part WHERE order_name = $1 AND order_name <> '' AND state = 'refused' AND replaced_by IS NULL AND id <> $2 ORDER BY id",
            );
            let rows: Vec<PartRow> = query.bind(order).bind(part).fetch_all(self.db()).await?;
            found.extend(rows.into_iter().filter(|row| is_missing_file(&row.file.claim) && is_named(row)));
        }
        Ok(found)
    }
}
