//! Control files (`FLUSH`, `PAUSE`, `RESUME`): each becomes a command, and is removed. `STATUS.txt` shows the answer.

use anyhow::Result;
use intake::{ControlFile, ControlKind};
use jobs::BackgroundJob;
use ledger::{CommandArgument, CommandKind, Ledger, NewCommand};
use tracing::warn;

use crate::core::{desks::Receiving, farm::Farm, machine_state::MachineStates};

/// Removes a control file.
#[derive(Clone)]
pub(crate) struct ControlFileJob {
    key: String,
}

impl BackgroundJob<Farm> for ControlFileJob {
    const KIND: &'static str = "Control";
    type Outcome = Result<()>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.key.clone()
    }

    async fn on_done(self, _desk: Self::Desk<'_>, removed: Self::Outcome) -> Result<()> {
        if let Err(failure) = removed {
            warn!("A control file could not be removed; it is tried again: {failure:#}.");
        }
        Ok(())
    }
}

/// Gives the commands of the control files of a scan, and removes the files.
pub(super) async fn obey_controls(
    desk: &mut Receiving<'_>,
    machine_name: &str,
    controls: Vec<ControlFile>,
) -> Result<()> {
    for control in controls {
        let Some(machine) = desk.machines.get_mut(machine_name) else { return Ok(()) };
        let (inbox, key) = (machine.profile.folders.inbox.clone(), control.key.clone());
        if !machine.inbox.controls.is_obeyed(&key) {
            let name = control.kind.file_name();
            let user = control.owner_uid.map_or_else(String::new, |uid| format!(" of user {uid}"));
            let command = NewCommand {
                kind: command_kind(control.kind),
                machine: machine_name.to_owned(),
                part: None,
                argument: CommandArgument::default(),
                asked_by: format!("file {name}{user}"),
            };
            let id = desk.shared.ledger.submit_command(&command).await?;
            let Some(machine) = desk.machines.get_mut(machine_name) else { return Ok(()) };
            machine.inbox.controls.record_command(key.clone(), id, name);
        }
        desk.jobs.start(ControlFileJob { key }, move || {
            intake::finish_control_file(&inbox, &control)?;
            Ok(())
        });
    }
    Ok(())
}

/// Reads the answers to the last control files, for `STATUS.txt`.
pub(crate) async fn update_answers(ledger: &Ledger, machines: &mut MachineStates) -> Result<()> {
    for machine in machines.values_mut() {
        let controls = &mut machine.inbox.controls;
        let Some((id, name)) = controls.unanswered() else { continue };
        if let Some(row) = ledger.find_command(id).await?
            && row.is_answered()
            && let Some(at) = row.answered_at
        {
            controls.answer = format!("{name}, {}: {}.", machine.profile.time_zone.format_minute(at.0), row.answer);
        }
    }
    Ok(())
}

fn command_kind(kind: ControlKind) -> CommandKind {
    match kind {
        ControlKind::Flush => CommandKind::Flush,
        ControlKind::Pause => CommandKind::Pause,
        ControlKind::Resume => CommandKind::Resume,
    }
}
