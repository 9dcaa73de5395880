//! `nestd ledger`: moves the ledger between a file and a PostgreSQL database.

use std::path::PathBuf;

use anyhow::{Context, Result};
use ledger::LedgerAddress;

use crate::cli::{CommandExit, UsageError, terminal::table::print_text};

/// What `nestd ledger` does.
#[derive(Debug, clap::Subcommand)]
pub enum LedgerCommand {
    /// Copy a ledger that no daemon serves into an empty one, and compare both
    Copy(LedgerCopyArgs),
}

/// Arguments of `nestd ledger copy`.
#[derive(Debug, clap::Args)]
pub struct LedgerCopyArgs {
    /// The ledger to copy: a file, or postgres://user@host/database
    from: String,
    /// Where to copy it: a file or a database without a ledger
    to: String,
    /// A file with the password of the database: in an address, others on this computer could see it
    #[arg(long, value_name = "FILE")]
    password_file: Option<PathBuf>,
}

/// Runs `nestd ledger`.
pub fn run(command: &LedgerCommand) -> Result<CommandExit> {
    let LedgerCommand::Copy(args) = command;
    let [from, to] = [&args.from, &args.to].map(|text| LedgerAddress::parse(text, args.password_file.as_deref()));
    for address in [&from, &to] {
        if let Some((text, remedy)) = address.find_problem() {
            return Err(UsageError(format!("{text}: {remedy}")).into());
        }
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    let copied = runtime.context("cannot start")?.block_on(farm::copy_ledger(&from, &to))?;
    print_text(&format!(
        "Copied {} rows from {from} to {to}; {} tables and views hold the same.",
        copied.rows, copied.compared
    ))?;
    Ok(CommandExit::Success)
}
