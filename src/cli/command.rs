//! `nestd flush|pause|resume|retry|cancel|scan`: orders by hand, given to the daemon through the ledger.

use std::time::{Duration, Instant};

use anyhow::Result;

use super::{
    Common, Exit,
    reach::{demand_profile, who, with_ledger},
    table::say,
};
use crate::ledger::{CommandId, CommandKind, CommandRow, CommandState, Ledger, NewCommand, PartId};

/// The daemon looks for orders about every second; longer is not worth a person's time.
const PATIENCE: Duration = Duration::from_secs(5);
/// Between two looks for the answer.
const LOOK: Duration = Duration::from_millis(100);

/// What an order is about.
#[derive(Debug, Clone)]
pub enum Order {
    /// Publish what waits in a profile now.
    Flush(String),
    /// Fire no batch in a profile until it is resumed.
    Pause(String),
    /// Let a profile fire again.
    Resume(String),
    /// Take a rejected part back.
    Retry(i64),
    /// Reject a waiting part.
    Cancel(i64),
    /// Look into the hot folders now.
    Scan,
}

impl Order {
    fn kind(&self) -> CommandKind {
        match self {
            Self::Flush(_) => CommandKind::Flush,
            Self::Pause(_) => CommandKind::Pause,
            Self::Resume(_) => CommandKind::Resume,
            Self::Retry(_) => CommandKind::Retry,
            Self::Cancel(_) => CommandKind::Cancel,
            Self::Scan => CommandKind::Scan,
        }
    }

    fn profile(&self) -> Option<&str> {
        match self {
            Self::Flush(profile) | Self::Pause(profile) | Self::Resume(profile) => Some(profile),
            Self::Retry(_) | Self::Cancel(_) | Self::Scan => None,
        }
    }

    fn part(&self) -> Option<PartId> {
        match self {
            Self::Retry(part) | Self::Cancel(part) => Some(PartId(*part)),
            _ => None,
        }
    }
}

/// Gives the order and waits a little for the answer.
pub fn run(common: &Common, order: &Order) -> Result<Exit> {
    let (text, exit) = with_ledger(common, async |settings, ledger| {
        if let Some(profile) = order.profile() {
            demand_profile(settings, profile)?;
        }
        give(ledger, order, PATIENCE).await
    })?;
    say(&text)?;
    Ok(exit)
}

/// What to print, and how the command ends.
pub async fn give(ledger: &Ledger, order: &Order, patience: Duration) -> Result<(String, Exit)> {
    let command = NewCommand {
        kind: order.kind(),
        profile: order.profile().unwrap_or_default().to_owned(),
        part: order.part(),
        asked_by: who(),
    };
    let id = ledger.ask(&command).await?;
    let answered = if is_alive(ledger).await? { answer(ledger, id, patience).await? } else { None };
    let kind = command.kind;
    Ok(match answered {
        Some(row) if row.state == CommandState::Refused => (format!("Refused: {}", row.answer), Exit::Failure),
        Some(row) if row.answer.is_empty() => ("Done.".to_owned(), Exit::Success),
        Some(row) => (row.answer, Exit::Success),
        None if is_alive(ledger).await? => {
            let text = format!(
                "{kind} is noted, but the daemon has not answered yet: it is busy or hangs. `nestd status` says what it does."
            );
            (text, Exit::Failure)
        }
        None => (format!("The daemon does not run; {kind} is noted and will be done when it starts."), Exit::Success),
    })
}

async fn is_alive(ledger: &Ledger) -> Result<bool> {
    Ok(ledger.is_served().await?)
}

/// The answered order, `None` when patience ends before.
async fn answer(ledger: &Ledger, id: CommandId, patience: Duration) -> Result<Option<CommandRow>> {
    let asked = Instant::now();
    loop {
        match ledger.command(id).await? {
            Some(row) if row.state != CommandState::Asked => return Ok(Some(row)),
            _ if asked.elapsed() >= patience => return Ok(None),
            _ => tokio::time::sleep(LOOK).await,
        }
    }
}
