//! `nestd outcome`: records the outcome of a published build.

use anyhow::Result;

use super::{
    CommandExit, CommonArgs,
    farm_context::{user_at_host, with_ledger},
    table::print_text,
    values::parse_build_number,
};
use crate::ledger::{BuildId, PrintOutcome};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct OutcomeArgs {
    /// Build number, as history prints it (4 or b4)
    #[arg(value_parser = parse_build_number)]
    build: i64,
    /// Outcome of the print
    outcome: OutcomeChoice,
    /// A remark, kept in the history
    #[arg(long, default_value = "", value_name = "TEXT")]
    note: String,
}

/// The outcomes that an operator can record.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum OutcomeChoice {
    /// Printed
    Complete,
    /// The machine stopped before the end
    Interrupted,
    /// The print failed
    Failed,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &OutcomeArgs) -> Result<CommandExit> {
    let outcome = match args.outcome {
        OutcomeChoice::Complete => PrintOutcome::Complete,
        OutcomeChoice::Interrupted => PrintOutcome::Interrupted,
        OutcomeChoice::Failed => PrintOutcome::Failed,
    };
    with_ledger(common, async |_, ledger| {
        Ok(ledger.record_outcome(BuildId(args.build), outcome, &args.note, &user_at_host()).await?)
    })?;
    print_text(&format!("Build {} is {outcome}.", args.build))?;
    Ok(CommandExit::Success)
}
