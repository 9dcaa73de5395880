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
    let (folder, name) = named_file(late);
    if intake::is_document(&name) {
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
                "{list} names this file, which did not come. Drop it into the folder of its order: it is taken as {list} says. Where it is not wanted, `nestd cancel` with the number of this part takes it out."
            ),
        ),
        Err(error) => (
            RefusalCause::Ticket,
            format!(
                "{list} names this file, which did not come, and its row cannot be used: {error}. Drop the file together with a list that says how many copies are wanted."
            ),
        ),
    };
    let row = missing_part_row(machine, late, (folder, name), (ticket, order));
    if desk.shared.ledger.record_missing_file(&row, cause, &reason).await? {
        warn!(machine = %machine.name, "{list} names {}, which did not come.", row.name);
    }
    Ok(())
}

/// The folder and the name of the file that a row means: in the folder of its list, or in one that it names.
fn named_file(late: &LateTicket) -> (String, String) {
    let path = late.part_name.replace('\\', "/");
    let (said, name) = path.rsplit_once('/').unwrap_or(("", &path));
    // A path of another computer says nothing of the folders here.
    let said = if said.contains(':') || said.starts_with('/') { "" } else { said.trim_start_matches("./") };
    let folders = [late.order(), said].into_iter().filter(|part| !part.is_empty() && *part != ".");
    let folder = folders.map(|folder| intake::display_name(folder.as_ref())).collect::<Vec<_>>().join("/");
    (folder, intake::display_name(name.as_ref()))
}

/// The part that a row asks for. Its content is not known: instead of its hash it has one that no file has.
fn missing_part_row(
    machine: &MachineProfile,
    late: &LateTicket,
    (folder, name): (String, String),
    (ticket, order): (Ticket, String),
) -> NewPartRow {
    let claim = missing_file_claim(&late.key, &format!("{order}\n{}", late.source.text));
    let (copies, terms, undated) = new_terms(machine, ticket, order);
    NewPartRow {
        machine: machine.name.clone(),
        name,
        content_hash: blake3::hash(claim.as_bytes()).to_hex().to_string(),
        bytes: 0,
        copies,
        terms,
        warnings: undated.into_iter().collect(),
        ticket: Some(ticket_row(&late.source)),
        dropped: DroppedFile { folder, ..DroppedFile::default() },
        claim,
    }
}
