//! Commands of operators, which arrive through the ledger.

use anyhow::Result;
use ledger::{
    CommandId, CommandKind, CommandRow, Ledger, LedgerError, PartId, PartRow, PartState, PauseCause, RefusalCause,
    is_missing_file,
};
use tracing::info;

use crate::{
    again::part_changes,
    alerts::alert::AlertKind,
    core::{command_answer::CommandAnswer, desks::Receiving, machine_state::MachineStates},
    printers::{printers, queues},
    receive::{claim_completion, deferred_refusal, mark_note},
};

/// Carries out commands. A flush command is answered when its build has been fired.
pub(crate) async fn process_commands(desk: &mut Receiving<'_>) -> Result<()> {
    let paused = desk.shared.ledger.paused_machines().await?;
    for (name, machine) in desk.machines.iter_mut() {
        machine.paused = paused.contains(name);
    }
    printers::update_down_printers(desk.shared.ledger, desk.machines).await?;
    for command in desk.shared.ledger.pending_commands().await? {
        // A command that the disk prevents stays open and does not hold up the others.
        let about = format!("command {}", command.id);
        if !concerns_this_node(desk, &command).await? || desk.shared.schedule.step_backoff.is_waiting(&about) {
            continue;
        }
        match execute_command(desk, &command).await {
            // The command waits for a build or a file.
            Ok(None) => {}
            Ok(Some(answer)) => {
                desk.shared.schedule.step_backoff.record_success(&about);
                desk.shared.alerts.clear(AlertKind::StepFails, &command.machine, &about);
                answer_command(desk.shared.ledger, command.id, &answer).await?;
            }
            Err(failure) => {
                desk.shared.report_failure(AlertKind::StepFails, &command.machine, &about, &failure);
                desk.shared.schedule.step_backoff.record_failure(about);
            }
        }
    }
    if desk.machines.values().any(|machine| !machine.printers.are_all_open()) {
        queues::open_queues(&mut desk.serving()).await?;
    }
    Ok(())
}

/// Whether this node carries out a command: the one that serves its machine does, or the first node where none serves it.
async fn concerns_this_node(desk: &Receiving<'_>, command: &CommandRow) -> Result<bool> {
    if desk.shared.ledger.file().is_some() {
        return Ok(true);
    }
    let machine = desk.shared.ledger.machine_of_command(command.part_id, &command.machine).await?;
    if desk.machines.contains_key(&machine) {
        return Ok(true);
    }
    match desk.shared.ledger.node_of_machine(&machine).await? {
        Some(node) => Ok(node == desk.shared.settings.node.name),
        None => Ok(desk.shared.ledger.is_first_node(&desk.shared.settings.node.name).await?),
    }
}

/// Carries out a command; `None` = it is answered later.
async fn execute_command(desk: &mut Receiving<'_>, command: &CommandRow) -> Result<Option<CommandAnswer>> {
    let name = command.machine.as_str();
    let needs_machine = matches!(command.kind, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume);
    if needs_machine && !desk.machines.contains_key(name) {
        return Ok(Some(CommandAnswer::UnknownMachine(name.to_owned())));
    }
    Ok(Some(match command.kind {
        CommandKind::Flush => return Ok(request_flush(desk.machines, name, command.id)),
        CommandKind::Pause => {
            match desk.shared.ledger.pause_machine(name, &command.asked_by, PauseCause::Person).await? {
                true => CommandAnswer::Paused(name.to_owned()),
                false => CommandAnswer::PausedAlready(name.to_owned()),
            }
        }
        CommandKind::Resume => match desk.shared.ledger.resume_machine(name, &command.asked_by).await? {
            true => CommandAnswer::Resumed(name.to_owned()),
            false => CommandAnswer::NotPaused(name.to_owned()),
        },
        CommandKind::Scan => {
            let now = desk.shared.now();
            desk.machines.values_mut().for_each(|s| s.inbox.next_scan_at = now);
            CommandAnswer::ScanStarted
        }
        CommandKind::Retry | CommandKind::Cancel | CommandKind::Edit | CommandKind::Move | CommandKind::Confirm => {
            match command.part_id {
                Some(part) => return execute_part_command(desk, command, part).await,
                None => CommandAnswer::NoPartNamed,
            }
        }
    }))
}

fn request_flush(machines: &mut MachineStates, name: &str, id: CommandId) -> Option<CommandAnswer> {
    let machine = machines.get_mut(name)?;
    if machine.paused {
        machine.pending_flushes.retain(|&waits| waits != id);
        return Some(CommandAnswer::MachinePaused(name.to_owned()));
    }
    if machine.printers.are_all_down()
        && let Some(printer) = machine.printers.0.first()
    {
        machine.pending_flushes.retain(|&waits| waits != id);
        return Some(CommandAnswer::NoPrinterInUse(name.to_owned(), printer.name.clone()));
    }
    if !machine.pending_flushes.contains(&id) {
        machine.pending_flushes.push(id);
    }
    None
}

async fn execute_part_command(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    part: PartId,
) -> Result<Option<CommandAnswer>> {
    let Some(argument) = command.read_argument() else { return Ok(Some(CommandAnswer::OtherVersion)) };
    let Some(row) = desk.shared.ledger.find_part(part).await? else {
        return Ok(Some(CommandAnswer::UnknownPart(part)));
    };
    if claim_completion::is_completing(desk.completion, desk.jobs, &row)
        || part_changes::is_read_again(desk, &row)
        // The copy in the error folder is made of the stored file.
        || command.kind == CommandKind::Cancel && row.owed.is_being_fetched()
    {
        return Ok(None);
    }
    if matches!(command.kind, CommandKind::Edit | CommandKind::Move | CommandKind::Confirm) {
        return part_changes::execute_change(desk, command, argument, &row).await;
    }
    let done = match command.kind {
        CommandKind::Retry if row.has_unknown_copies() => return Ok(Some(CommandAnswer::CopiesUnknown(part))),
        CommandKind::Retry if is_missing_file(&row.file.claim) => return Ok(Some(CommandAnswer::FileMissing(part))),
        CommandKind::Cancel if is_missing_file(&row.file.claim) => {
            let reason = format!("Cancelled by {}.", command.asked_by);
            let ledger = desk.shared.ledger.for_command(command.id);
            ledger.cancel_missing_file(part, &reason).await.map(|()| CommandAnswer::PartCancelled(part))
        }
        CommandKind::Retry => take_back(desk, command, argument.mend, &row).await,
        _ => match part_changes::cancel_copies(desk, command, argument.copies, &row).await {
            Ok(Some(answer)) => Ok(answer),
            Ok(None) => match cancel_part(desk, &row, command).await {
                Ok(false) => return Ok(None),
                Ok(true) => Ok(CommandAnswer::PartCancelled(part)),
                Err(refused) => Err(refused),
            },
            Err(refused) => Err(refused),
        },
    };
    match done {
        Ok(done) => {
            info!(part.id = %part, asked_by = %command.asked_by, "A command was carried out: {done}.");
            Ok(Some(done))
        }
        // The disk or the database failed: the command stays open and is retried.
        Err(error) if error.is_trouble() => Err(error.into()),
        Err(refused) => {
            if command.kind == CommandKind::Cancel {
                deferred_refusal::remove_stray_copy(desk, &row, &refused);
            }
            Ok(Some(CommandAnswer::NotAllowed(refused)))
        }
    }
}

/// A refused part is read again, and mended if the command says so.
async fn take_back(
    desk: &mut Receiving<'_>,
    command: &CommandRow,
    is_mended: bool,
    row: &PartRow,
) -> Result<CommandAnswer, LedgerError> {
    let is_mesh = matches!(row.refused.refusal, Some(RefusalCause::NotClosed | RefusalCause::Mendable));
    if is_mended && row.state == PartState::Refused && !is_mesh {
        return Ok(CommandAnswer::NothingToMend(row.id));
    }
    let ledger = desk.shared.ledger.for_command(command.id);
    match is_mended {
        true => ledger.mend_part(row.id, &command.asked_by).await?,
        false => ledger.retry_part(row.id).await?,
    }
    mark_note::update_decision_count(desk, row).await;
    Ok(if is_mended { CommandAnswer::PartMended(row.id) } else { CommandAnswer::PartRetried(row.id) })
}

/// The copy is in the error folder before the ledger says so: after a crash in between, the command is carried out
/// again. `false` = the copy is being made, and the command is answered afterwards.
async fn cancel_part(desk: &mut Receiving<'_>, row: &PartRow, command: &CommandRow) -> Result<bool, LedgerError> {
    desk.shared.ledger.ensure_cancellable(row.id).await?;
    let reason = format!("Cancelled by {}.", command.asked_by);
    if matches!(row.state, PartState::Waiting | PartState::Claimed) && desk.machines.contains_key(&row.machine) {
        deferred_refusal::start_refusal(desk, row.clone(), RefusalCause::Cancelled, &reason, Some(command));
        return Ok(false);
    }
    desk.shared.ledger.for_command(command.id).cancel_part(row.id, RefusalCause::Cancelled, &reason).await?;
    mark_note::update_decision_count(desk, row).await;
    Ok(true)
}

/// Answers a command.
pub(crate) async fn answer_command(ledger: &Ledger, command: CommandId, answer: &CommandAnswer) -> Result<()> {
    Ok(ledger.answer_command(command, answer.is_done(), &answer.to_string()).await?)
}
