//! Files that an order list names and that never came. Each is a refused part of its order, so that the order is not complete without it.
//! The file that comes after all takes its place, with what was asked.

use build_file::part_endings;
use unicode_normalization::UnicodeNormalization;

use super::claim::{insert_claim, insert_ticket};
use crate::{
    Ledger, LedgerError, NewPartRow, PartId, PartRow, PartState, RefusalCause,
    base::{error::Result, sql},
    rows::part_row::is_missing_file,
    store::change::LedgerChange,
};

impl Ledger {
    /// Records that the file of a row never came, unless one of its name is a part of its order. What was asked for before under that name
    /// and was refused is not wanted any more. `cause` says whether its copies are known, which they are not where another row of the same
    /// list names the file, too. Returns whether it is new; recording it again changes nothing.
    pub async fn record_missing_file(&self, part: &NewPartRow, cause: RefusalCause, reason: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let in_order = change.parts_named_by_row(part).await?;
        if in_order.iter().any(|known| known.state != PartState::Refused) {
            return Ok(false);
        }
        let Some(id) = insert_claim(&mut change, part).await? else { return Ok(false) };
        if let Some(ticket) = &part.ticket {
            let now = change.now;
            insert_ticket(&mut change, id, ticket, now).await?;
        }
        change.open_order(&part.terms.order_name).await?;
        if !part.terms.customer.is_empty() {
            change.update_customer(&part.terms.order_name).await?;
        }
        let (mut cause, earlier) = (cause, in_order.iter().filter(|known| known.owed.replaced_by.is_none()));
        for earlier in earlier {
            if list_of_row(&earlier.file.claim) == list_of_row(&part.claim) {
                cause = RefusalCause::Ticket;
            }
            change.settle_refused(earlier, id).await?;
        }
        change.refuse_part(id, cause, reason).await?;
        change.commit().await?;
        Ok(true)
    }

    /// A file that never came is not wanted any more: a person said so.
    pub async fn cancel_missing_file(&self, id: PartId, reason: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        let unwanted = i64::from(part.wanted_copies());
        if part.state != PartState::Refused || !is_missing_file(&part.file.claim) || unwanted == 0 {
            return Err(LedgerError::AlreadyRefused(id));
        }
        let cause = RefusalCause::Cancelled;
        let set =
            sql::query("UPDATE part SET refusal = $1, reason = $2 WHERE id = $3").bind(cause).bind(reason).bind(id);
        set.execute(change.db()).await?;
        change.change_cancelled(id, unwanted).await?;
        change.write_refusal_event(&part.machine, Some(id), cause, reason).await?;
        change.note_wanted_change(-unwanted).await?;
        change.update_orders_of([id]).await?;
        change.commit().await
    }
}

impl LedgerChange {
    /// The parts of the order of a row that its name means: of its machine, or moved away from it.
    async fn parts_named_by_row(&mut self, row: &NewPartRow) -> Result<Vec<PartRow>> {
        let query = sql::select_as(
            "FROM part WHERE order_name = $1 AND order_name <> '' AND claim <> $2 AND (machine = $3 \
             OR EXISTS (SELECT 1 FROM event e WHERE e.part_id = part.id AND e.kind = 'moved')) ORDER BY id",
        );
        let query = query.bind(&row.terms.order_name).bind(&row.claim).bind(&row.machine);
        let known: Vec<PartRow> = query.fetch_all(self.db()).await?;
        let folder = fold(&row.dropped.folder);
        let mut named = Vec::new();
        for known in known {
            let is_row = is_missing_file(&known.file.claim);
            if is_file_of_row(&known.name, &row.name) || is_row && is_file_of_row(&row.name, &known.name) {
                let its_folder = self.folder_of(known.id).await?;
                let is_meant = if is_row { its_folder == folder } else { is_near(&its_folder, &folder) };
                named.extend(is_meant.then_some(known));
            }
        }
        Ok(named)
    }

    /// The folder of the file of a part, folded.
    async fn folder_of(&mut self, part: PartId) -> Result<String> {
        let query = sql::query_scalar("SELECT file_folder FROM part WHERE id = $1").bind(part);
        let folder: String = query.fetch_one(self.db()).await?;
        Ok(fold(&folder))
    }

    /// The rows of lists that ask for a file which was just claimed and did not come before: those of its own folder, otherwise the only one of
    /// a folder above or below it.
    pub(super) async fn missing_namesakes(&mut self, file: PartId) -> Result<Vec<PartRow>> {
        let new = self.require_part(file).await?;
        let order = &new.terms.order_name;
        let above = order.match_indices('/').map(|(at, _)| &order[..at]).chain([order.as_str()]);
        let mut found = Vec::new();
        for order in above.filter(|order| !order.is_empty()) {
            let query = sql::select_as(
                "FROM part WHERE order_name = $1 AND order_name <> '' AND state = 'refused' AND replaced_by IS NULL AND machine = $2 \
                 AND id <> $3 ORDER BY id",
            );
            let rows: Vec<PartRow> = query.bind(order).bind(&new.machine).bind(file).fetch_all(self.db()).await?;
            let is_meant = |row: &PartRow| is_missing_file(&row.file.claim) && is_file_of_row(&new.name, &row.name);
            for row in rows.into_iter().filter(is_meant) {
                found.push((self.folder_of(row.id).await?, row));
            }
        }
        // Most files are missed by no list: nothing more is read for them.
        if found.is_empty() {
            return Ok(Vec::new());
        }
        let folder = self.folder_of(file).await?;
        let is_beside = found.iter().any(|(its_folder, _)| *its_folder == folder);
        found.retain(|(its_folder, _)| if is_beside { *its_folder == folder } else { is_near(its_folder, &folder) });
        let is_clear = is_beside || found.len() == 1;
        Ok(found.into_iter().filter(|_| is_clear).map(|(_, row)| row).collect())
    }
}

/// Whether one of two folders is the other one or lies in it.
fn is_near(one: &str, other: &str) -> bool {
    let holds = |above: &str, below: &str| below.strip_prefix(above).is_some_and(|rest| rest.starts_with('/'));
    one == other || holds(one, other) || holds(other, one)
}

/// A name in one form of its letters, in lower case.
fn fold(name: &str) -> String {
    name.nfc().collect::<String>().to_lowercase()
}

/// Whether the row of a list means the file with this name: in any letter case, and perhaps without the ending of a part.
fn is_file_of_row(file: &str, row: &str) -> bool {
    let (file, row) = (fold(file), fold(row));
    let is_stem = |(stem, end): (&str, &str)| stem == row && part_endings().any(|ending| ending == end);
    file == row || file.rsplit_once('.').is_some_and(is_stem)
}

/// What the claims of the rows of one list begin with.
fn list_of_row(claim: &str) -> &str {
    claim.rsplitn(3, '-').last().unwrap_or(claim)
}
