//! `nestd withdraw`: takes a published build back out of the queue, unless its printer was first.

use anyhow::{Context, Result};
use build_file::format_count;
use ledger::{BuildId, Ledger, OperatorWord};

use super::operate::wait_for_take_back;
use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        candidates,
        farm_context::{user_at_host, with_ledger},
        table::print_text,
        values::parse_build_number,
    },
};

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
    let (text, exit) = with_ledger(common, async |settings, ledger| {
        ledger.find_build(id).await?.with_context(|| format!("there is no build {id}"))?;
        let word = OperatorWord::Withdraw(id, args.reason.clone());
        farm::operate(ledger, settings, &word, &user_at_host(), false).await?;
        wait_until_taken_back(ledger, id).await
    })?;
    print_text(&text)?;
    Ok(exit)
}

async fn wait_until_taken_back(ledger: &Ledger, id: BuildId) -> Result<(String, CommandExit)> {
    let Some(build) = wait_for_take_back(ledger, id).await? else {
        let text = format!(
            "Noted: nestd takes build {id} back as soon as it can use the queue folder. `nestd show {id}` says what became of it."
        );
        return Ok((text, CommandExit::Success));
    };
    if build.place.withdrawn_at.is_none() {
        let text = format!(
            "Build {id} stays: its printer took the file first, its outcome was told, or what lies in the queue is not its file \
             (`nestd status` says so). Where it was found at another printer (`nestd show b{id}`), say it once more."
        );
        return Ok((text, CommandExit::Failure));
    }
    let waits = match ledger.copies_of_withdrawal(id).await? {
        0 => "none of its copies waits again".to_owned(),
        copies => format!("{} again, with all that was asked", format_count(copies, "copy waits", "copies wait")),
    };
    let text = format!(
        "Build {id} was taken back out of the queue: {waits}. {0} is paused, so that what waits can be changed or cancelled; \
         `nestd resume {0}` lets it go on.",
        build.machine
    );
    Ok((text, CommandExit::Success))
}
