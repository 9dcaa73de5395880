//! `nestd notify`: shows which messages each receiver of `[notify]` has received; with `--test`, sends each a trial
//! message.

use anyhow::Result;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::{load_settings, with_ledger_to_read},
            table::{print_text, print_to_stderr},
        },
    },
    outbox::{EventMessage, configured_receivers, event_kinds, send_message},
    settings::NotifySettings,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct NotifyArgs {
    /// Send a trial message to each receiver
    #[arg(long)]
    test: bool,
}

/// Runs the command: exit code 1 when a trial message did not arrive.
pub fn run(common: &CommonArgs, args: &NotifyArgs) -> Result<CommandExit> {
    let notify = load_settings(common)?.interfaces.notify;
    if !notify.is_enabled() {
        print_text("No messages are sent: [notify] names neither a webhook nor a command.")?;
        return Ok(CommandExit::Success);
    }
    if args.test { send_trial(&notify) } else { show_delivery(common, &notify) }
}

fn send_trial(notify: &NotifySettings) -> Result<CommandExit> {
    let message = EventMessage::trial_message();
    let mut exit = CommandExit::Success;
    for receiver in configured_receivers(notify) {
        match send_message(notify, receiver, &message) {
            Ok(()) => print_text(&format!("The {receiver} has the message {}.", message.id))?,
            Err(failure) => {
                print_to_stderr(&format!("the {receiver} did not receive the message: {failure:#}"));
                exit = CommandExit::Failure;
            }
        }
    }
    Ok(exit)
}

fn show_delivery(common: &CommonArgs, notify: &NotifySettings) -> Result<CommandExit> {
    let kinds = event_kinds(&notify.events);
    let lines = with_ledger_to_read(common, async |settings, ledger| {
        let rows = ledger.list_receivers().await?;
        let mut lines = Vec::new();
        for receiver in configured_receivers(notify) {
            let Some(row) = rows.iter().find(|row| row.name == receiver) else {
                lines.push(format!("{receiver}: receives messages once the daemon runs."));
                continue;
            };
            let waiting = ledger.count_events_after(row.delivered_id, &kinds).await?;
            let failing = match row.failing_at {
                Some(since) => {
                    format!("; delivery fails since {}: {}", settings.time_zone.format_time(since.0), row.failure)
                }
                None => String::new(),
            };
            lines.push(format!("{receiver}: {waiting} messages wait, {} were dropped{failing}", row.dropped));
        }
        Ok(lines.join("\n"))
    })?;
    print_text(&lines)?;
    Ok(CommandExit::Success)
}
