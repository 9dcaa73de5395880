//! Commands of operators, which arrive through the ledger.

use anyhow::Result;
use tracing::info;

use super::{alert::AlertKind, farm::Farm, refused_files::CANCELLED};
use crate::ledger::{CommandId, CommandKind, CommandRow, LedgerError, PartId, PartRow, PartState, RefusalCause};

impl Farm {
    /// Carries out commands. A flush command is answered when its build has been fired.
    pub(super) async fn process_commands(&mut self) -> Result<()> {
        let paused = self.ledger.paused_profiles().await?;
        for (name, station) in &mut self.machines {
            station.paused = paused.contains(name);
        }
        for command in self.ledger.pending_commands().await? {
            // A command that the disk prevents stays open and does not hold up the others.
            let about = format!("order {}", command.id);
            if self.schedule.step_backoff.is_waiting(&about) {
                continue;
            }
            match self.execute_command(&command).await {
                // The command waits for a build or a file.
                Ok(None) => {}
                Ok(Some(answer)) => {
                    self.schedule.step_backoff.record_success(&about);
                    self.alerts.clear(AlertKind::StepFails, &command.profile, &about);
                    let done = answer.is_ok();
                    let (Ok(text) | Err(text)) = answer;
                    self.ledger.answer_command(command.id, done, &text).await?;
                }
                Err(failure) => {
                    self.report_failure(AlertKind::StepFails, &command.profile, &about, &failure);
                    self.schedule.step_backoff.record_failure(about);
                }
            }
        }
        if self.machines.values().any(|s| s.queue.opened.is_none()) {
            self.open_queues().await?;
        }
        Ok(())
    }

    async fn execute_command(&mut self, command: &CommandRow) -> Result<Option<Result<String, String>>> {
        let name = command.profile.as_str();
        let needs_profile = matches!(command.kind, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume);
        if needs_profile && !self.machines.contains_key(name) {
            return Ok(Some(Err(format!("there is no profile {name}"))));
        }
        Ok(Some(match command.kind {
            CommandKind::Flush => return Ok(self.request_flush(name, command.id)),
            CommandKind::Pause => match self.ledger.pause_profile(name, &command.asked_by).await? {
                true => Ok(format!("{name} is paused")),
                false => Ok(format!("{name} was paused already")),
            },
            CommandKind::Resume => match self.ledger.resume_profile(name, &command.asked_by).await? {
                true => Ok(format!("{name} runs again")),
                false => Ok(format!("{name} was not paused")),
            },
            CommandKind::Scan => {
                let now = self.now();
                self.machines.values_mut().for_each(|s| s.inbox.look_at = now);
                Ok("the hot folders are being looked through".to_owned())
            }
            CommandKind::Retry | CommandKind::Cancel => match command.part_id {
                Some(part) => return self.execute_part_command(command, part).await,
                None => Err("no part was named".to_owned()),
            },
        }))
    }

    fn request_flush(&mut self, name: &str, id: CommandId) -> Option<Result<String, String>> {
        let station = self.machines.get_mut(name)?;
        if station.paused {
            station.pending_flushes.retain(|&waits| waits != id);
            return Some(Err(format!("{name} is paused; resume it first")));
        }
        if !station.pending_flushes.contains(&id) {
            station.pending_flushes.push(id);
        }
        None
    }

    async fn execute_part_command(
        &mut self,
        command: &CommandRow,
        part: PartId,
    ) -> Result<Option<Result<String, String>>> {
        let Some(row) = self.ledger.find_part(part).await? else {
            return Ok(Some(Err(format!("there is no part {part}"))));
        };
        if self.is_completing(&row) {
            return Ok(None);
        }
        let done = match command.kind {
            CommandKind::Retry if row.has_unknown_copies() => {
                let refused = format!("the ticket of part {part} could not be read: mend it and drop both again");
                return Ok(Some(Err(refused)));
            }
            CommandKind::Retry => match self.ledger.retry_part(part).await {
                Ok(()) => {
                    self.update_decision_count(&row).await;
                    Ok(format!("part {part} is read again"))
                }
                Err(refused) => Err(refused),
            },
            _ => match self.cancel_part(&row, command).await {
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
    async fn cancel_part(&mut self, row: &PartRow, command: &CommandRow) -> Result<bool, LedgerError> {
        self.ledger.ensure_cancellable(row.id).await?;
        let reason = format!("{CANCELLED}{}.", command.asked_by);
        if row.state == PartState::Waiting && self.machines.contains_key(&row.profile) {
            self.start_refusal(row.clone(), RefusalCause::Cancelled, &reason, Some(command));
            return Ok(false);
        }
        self.ledger.cancel_part(row.id, RefusalCause::Cancelled, &reason).await?;
        self.update_decision_count(row).await;
        Ok(true)
    }

    /// Answers commands that were waiting for something.
    pub(super) async fn answer_commands(&self, commands: &[CommandId], text: &str) -> Result<()> {
        for &command in commands {
            self.ledger.answer_command(command, true, text).await?;
        }
        Ok(())
    }
}
