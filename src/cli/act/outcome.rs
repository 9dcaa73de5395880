//! `nestd outcome`: records the outcome of a published build.

use anyhow::Result;
use ledger::{BuildId, OperatorWord, PartId, PrintOutcome, ToldOutcome};

use super::operate::say;
use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        candidates,
        farm_context::user_at_host,
        values::{parse_build_number, parse_part_copies},
    },
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct OutcomeArgs {
    /// Build number, as history prints it (4 or b4)
    #[arg(value_parser = parse_build_number, add = candidates::of_builds())]
    build: i64,
    /// Outcome of the print
    outcome: OutcomeChoice,
    /// A remark, kept in the history
    #[arg(long, default_value = "", value_name = "TEXT")]
    note: String,
    /// Copies that are bad although the rest is good: they are printed again (part and number of copies: 7=2, or several: 7=2,9=1)
    #[arg(long, value_name = "PART=N", value_delimiter = ',', value_parser = parse_part_copies)]
    bad: Vec<(i64, u32)>,
    /// Do not print bad copies again
    #[arg(long)]
    keep: bool,
    /// Correct an outcome that was told before; the history keeps both
    #[arg(long)]
    correct: bool,
    /// Also if the file of the build lies in the queue: it is taken out first
    #[arg(long)]
    anyway: bool,
}

/// The outcomes that an operator can record.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum OutcomeChoice {
    /// The print has begun
    Printing,
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
        OutcomeChoice::Printing => PrintOutcome::Printing,
        OutcomeChoice::Complete => PrintOutcome::Complete,
        OutcomeChoice::Interrupted => PrintOutcome::Interrupted,
        OutcomeChoice::Failed => PrintOutcome::Failed,
    };
    let told = ToldOutcome {
        outcome,
        note: args.note.clone(),
        told_by: user_at_host(),
        bad: args.bad.iter().map(|&(part, copies)| (PartId(part), copies)).collect(),
        keep: args.keep,
        is_correction: args.correct,
    };
    say(common, &[OperatorWord::Outcome(BuildId(args.build), told)], args.anyway)
}
