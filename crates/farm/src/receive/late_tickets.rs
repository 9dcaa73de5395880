//! Tickets and rows of order lists that come after their part was taken: they change the part as long as the final
//! nesting of its copies has not begun. Afterwards the reason says what became of the part, and how to order more.
//!
//! The change is applied first and the ticket is finished afterwards: after a crash in between it is offered again. The
//! ledger knows it by then, and changes nothing.

use anyhow::Result;
use intake::{LateTicket, LateTicketEnd, NamedPart, SpecSource, Ticket};
use jiff::{SignedDuration, Timestamp};
use jobs::BackgroundJob;
use ledger::{LedgerError, PartEdit, PartRow, PartState, RefusalCause, RequiredTilts, is_missing_file};
use nester::OrientationLimits;
use settings::MachineProfile;
use tracing::{info, warn};

use super::{mark_note, missing_files::record_missing_file};
use crate::{
    core::{desks::Receiving, farm::Farm},
    files::claim_note::ticket_row,
    scanning::hot_folder_scan::HotFolderScan,
};

/// A part that was built or refused longer ago is not meant by a ticket that comes now.
const MEANT_WITHIN: SignedDuration = SignedDuration::from_hours(7 * 24);

/// Moves a late ticket to where it belongs.
#[derive(Clone)]
pub(crate) struct LateTicketJob {
    machine: String,
    file_name: String,
    key: String,
}

impl BackgroundJob<Farm> for LateTicketJob {
    const KIND: &'static str = "LateTicket";
    type Outcome = Result<()>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.key.clone()
    }

    async fn on_done(self, _desk: Self::Desk<'_>, ended: Self::Outcome) -> Result<()> {
        if let Err(failure) = ended {
            // It is offered again, and changes nothing.
            warn!(machine = %self.machine, "{} could not be put where it belongs: {failure:#}.", self.file_name);
        }
        Ok(())
    }
}

/// What becomes of a late ticket.
#[derive(Debug, Clone, PartialEq, Eq)]
enum LateDecision {
    /// It waits until its part is read or nested.
    Wait,
    /// It waits for its part to be dropped.
    AwaitPart(AwaitedPart),
    /// It was applied to this part.
    Accept(String),
    /// It is refused for this reason.
    Refuse(String),
}

/// A part that a late ticket waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AwaitedPart {
    /// No part is meant: it may still come.
    Missing,
    /// It was refused, and is to be dropped again together with its ticket.
    Refused,
    /// It is in a published build. A new file of its name may come, which is printed as well.
    Built,
}

impl AwaitedPart {
    /// What is said of one part or several (end of a sentence).
    fn text(self, parts: usize) -> &'static str {
        match (self, parts) {
            (Self::Missing, 1) => "which is not there",
            (Self::Missing, _) => "which are not there",
            (Self::Refused, 1) => "which was refused: drop it again",
            (Self::Refused, _) => "which were refused: drop them again",
            (Self::Built, 1) => {
                "which is in a build already: where no other file of that name is to be printed, remove what is said here (`nestd edit` \
                 orders more copies)"
            }
            (Self::Built, _) => {
                "which are in builds already: where no other files of these names are to be printed, remove what is said here (`nestd \
                 edit` orders more copies)"
            }
        }
    }
}

/// Late tickets that the ledger has not taken: their keys, and the first failure. They must be offered again.
pub(crate) type UnjudgedTickets = (Vec<String>, anyhow::Error);

/// Applies the late tickets of a scan. What still waits for a part is added to what waits. Returns the keys of those whose part is read or
/// nested just now: they must be offered again.
pub(super) async fn apply_late_tickets(
    desk: &mut Receiving<'_>,
    machine: &str,
    scan: &mut HotFolderScan,
) -> Result<Vec<String>, UnjudgedTickets> {
    let tickets = std::mem::take(&mut scan.late_tickets);
    if tickets.is_empty() {
        return Ok(Vec::new());
    }
    let since = desk.shared.date().checked_sub(MEANT_WITHIN).unwrap_or(Timestamp::UNIX_EPOCH);
    let parts = match desk.shared.ledger.recent_parts(machine, since).await {
        Ok(parts) => parts,
        Err(failure) => return Err((tickets.into_iter().map(|late| late.key).collect(), failure.into())),
    };
    let (mut keys, mut first, mut left) = (Vec::new(), None, Vec::new());
    for late in tickets {
        let key = late.key.clone();
        if desk.jobs.is_running::<LateTicketJob>(&key) {
            continue;
        }
        let judged = match apply_late_ticket(desk, machine, &late, &parts).await {
            Ok(LateDecision::AwaitPart(part)) => {
                left.push((late, part));
                continue;
            }
            // Its part is read or nested just now: the next scan must not take it for one without a part.
            Ok(LateDecision::Wait) => {
                keys.push(key);
                continue;
            }
            Ok(decision) => finish(desk, machine, late, decision).await,
            Err(failure) => Err(failure),
        };
        if let Err(failure) = judged {
            keys.push(key);
            first.get_or_insert(failure);
        }
    }
    scan.waiting_reasons.extend(waiting_reasons(&left));
    match first {
        None => Ok(keys),
        Some(failure) => Err((keys, failure)),
    }
}

/// Maximum number of files that are named for one list.
const MAX_NAMED: usize = 5;

/// What waits for a part: a ticket by itself, the rows of a list together.
fn waiting_reasons(left: &[(LateTicket, AwaitedPart)]) -> Vec<String> {
    let of_same_file =
        left.chunk_by(|(one, part), (other, other_part)| one.entry.path == other.entry.path && part == other_part);
    let reason = |tickets: &[(LateTicket, AwaitedPart)]| {
        let (first, part) = tickets.first()?;
        let order = if first.order().is_empty() { String::new() } else { format!("{}/", first.order()) };
        let says = if first.source.source == SpecSource::OrderList { "names" } else { "is for" };
        let shown = tickets.iter().map(|(late, _)| intake::display_name(late.part_name.as_ref()));
        let mut names: Vec<String> = shown.take(MAX_NAMED).collect();
        let more = tickets.len() - names.len();
        names.extend((more > 0).then(|| format!("and {more} more")));
        let (names, state) = (names.join(", "), part.text(tickets.len()));
        Some(format!("{order}{} {says} {names}, {state}", first.source.file_name))
    };
    of_same_file.filter_map(reason).collect()
}

async fn apply_late_ticket(
    desk: &mut Receiving<'_>,
    machine_name: &str,
    late: &LateTicket,
    parts: &[PartRow],
) -> Result<LateDecision> {
    let Some(machine) = desk.machines.get(machine_name) else { return Ok(LateDecision::Wait) };
    let machine = machine.profile.clone();
    let candidates: Vec<&PartRow> = parts.iter().filter(|part| may_mean(late, part)).collect();
    let mut names: Vec<&str> = candidates.iter().map(|part| part.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let name = match late.find_part(&names) {
        NamedPart::Only(at) => names[at],
        NamedPart::Missing => return await_part(desk, &machine, late, AwaitedPart::Missing).await,
        NamedPart::Several => return Ok(LateDecision::Refuse(several_parts_reason(&names.join(", ")))),
    };
    let ticket = match &late.ticket {
        Ok(ticket) => ticket,
        Err(error) => return Ok(LateDecision::Refuse(format!("{error}."))),
    };
    let named = match of_one_folder(late, candidates.into_iter().filter(|part| part.name == name).collect()) {
        Ok(named) => named,
        Err(reason) => return Ok(LateDecision::Refuse(reason)),
    };
    let Some(newest) = named.iter().max_by_key(|part| part.id) else { return Ok(LateDecision::Wait) };
    let solids: Vec<&&PartRow> = named.iter().filter(|part| part.file.claim == newest.file.claim).collect();
    if solids.iter().any(|part| part.state == PartState::Claimed) {
        return Ok(LateDecision::Wait);
    }
    match newest.state {
        PartState::Refused => return await_part(desk, &machine, late, AwaitedPart::Refused).await,
        // A new file of the name of a part that is printed may still come.
        PartState::Built if !late.is_last_offer => return Ok(LateDecision::AwaitPart(AwaitedPart::Built)),
        _ => {}
    }
    if ticket.copies.is_some() && solids.len() > 1 {
        return Ok(LateDecision::Refuse(several_solids_reason(newest, solids.len())));
    }
    let edit = match ticket_to_edit(ticket, &machine) {
        Ok(edit) => edit,
        Err(reason) => return Ok(LateDecision::Refuse(reason)),
    };
    let received = ticket_row(&late.source);
    for part in solids {
        match desk.shared.ledger.apply_late_ticket(part.id, &edit, &received, late.came_at()).await {
            Ok(None) => {}
            Ok(Some(edited)) if edited.changes.is_empty() => {}
            Ok(Some(edited)) => {
                info!(part.id = %part.id, machine = machine_name, "{} came late and changed part {}: {}.", late.source.file_name, part.id, edited.changes.join(", "));
                mark_note::update_decision_count(desk, part).await;
                if let (true, Some(machine)) = (edit.changes_layout(), desk.machines.get_mut(machine_name)) {
                    machine.open.reset();
                }
            }
            // Once the build is published, the reason says so.
            Err(LedgerError::BeingBuilt { .. }) => return Ok(LateDecision::Wait),
            Err(error) if error.is_trouble() => return Err(error.into()),
            Err(refused) => {
                let reason = late_reason(desk, part, ticket, &refused).await?;
                return Ok(LateDecision::Refuse(reason));
            }
        }
    }
    Ok(LateDecision::Accept(format!("{} (part {})", newest.name, newest.id)))
}

/// A late ticket waits for its file; that of a row that is offered for the last time is missed from now on.
async fn await_part(
    desk: &Receiving<'_>,
    machine: &MachineProfile,
    late: &LateTicket,
    part: AwaitedPart,
) -> Result<LateDecision> {
    record_missing_file(desk, machine, late).await?;
    Ok(LateDecision::AwaitPart(part))
}

/// Whether a ticket may mean a part: one of the order of its folder, or of the order that the ticket itself names.
fn may_mean(late: &LateTicket, part: &PartRow) -> bool {
    let named = late.ticket.as_ref().ok().and_then(|ticket| ticket.order.as_deref());
    let is_of_order = late.may_mean_order(&part.terms.order_name) || named == Some(part.terms.order_name.as_str());
    is_of_order && !is_missing_file(&part.file.claim)
}

/// Parts of one name that a late ticket may mean: those of its own folder, if there are any. Of several in folders below it, none is
/// meant: then the reason.
fn of_one_folder<'p>(late: &LateTicket, mut named: Vec<&'p PartRow>) -> Result<Vec<&'p PartRow>, String> {
    if named.iter().any(|part| part.terms.order_name == late.order()) {
        named.retain(|part| part.terms.order_name == late.order());
    }
    match named.first() {
        Some(first) if named.iter().any(|part| part.terms.order_name != first.terms.order_name) => {
            let place = |part: &&PartRow| format!("part {} ({}/{})", part.id, part.terms.order_name, part.name);
            Err(several_parts_reason(&named.iter().map(place).collect::<Vec<_>>().join(", ")))
        }
        _ => Ok(named),
    }
}

fn several_parts_reason(parts: &str) -> String {
    format!(
        "It came after its part was taken, and it may mean several parts: {parts}. Change the one that is meant with `nestd edit PART`."
    )
}

fn several_solids_reason(part: &PartRow, solids: usize) -> String {
    format!(
        "It came after {} was taken, which holds {solids} solids, so its number of copies cannot be applied any more. Cancel \
         its parts with `nestd cancel {}`, and drop the file again together with this ticket.",
        part.name, part.name
    )
}

/// What became of a part that a ticket cannot change any more, and how to order more of it.
async fn late_reason(desk: &Receiving<'_>, part: &PartRow, ticket: &Ticket, refused: &LedgerError) -> Result<String> {
    let placements = desk.shared.ledger.placements_of_part(part.id).await?;
    let Some(last) = placements.iter().filter(|placed| !placed.is_bad).max_by_key(|placed| placed.build_id) else {
        return Ok(format!("It came after its part was taken: {refused}."));
    };
    let copies = placements.iter().filter(|placed| !placed.is_bad).count() as u32;
    let when = last
        .published_at
        .map_or_else(String::new, |at| format!(", published {}", desk.shared.settings.time_zone.format_minute(at.0)));
    let more = match ticket.copies {
        Some(wanted) if wanted > copies => {
            format!(" Order {} more with `nestd edit {} --copies {wanted}`.", wanted - copies, part.id)
        }
        Some(wanted) if wanted < copies => format!(
            " It asks for fewer: while the build lies in the queue, `nestd withdraw {}` takes it back, and then `nestd edit {} --copies \
             {wanted}` changes it.",
            last.build_id, part.id
        ),
        _ => format!(
            " What differs can be ordered again: drop {} together with this ticket, which prints it once more.",
            part.name
        ),
    };
    let count = build_file::format_count(copies, "copy", "copies");
    Ok(format!("It came too late: {} is in build {}{when} with {count}.{more}", part.name, last.build_id))
}

/// The changes that a ticket asks for.
fn ticket_to_edit(ticket: &Ticket, machine: &MachineProfile) -> Result<PartEdit, String> {
    let due = match ticket.due {
        None => None,
        Some(due) => {
            let at = due
                .to_timestamp(machine.time_zone.time_zone())
                .map_err(|error| format!("Its due date is none here: {error}."))?;
            Some(Some((at, due.to_string())))
        }
    };
    let turning = &machine.turning;
    let is_turned = ticket.orientation.is_some() || ticket.keep_up.is_some() || ticket.not_down.is_some();
    let limits = OrientationLimits::new(
        ticket.orientation.unwrap_or(turning.orientation),
        ticket.keep_up.as_deref().unwrap_or(&turning.keep_up),
        ticket.not_down.as_deref().unwrap_or(&turning.not_down),
    );
    Ok(PartEdit {
        copies: ticket.copies,
        order_name: ticket.order.clone(),
        customer: ticket.customer.clone(),
        email: ticket.email.clone(),
        material: ticket.material.as_deref().map(|word| machine.materials.name_of(word)),
        finish: ticket.finish.clone(),
        priority: ticket.priority,
        due,
        orientation: is_turned.then_some(limits.rule),
        tilts: is_turned.then_some(RequiredTilts(limits.tilts)),
        clearance_mm: ticket.clearance_mm.map(Some),
        unit: ticket.unit,
        note: ticket.note.clone(),
    })
}

/// Said of a ticket that was applied and could not be moved to the archive.
fn applied_reason(meant: &str, failure: &anyhow::Error) -> String {
    format!(
        "It came after its part was taken, and was applied to {meant}: nothing is left to do, and it can be deleted. It is here \
         because it could not be moved to the archive: {failure:#}. Make the archive folder writable for nestd."
    )
}

/// Puts a late ticket where it belongs.
async fn finish(desk: &mut Receiving<'_>, name: &str, late: LateTicket, decision: LateDecision) -> Result<()> {
    let Some(machine) = desk.machines.get(name) else { return Ok(()) };
    let (folders, leases) = (machine.profile.folders.clone(), machine.leases.clone());
    let language = desk.shared.settings.language;
    let job =
        LateTicketJob { machine: name.to_owned(), file_name: late.source.file_name.clone(), key: late.key.clone() };
    match decision {
        LateDecision::Wait | LateDecision::AwaitPart(_) => {}
        LateDecision::Accept(meant) => desk.jobs.start(job, move || {
            let archive = || -> Result<LateTicketEnd> {
                leases.archive.clone().check_usable()?;
                Ok(late.accept_late_ticket(&folders.inbox, &folders.archive)?)
            };
            match archive() {
                // At the next scan it would be refused as one whose part never came.
                Err(failure) if late.is_last_offer && late.source.source == SpecSource::Sidecar => {
                    leases.check_error_folder()?;
                    let reason = applied_reason(&meant, &failure);
                    language.within(|| late.refuse_late_ticket(&folders.inbox, &folders.error, &reason))?;
                    Err(failure.context("it was applied, and is in the error folder now"))
                }
                ended => ended.map(drop),
            }
        }),
        LateDecision::Refuse(reason) => {
            warn!(machine = name, "Refused {} for {}: {reason}", late.source.file_name, late.part_name);
            let detail = format!("{}: {reason}", late.source.file_name);
            desk.shared.ledger.record_file_refusal(name, RefusalCause::Ticket, &detail).await?;
            desk.jobs.start(job, move || {
                leases.check_error_folder()?;
                language.within(|| late.refuse_late_ticket(&folders.inbox, &folders.error, &reason))?;
                Ok(())
            });
        }
    }
    Ok(())
}
