//! `nestd withdraw`: takes a published build back out of the queue, unless its printer was first.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use build_file::format_count;

use super::{
    CommandExit, CommonArgs, candidates,
    farm_context::{user_at_host, with_ledger},
    table::print_text,
    values::parse_build_number,
};
use crate::ledger::{BuildId, Ledger};

/// How long the operator waits until the file is taken back.
const TAKEN_BACK_TIMEOUT: Duration = Duration::from_secs(10);
/// Time between two looks.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct WithdrawArgs {
    /// Build number, as status prints it (4 or b4)
    #[arg(value_parser = parse_build_number, add = candidates::of_builds())]
    build: i64,
    /// Why
    #[arg(long, default_value = "", value_name = "TEXT")]
    reason: String,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &WithdrawArgs) -> Result<CommandExit> {
    let id = BuildId(args.build);
    let (text, exit) = with_ledger(common, async |_, ledger| {
        ledger.find_build(id).await?.with_context(|| format!("there is no build {id}"))?;
        ledger.begin_withdrawal(id, &user_at_host(), &args.reason).await?;
        wait_until_taken_back(ledger, id).await
    })?;
    print_text(&text)?;
    Ok(exit)
}

async fn wait_until_taken_back(ledger: &Ledger, id: BuildId) -> Result<(String, CommandExit)> {
    let until = Instant::now() + TAKEN_BACK_TIMEOUT;
    loop {
        let build = ledger.find_build(id).await?.with_context(|| format!("there is no build {id}"))?;
        if build.place.withdrawn_at.is_some() {
            let copies = format_count(build.measures.copies.unwrap_or(0), "copy waits", "copies wait");
            let text = format!(
                "Build {id} was taken back out of the queue: its {copies} again, with all that was asked. {0} is paused, so that \
                 they can be changed or cancelled; `nestd resume {0}` lets it go on.",
                build.profile
            );
            return Ok((text, CommandExit::Success));
        }
        if build.place.withdraw_by.is_none() {
            let text = format!("Build {id} stays: its printer took the file first, or its outcome was told.");
            return Ok((text, CommandExit::Failure));
        }
        if Instant::now() >= until {
            let text = format!(
                "Noted: nestd takes build {id} back as soon as it can use the queue folder. `nestd show {id}` says what became of it."
            );
            return Ok((text, CommandExit::Success));
        }
        tokio::time::sleep(POLL_INTERVAL).await;
    }
}
