//! Files that an order list names and that do not come: after the last time that a row was offered for a part, its file is recorded as a
//! refused part of its order, so that the order is not complete without it.

use anyhow::Result;
use intake::{LateTicket, SpecSource, Ticket};
use ledger::{DroppedFile, NewPartRow, RefusalCause, missing_file_claim};
use settings::MachineProfile;
use tracing::warn;

use crate::{
    core::desks::Receiving,
    files::claim_note::{new_terms, ticket_row},
};

/// Records that the file of a row did not come, unless no order asks for it or the row says that it is not wanted.
pub(super) async fn record_missing_file(
    desk: &Receiving<'_>,
    machine: &MachineProfile,
    late: &LateTicket,
) -> Result<()> {
    if !late.is_last_offer || late.source.source != SpecSource::OrderList || late.is_declined {
        return Ok(());
    }
    let ticket = late.ticket.clone().unwrap_or_default();
    let order = ticket.order.clone().unwrap_or_else(|| late.order().to_owned());
    if order.is_empty() {
        return Ok(());
    }
    let list = &late.source.file_name;
    let (cause, reason) = match &late.ticket {
        Ok(_) => (
            RefusalCause::Missing,
            format!(
                "{list} names this file, which did not come. Drop it into the folder of its order: it is taken as {list} says. Where it is not wanted, `nestd close {order}` closes the order without it."
            ),
        ),
        Err(error) => (
            RefusalCause::Ticket,
            format!(
                "{list} names this file, which did not come, and its row cannot be used: {error}. Drop the file together with a list that says how many copies are wanted."
            ),
        ),
    };
    let row = missing_part_row(machine, late, ticket, order);
    if desk.shared.ledger.record_missing_file(&row, cause, &reason).await? {
        warn!(machine = %machine.name, "{list} names {}, which did not come.", row.name);
    }
    Ok(())
}

/// The part that a row asks for. Its content is not known: it has no hash.
fn missing_part_row(machine: &MachineProfile, late: &LateTicket, ticket: Ticket, order: String) -> NewPartRow {
    let name = late.part_name.rsplit(['/', '\\']).next().unwrap_or(&late.part_name);
    let (copies, terms, undated) = new_terms(machine, ticket, order);
    NewPartRow {
        claim: missing_file_claim(&late.key),
        machine: machine.name.clone(),
        name: intake::display_name(name.as_ref()),
        content_hash: String::new(),
        bytes: 0,
        copies,
        terms,
        warnings: undated.into_iter().collect(),
        ticket: Some(ticket_row(&late.source)),
        dropped: DroppedFile { folder: late.order().to_owned(), ..DroppedFile::default() },
    }
}
