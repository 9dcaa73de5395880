//! Tickets that came after their part was taken: what they ask is applied once, however often they are offered.

use jiff::Timestamp;

use super::{
    claim::insert_ticket,
    edit::{EditedPart, edit_part},
};
use crate::{
    Ledger, NewTicketRow, PartEdit, PartId, UtcTimestamp,
    base::{error::Result, sql},
};

impl Ledger {
    /// Changes a part as a late ticket asks, and keeps the ticket with the part. `came_at` = when its file came; the same file
    /// that is offered again, because it could not be moved away, changes nothing: meanwhile a person may have changed the
    /// part. `None` = that is so.
    pub async fn apply_late_ticket(
        &self,
        id: PartId,
        edit: &PartEdit,
        ticket: &NewTicketRow,
        came_at: Timestamp,
    ) -> Result<Option<EditedPart>> {
        let mut change = self.begin_change().await?;
        let came_at = UtcTimestamp(came_at);
        let known: bool = sql::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM ticket WHERE part_id = $1 AND file_name = $2 AND text = $3 AND received_at = $4)",
        )
        .bind(id)
        .bind(&ticket.file_name)
        .bind(&ticket.text)
        .bind(came_at)
        .fetch_one(change.db())
        .await?;
        if known {
            return Ok(None);
        }
        let edited = edit_part(&mut change, id, edit, &ticket.file_name).await?;
        insert_ticket(&mut change, id, ticket, came_at).await?;
        // It leaves the folder, and answers nothing that is asked.
        let told = format!("; {} came later and is applied, and is no answer to this", ticket.file_name);
        let tell = sql::query(
            "UPDATE part SET question = question || $1 WHERE id = $2 AND question <> '' AND instr(question, $1) = 0",
        );
        tell.bind(&told).bind(id).execute(change.db()).await?;
        change.commit().await?;
        Ok(Some(edited))
    }
}
