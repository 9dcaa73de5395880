//! Commands that change what was asked with a part: edit, move, confirm, and cancel for some of its copies.

use anyhow::Result;
use ledger::{CommandArgument, CommandKind, CommandRow, LedgerError, PartEdit, PartId, PartRow, PartState};

use super::fetch_originals;
use crate::{
    core::{command_answer::CommandAnswer, desks::Receiving},
    receive::{deferred_refusal, intake_jobs::PartReadJob, mark_note},
};

/// Carries out a command that changes a part; `None` = it waits, because the part is being read or moved.
pub(crate) async fn execute_change(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    argument: CommandArgument,
    row: &PartRow,
) -> Result<Option<CommandAnswer>> {
    if row.state == PartState::Claimed {
        // Its solids are not known yet. It is read within moments, or refused, unless its file is asked for.
        return Ok(row.times.damaged_at.map(|_| CommandAnswer::FileMissing(row.id)));
    }
    let done = match command.kind {
        CommandKind::Edit => edit_part(desk, command, argument.edit.unwrap_or_default(), row).await,
        CommandKind::Move if leaves_before_release(desk, command, row).await? => return Ok(None),
        CommandKind::Move => move_part(desk, command, row).await,
        CommandKind::Confirm => confirm_part(desk, command, row.id).await,
        _ => return Ok(None),
    };
    match done {
        Ok(answer) => {
            mark_note::update_decision_count(desk, row).await;
            fetch_originals::fetch_originals(desk).await?;
            Ok(Some(answer))
        }
        // The disk or the database failed: the command stays open and is retried.
        Err(error) if error.is_trouble() => Err(error.into()),
        Err(refused) => Ok(Some(CommandAnswer::NotAllowed(refused))),
    }
}

async fn edit_part(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    mut edit: PartEdit,
    row: &PartRow,
) -> Result<CommandAnswer, LedgerError> {
    if let Some(material) = &mut edit.material {
        *material = desk.shared.settings.materials.require_name(material)?;
    }
    let edited = desk.shared.ledger.for_command(command.id).edit_part(row.id, &edit, &command.asked_by).await?;
    if edit.changes_layout() {
        forget_layout(desk, &row.machine);
    }
    Ok(CommandAnswer::PartEdited(row.id, edited.changes))
}

/// Whether a part is to go to another node before its original was released here, which only this node can do.
async fn leaves_before_release(desk: &Receiving<'_>, command: &CommandRow, row: &PartRow) -> Result<bool, LedgerError> {
    let is_released = deferred_refusal::is_without_original(desk.completion, row);
    Ok(!is_released
        && desk.machines.contains_key(&row.machine)
        && !desk.machines.contains_key(&command.machine)
        && desk
            .shared
            .ledger
            .node_of_machine(&command.machine)
            .await?
            .is_some_and(|node| node != desk.shared.settings.node.name))
}

async fn move_part(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    row: &PartRow,
) -> Result<CommandAnswer, LedgerError> {
    let machine = &command.machine;
    let is_own = desk.machines.contains_key(machine);
    if !is_own
        && desk.shared.ledger.node_of_machine(machine).await?.is_none_or(|node| node == desk.shared.settings.node.name)
    {
        return Ok(CommandAnswer::UnknownMachine(machine.clone()));
    }
    if *machine == row.machine {
        return Ok(CommandAnswer::PartIsThere(row.id, machine.clone()));
    }
    let parts =
        desk.shared.ledger.for_command(command.id).move_to_machine(row.id, machine, !is_own, &command.asked_by).await?;
    forget_layout(desk, &row.machine);
    Ok(CommandAnswer::PartMoved(parts, machine.clone()))
}

async fn confirm_part(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    part: PartId,
) -> Result<CommandAnswer, LedgerError> {
    Ok(match desk.shared.ledger.for_command(command.id).confirm_part(part, &command.asked_by).await? {
        true => CommandAnswer::PartConfirmed(part),
        false => CommandAnswer::NothingToConfirm(part),
    })
}

/// Takes back some of a part's copies; `None` = all of them, which is the cancellation of the part.
pub(crate) async fn cancel_copies(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    copies: Option<u32>,
    row: &PartRow,
) -> Result<Option<CommandAnswer>, LedgerError> {
    let Some(copies) = copies else { return Ok(None) };
    let waiting = desk.shared.ledger.waiting_copies_of(row.id).await?;
    // The whole part goes to the error folder, as it does when it is cancelled without a number.
    if copies == waiting && row.wanted_copies() == waiting {
        return Ok(None);
    }
    desk.shared.ledger.for_command(command.id).cancel_copies(row.id, copies, &command.asked_by).await?;
    mark_note::update_decision_count(desk, row).await;
    Ok(Some(CommandAnswer::CopiesCancelled(row.id, copies)))
}

/// The layout of the open build was made for other rules: the next search starts anew.
fn forget_layout(desk: &mut Receiving<'_>, name: &str) {
    if let Some(machine) = desk.machines.get_mut(name) {
        machine.open.reset();
    }
}

/// Whether a job reads a part again, and may remove from the error folder what was refused of it: nothing may refuse the part
/// meanwhile.
pub(crate) fn is_read_again(desk: &Receiving<'_>, part: &PartRow) -> bool {
    desk.jobs.is_running::<PartReadJob>(part.id) && deferred_refusal::is_without_original(desk.completion, part)
}
