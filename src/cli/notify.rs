//! `nestd notify`: how far the receivers of `[notify]` have been told; with `--test`, a trial message to each.

use anyhow::Result;

use super::{
    Common, Exit,
    reach::{look_at_ledger, settings, zoned},
    table::{say, tell},
};
use crate::{
    outbox::{Message, configured, kinds, send},
    settings::Notify,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Send a trial message to each receiver
    #[arg(long)]
    test: bool,
}

/// Runs the command: exit code 1 when a trial message did not arrive.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let notify = settings(common)?.notify;
    if !notify.is_on() {
        say("Nobody is told: [notify] names neither a webhook nor a command.")?;
        return Ok(Exit::Success);
    }
    if args.test { try_out(&notify) } else { show(common, &notify) }
}

fn try_out(notify: &Notify) -> Result<Exit> {
    let message = Message::trial();
    let mut exit = Exit::Success;
    for receiver in configured(notify) {
        match send(notify, receiver, &message) {
            Ok(()) => say(&format!("The {receiver} has the message {}.", message.id))?,
            Err(failure) => {
                tell(&format!("the {receiver} has not got the message: {failure:#}"));
                exit = Exit::Failure;
            }
        }
    }
    Ok(exit)
}

fn show(common: &Common, notify: &Notify) -> Result<Exit> {
    let kinds = kinds(&notify.events);
    let lines = look_at_ledger(common, async |_, ledger| {
        let rows = ledger.receivers().await?;
        let mut lines = Vec::new();
        for receiver in configured(notify) {
            let Some(row) = rows.iter().find(|row| row.name == receiver) else {
                lines.push(format!("{receiver}: is told of what happens once the daemon runs."));
                continue;
            };
            let waiting = ledger.events_after(row.told_id, &kinds).await?;
            let failing = match row.failing_at {
                Some(since) => format!("; cannot be told since {}: {}", zoned(Some(since)), row.failure),
                None => String::new(),
            };
            lines.push(format!("{receiver}: {waiting} messages wait, {} were dropped{failing}", row.dropped));
        }
        Ok(lines.join("\n"))
    })?;
    say(&lines)?;
    Ok(Exit::Success)
}
