//! Orders by hand: what operators asked for through the ledger.

use anyhow::Result;
use tracing::info;

use super::{attention::Attention, farm::Farm, refused::CANCELLED};
use crate::ledger::{CommandId, CommandKind, CommandRow, LedgerError, PartId, PartRow, PartState, Refusal};

impl Farm {
    /// Carries out what was asked; an order to publish is answered when its build has been fired.
    pub(super) async fn orders(&mut self) -> Result<()> {
        let paused = self.ledger.paused().await?;
        for (name, station) in &mut self.stations {
            station.paused = paused.contains(name);
        }
        for command in self.ledger.asked().await? {
            // An order that the disk hinders stays open and keeps no other from being carried out.
            let about = format!("order {}", command.id);
            if self.schedule.steps.rests(&about) {
                continue;
            }
            match self.order(&command).await {
                // It waits for something: a build, a file.
                Ok(None) => {}
                Ok(Some(answer)) => {
                    self.schedule.steps.done(&about);
                    self.notices.clear(Attention::StepFails, &command.profile, &about);
                    let done = answer.is_ok();
                    let (Ok(text) | Err(text)) = answer;
                    self.ledger.answer(command.id, done, &text).await?;
                }
                Err(failure) => {
                    self.trouble(Attention::StepFails, &command.profile, &about, &failure);
                    self.schedule.steps.failed(about);
                }
            }
        }
        if self.stations.values().any(|s| s.queue.opened.is_none()) {
            self.open_queues().await?;
        }
        Ok(())
    }

    async fn order(&mut self, command: &CommandRow) -> Result<Option<Result<String, String>>> {
        let name = command.profile.as_str();
        let needs_profile = matches!(command.kind, CommandKind::Flush | CommandKind::Pause | CommandKind::Resume);
        if needs_profile && !self.stations.contains_key(name) {
            return Ok(Some(Err(format!("there is no profile {name}"))));
        }
        Ok(Some(match command.kind {
            CommandKind::Flush => return Ok(self.flush(name, command.id)),
            CommandKind::Pause => match self.ledger.pause(name, &command.asked_by).await? {
                true => Ok(format!("{name} is paused")),
                false => Ok(format!("{name} was paused already")),
            },
            CommandKind::Resume => match self.ledger.resume(name, &command.asked_by).await? {
                true => Ok(format!("{name} runs again")),
                false => Ok(format!("{name} was not paused")),
            },
            CommandKind::Scan => {
                let now = self.now();
                self.stations.values_mut().for_each(|s| s.inbox.look_at = now);
                Ok("the hot folders are being looked through".to_owned())
            }
            CommandKind::Retry | CommandKind::Cancel => match command.part_id {
                Some(part) => return self.about_part(command, part).await,
                None => Err("no part was named".to_owned()),
            },
        }))
    }

    fn flush(&mut self, name: &str, id: CommandId) -> Option<Result<String, String>> {
        let station = self.stations.get_mut(name)?;
        if station.paused {
            station.flush.retain(|&waits| waits != id);
            return Some(Err(format!("{name} is paused; resume it first")));
        }
        if !station.flush.contains(&id) {
            station.flush.push(id);
        }
        None
    }

    async fn about_part(&mut self, command: &CommandRow, part: PartId) -> Result<Option<Result<String, String>>> {
        let Some(row) = self.ledger.part(part).await? else { return Ok(Some(Err(format!("there is no part {part}")))) };
        if self.is_ending(&row) {
            return Ok(None);
        }
        let done = match command.kind {
            CommandKind::Retry if row.has_unknown_copies() => {
                let refused = format!("the ticket of part {part} could not be read: mend it and drop both again");
                return Ok(Some(Err(refused)));
            }
            CommandKind::Retry => match self.ledger.retry(part).await {
                Ok(()) => {
                    self.mark_decided(&row).await;
                    Ok(format!("part {part} is read again"))
                }
                Err(refused) => Err(refused),
            },
            _ => match self.cancel(&row, command).await {
                Ok(false) => return Ok(None),
                Ok(true) => Ok(format!("part {part} is cancelled")),
                Err(refused) => Err(refused),
            },
        };
        match done {
            Ok(done) => {
                info!(part.id = %part, asked_by = %command.asked_by, "An order by hand: {done}.");
                Ok(Some(Ok(done)))
            }
            // The disk or the database failed: the order stays open and is tried again.
            Err(error @ (LedgerError::Sql(_) | LedgerError::ReadOnly)) => Err(error.into()),
            Err(refused) => Ok(Some(Err(refused.to_string()))),
        }
    }

    /// The copy is in the error folder before the ledger says so: after a crash between, the order is carried out again.
    /// `false` = it is being copied; the order is answered after that.
    async fn cancel(&mut self, row: &PartRow, command: &CommandRow) -> Result<bool, LedgerError> {
        self.ledger.demand_cancellable(row.id).await?;
        let reason = format!("{CANCELLED}{}.", command.asked_by);
        if row.state == PartState::Waiting && self.stations.contains_key(&row.profile) {
            self.begin_leaving(row.clone(), Refusal::Cancelled, &reason, Some(command));
            return Ok(false);
        }
        self.ledger.cancel(row.id, Refusal::Cancelled, &reason).await?;
        self.mark_decided(row).await;
        Ok(true)
    }

    /// Answers orders that were waiting for something.
    pub(super) async fn answer(&self, commands: &[CommandId], text: &str) -> Result<()> {
        for &command in commands {
            self.ledger.answer(command, true, text).await?;
        }
        Ok(())
    }
}
