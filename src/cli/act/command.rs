//! `nestd flush|pause|resume|retry|mend|cancel|scan|edit|move|confirm`: commands of an operator, sent to the daemon through the ledger.

use std::time::{Duration, Instant};

use anyhow::Result;
use ledger::{CommandArgument, CommandId, CommandKind, CommandRow, CommandState, Ledger, NewCommand, PartEdit, PartId};
use settings::Settings;

use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        farm_context::{require_machine, user_at_host, with_ledger},
        table::print_text,
        target::{PartTarget, find_targets},
    },
};

/// How long the operator waits for the answer. The daemon reads new commands about every second.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);
/// Time between two checks for the answer.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// A command to the daemon.
#[derive(Debug, Clone)]
pub enum DaemonCommand {
    /// Nest and publish the waiting parts of a machine now.
    Flush(String),
    /// Stop a machine from firing batches until it is resumed.
    Pause(String),
    /// Let a machine fire again.
    Resume(String),
    /// Take a refused part back.
    Retry(PartId),
    /// Take a refused part back, and have its mesh mended.
    Mend(PartId),
    /// Refuse a waiting part, or take back some of its copies.
    Cancel(PartId, Option<u32>),
    /// Change what was asked with a part.
    Edit(PartId, Box<PartEdit>),
    /// Move a part to another machine.
    Move(PartId, String),
    /// Print a part as it is.
    Confirm(PartId),
    /// Scan the hot folders now.
    Scan,
}

impl DaemonCommand {
    fn command_kind(&self) -> CommandKind {
        match self {
            Self::Flush(_) => CommandKind::Flush,
            Self::Pause(_) => CommandKind::Pause,
            Self::Resume(_) => CommandKind::Resume,
            Self::Retry(_) | Self::Mend(_) => CommandKind::Retry,
            Self::Cancel(..) => CommandKind::Cancel,
            Self::Edit(..) => CommandKind::Edit,
            Self::Move(..) => CommandKind::Move,
            Self::Confirm(_) => CommandKind::Confirm,
            Self::Scan => CommandKind::Scan,
        }
    }

    fn machine_name(&self) -> Option<&str> {
        match self {
            Self::Flush(machine) | Self::Pause(machine) | Self::Resume(machine) | Self::Move(_, machine) => {
                Some(machine)
            }
            _ => None,
        }
    }

    fn part_id(&self) -> Option<PartId> {
        match self {
            Self::Retry(part)
            | Self::Mend(part)
            | Self::Cancel(part, _)
            | Self::Edit(part, _)
            | Self::Move(part, _)
            | Self::Confirm(part) => Some(*part),
            _ => None,
        }
    }

    fn argument(&self) -> CommandArgument {
        match self {
            Self::Cancel(_, copies) => CommandArgument { copies: *copies, ..CommandArgument::default() },
            Self::Mend(_) => CommandArgument { mend: true, ..CommandArgument::default() },
            Self::Edit(_, edit) => CommandArgument { edit: Some((**edit).clone()), ..CommandArgument::default() },
            _ => CommandArgument::default(),
        }
    }
}

/// Sends the command and waits a few seconds for the answer.
pub fn run(common: &CommonArgs, order: &DaemonCommand) -> Result<CommandExit> {
    let (text, exit) = with_ledger(common, async |settings, ledger| {
        if let Some(machine) = order.machine_name() {
            require_known_machine(settings, ledger, machine).await?;
        }
        send_command(ledger, order, ANSWER_TIMEOUT).await
    })?;
    print_text(&text)?;
    Ok(exit)
}

/// Refuses a machine that neither this node's configuration nor another node has.
async fn require_known_machine(settings: &Settings, ledger: &Ledger, machine: &str) -> Result<()> {
    match ledger.node_of_machine(machine).await? {
        Some(_) if ledger.file().is_none() => Ok(()),
        _ => require_machine(settings, machine),
    }
}

/// Sends a command for each part that the words mean. `again` says how it is said of other words; the exit code tells whether all were done.
pub fn run_for_parts(
    common: &CommonArgs,
    words: &[String],
    again: impl Fn(&str) -> String,
    command: impl Fn(&PartTarget) -> Result<DaemonCommand>,
) -> Result<CommandExit> {
    let (answers, exit) = with_ledger(common, async |settings, ledger| {
        let (mut answers, mut exit) = (Vec::new(), CommandExit::Success);
        for target in find_targets(ledger, words, &again).await? {
            let order = command(&target)?;
            if let Some(machine) = order.machine_name() {
                require_known_machine(settings, ledger, machine).await?;
            }
            let (text, ended) = send_command(ledger, &order, ANSWER_TIMEOUT).await?;
            answers.push(text);
            if ended == CommandExit::Failure {
                exit = CommandExit::Failure;
            }
        }
        Ok((answers, exit))
    })?;
    answers.iter().try_for_each(|text| print_text(text))?;
    Ok(exit)
}

/// Sends the command; returns the text to print and how the program ends.
pub async fn send_command(ledger: &Ledger, order: &DaemonCommand, timeout: Duration) -> Result<(String, CommandExit)> {
    let command = NewCommand {
        kind: order.command_kind(),
        machine: order.machine_name().unwrap_or_default().to_owned(),
        part: order.part_id(),
        argument: order.argument(),
        asked_by: user_at_host(),
    };
    let id = ledger.submit_command(&command).await?;
    let silent = silent_node(ledger, &command).await?;
    let is_heard = silent.is_none() && is_daemon_alive(ledger).await?;
    let answered = if is_heard { wait_for_answer(ledger, id, timeout).await? } else { None };
    let kind = command.kind;
    Ok(match answered {
        Some(row) if row.state == CommandState::Refused => (format!("Refused: {}", row.answer), CommandExit::Failure),
        Some(row) if row.answer.is_empty() => ("Done.".to_owned(), CommandExit::Success),
        Some(row) => (row.answer, CommandExit::Success),
        None if silent.is_some() => {
            let node = silent.unwrap_or_default();
            let text = format!(
                "The node {node}, which serves the machine, does not run; {kind} is noted and will be done when it starts."
            );
            (text, CommandExit::Success)
        }
        None if is_daemon_alive(ledger).await? => {
            let text = format!(
                "{kind} is noted, but the daemon has not answered yet: it is busy or hangs. `nestd status` says what it does."
            );
            (text, CommandExit::Failure)
        }
        None => {
            (format!("The daemon does not run; {kind} is noted and will be done when it starts."), CommandExit::Success)
        }
    })
}

/// The node that would carry a command out, if it does not run.
async fn silent_node(ledger: &Ledger, command: &NewCommand) -> Result<Option<String>> {
    if ledger.file().is_some() {
        return Ok(None);
    }
    let machine = ledger.machine_of_command(command.part, &command.machine).await?;
    let Some(name) = ledger.node_of_machine(&machine).await? else { return Ok(None) };
    let runs = ledger.find_node(&name).await?.is_some_and(|node| node.alive);
    Ok((!runs).then_some(name))
}

async fn is_daemon_alive(ledger: &Ledger) -> Result<bool> {
    Ok(ledger.is_served().await?)
}

/// Waits for the answered command; `None` when the time runs out first.
async fn wait_for_answer(ledger: &Ledger, id: CommandId, timeout: Duration) -> Result<Option<CommandRow>> {
    let began = Instant::now();
    loop {
        match ledger.find_command(id).await? {
            Some(row) if row.is_answered() => return Ok(Some(row)),
            row if began.elapsed() >= timeout => return Ok(row.filter(|row| row.state != CommandState::Asked)),
            _ => tokio::time::sleep(POLL_INTERVAL).await,
        }
    }
}
