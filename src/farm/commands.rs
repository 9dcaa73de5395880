//! Commands of operators, which arrive through the ledger.

use anyhow::Result;
use tracing::info;

use super::{
    alert::AlertKind, claim_completion, farm::Farm, machine_state::MachineStates, mark_note, queues,
    refused_files::CANCELLED,
};
use crate::ledger::Ledger;
use crate::ledger::{CommandId, CommandKind, CommandRow, LedgerError, PartId, PartRow, PartState, RefusalCause};

/// Carries out commands. A flush command is answered when its build has been fired.
pub(super) async fn process_commands(farm: &mut Farm) -> Result<()> {
    let paused = farm.ledger.paused_profiles().await?;
    for (name, machine) in &mut farm.machines {
        machine.paused = paused.contains(name);
    }
    for command in farm.ledger.pending_commands().await? {
        // A command that the disk prevents stays open and does not hold up the others.
        let about = format!("command {}", command.id);
        if farm.schedule.step_backoff.is_waiting(&about) {
            continue;
        }
        match execute_command(farm, &command).await {
            // The command waits for a build or a file.
            Ok(None) => {}
            Ok(Some(answer)) => {
                farm.schedule.step_backoff.record_success(&about);
                farm.alerts.clear(AlertKind::StepFails, &command.profile, &about);
                let done = answer.is_ok();
                let (Ok(text) | Err(text)) = answer;
                farm.ledger.answer_command(command.id, done, &text).await?;
            }
            Err(failure) => {
                farm.report_failure(AlertKind::StepFails, &command.profile, &about, &failure);
                farm.schedule.step_backoff.record_failure(about);
            }
        }
    }
    if farm.machines.values().any(|s| s.queue.opened.is_none()) {
        queues::open_queues(farm).await?;
    }
    Ok(())
}

async fn execute_command(farm: &mut Farm, command: &CommandRow) -> Result<Option<Result<String, String>>> {
    let name = command.profile.as_str();
    let needs_profile = matches!(command.kind, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume);
    if needs_profile && !farm.machines.contains_key(name) {
        return Ok(Some(Err(format!("there is no profile {name}"))));
    }
    Ok(Some(match command.kind {
        CommandKind::Flush => return Ok(request_flush(&mut farm.machines, name, command.id)),
        CommandKind::Pause => match farm.ledger.pause_profile(name, &command.asked_by).await? {
            true => Ok(format!("{name} is paused")),
            false => Ok(format!("{name} was paused already")),
        },
        CommandKind::Resume => match farm.ledger.resume_profile(name, &command.asked_by).await? {
            true => Ok(format!("{name} runs again")),
            false => Ok(format!("{name} was not paused")),
        },
        CommandKind::Scan => {
            let now = farm.now();
            farm.machines.values_mut().for_each(|s| s.inbox.look_at = now);
            Ok("the hot folders are being looked through".to_owned())
        }
        CommandKind::Retry | CommandKind::Cancel => match command.part_id {
            Some(part) => return execute_part_command(farm, command, part).await,
            None => Err("no part was named".to_owned()),
        },
    }))
}

fn request_flush(machines: &mut MachineStates, name: &str, id: CommandId) -> Option<Result<String, String>> {
    let machine = machines.get_mut(name)?;
    if machine.paused {
        machine.pending_flushes.retain(|&waits| waits != id);
        return Some(Err(format!("{name} is paused; resume it first")));
    }
    if !machine.pending_flushes.contains(&id) {
        machine.pending_flushes.push(id);
    }
    None
}

async fn execute_part_command(
    farm: &mut Farm,
    command: &CommandRow,
    part: PartId,
) -> Result<Option<Result<String, String>>> {
    let Some(row) = farm.ledger.find_part(part).await? else {
        return Ok(Some(Err(format!("there is no part {part}"))));
    };
    if claim_completion::is_completing(&farm.completion, &farm.jobs, &row) {
        return Ok(None);
    }
    let done = match command.kind {
        CommandKind::Retry if row.has_unknown_copies() => {
            let refused = format!("the ticket of part {part} could not be read: mend it and drop both again");
            return Ok(Some(Err(refused)));
        }
        CommandKind::Retry => match farm.ledger.retry_part(part).await {
            Ok(()) => {
                mark_note::update_decision_count(farm, &row).await;
                Ok(format!("part {part} is read again"))
            }
            Err(refused) => Err(refused),
        },
        _ => match cancel_part(farm, &row, command).await {
            Ok(false) => return Ok(None),
            Ok(true) => Ok(format!("part {part} is cancelled")),
            Err(refused) => Err(refused),
        },
    };
    match done {
        Ok(done) => {
            info!(part.id = %part, asked_by = %command.asked_by, "A command was carried out: {done}.");
            Ok(Some(Ok(done)))
        }
        // The disk or the database failed: the command stays open and is retried.
        Err(error @ (LedgerError::Sql(_) | LedgerError::ReadOnly)) => Err(error.into()),
        Err(refused) => Ok(Some(Err(refused.to_string()))),
    }
}

/// The copy is in the error folder before the ledger says so: after a crash in between, the command is carried out
/// again. `false` = the copy is being made, and the command is answered afterwards.
async fn cancel_part(farm: &mut Farm, row: &PartRow, command: &CommandRow) -> Result<bool, LedgerError> {
    farm.ledger.ensure_cancellable(row.id).await?;
    let reason = format!("{CANCELLED}{}.", command.asked_by);
    if row.state == PartState::Waiting && farm.machines.contains_key(&row.profile) {
        claim_completion::start_refusal(farm, row.clone(), RefusalCause::Cancelled, &reason, Some(command));
        return Ok(false);
    }
    farm.ledger.cancel_part(row.id, RefusalCause::Cancelled, &reason).await?;
    mark_note::update_decision_count(farm, row).await;
    Ok(true)
}

/// Answers commands that were waiting for something.
pub(super) async fn answer_commands(ledger: &Ledger, commands: &[CommandId], text: &str) -> Result<()> {
    for &command in commands {
        ledger.answer_command(command, true, text).await?;
    }
    Ok(())
}
