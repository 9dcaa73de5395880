//! `nestd outcome`: what became of a published build.

use anyhow::Result;

use super::{
    Common, Exit,
    reach::{who, with_ledger},
    table::say,
    values::build_number,
};
use crate::ledger::{BuildId, Outcome};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Build number, as history prints it (4 or b4)
    #[arg(value_parser = build_number)]
    build: i64,
    /// What became of it
    outcome: Told,
    /// A word on it, kept in the history
    #[arg(long, default_value = "", value_name = "TEXT")]
    note: String,
}

/// What an operator tells.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Told {
    /// Printed
    Complete,
    /// The machine stopped before the end
    Interrupted,
    /// The print failed
    Failed,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let outcome = match args.outcome {
        Told::Complete => Outcome::Complete,
        Told::Interrupted => Outcome::Interrupted,
        Told::Failed => Outcome::Failed,
    };
    with_ledger(common, async |_, ledger| {
        Ok(ledger.record_outcome(BuildId(args.build), outcome, &args.note, &who()).await?)
    })?;
    say(&format!("Build {} is {outcome}.", args.build))?;
    Ok(Exit::Success)
}
