//! `nestd notify`: shows which messages each receiver of `[notify]` has received; with `--test`, sends each a trial
//! message.

use anyhow::Result;
use settings::{NotifySettings, Settings};

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::{load_settings, with_ledger_to_read},
            table::{print_text, print_to_stderr},
        },
    },
    outbox::{configured_receivers, kinds_for, send_trial},
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
    let settings = load_settings(common)?;
    let notify = &settings.interfaces.notify;
    if !notify.is_enabled() {
        print_text("No messages are sent: [notify] names no webhook, no command and no mail server.")?;
        return Ok(CommandExit::Success);
    }
    if args.test { try_receivers(&settings) } else { show_delivery(common, notify) }
}

fn try_receivers(settings: &Settings) -> Result<CommandExit> {
    let mut exit = CommandExit::Success;
    for receiver in configured_receivers(&settings.interfaces.notify) {
        match send_trial(settings, receiver) {
            Ok(done) => print_text(&done)?,
            Err(failure) => {
                let receiver = receiver.noun();
                print_to_stderr(&format!("the {receiver} did not receive the message: {failure:#}"));
                exit = CommandExit::Failure;
            }
        }
    }
    Ok(exit)
}

fn show_delivery(common: &CommonArgs, notify: &NotifySettings) -> Result<CommandExit> {
    let lines = with_ledger_to_read(common, async |settings, ledger| {
        let rows = ledger.list_receivers().await?;
        let mut lines = Vec::new();
        for receiver in configured_receivers(notify) {
            let Some(row) = rows.iter().find(|row| row.name == receiver) else {
                lines.push(format!("{}: receives messages once the daemon runs.", receiver.noun()));
                continue;
            };
            let kinds = kinds_for(row.name, notify);
            let waiting = ledger.count_events_after(row.delivered_id, &kinds).await?;
            let failing = match row.failing_at {
                Some(since) => {
                    format!("; delivery fails since {}: {}", settings.time_zone.format_time(since.0), row.failure)
                }
                None => String::new(),
            };
            lines.push(format!("{}: {waiting} messages wait, {} were dropped{failing}", receiver.noun(), row.dropped));
        }
        Ok(lines.join("\n"))
    })?;
    print_text(&lines)?;
    Ok(CommandExit::Success)
}
