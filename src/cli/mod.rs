//! The face to people: parses arguments, calls, prints. Exit code 0 success, 1 the work failed, 2 wrong use or
//! configuration.
#![allow(clippy::print_stdout, clippy::print_stderr)] // the only room that speaks to a terminal

mod adopt;
mod asked;
mod backup;
mod check;
mod command;
mod common;
mod demo;
mod dismiss;
mod draft;
mod history;
mod logging;
mod looked;
mod lookup;
mod metrics;
mod nest;
mod notify;
mod outcome;
mod reach;
mod render;
mod report;
mod run;
mod show;
mod show_text;
mod status;
mod table;
mod values;
mod verify;
mod watch;

#[cfg(test)]
mod tests;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use crate::farm;

pub use common::{Common, Exit, Usage};

/// Runs a powder-bed print farm: parts dropped into a folder become nested builds in the printer's queue.
#[derive(Debug, Parser)]
#[command(version, about, after_help = "Exit code 0 success, 1 the work failed, 2 wrong use or configuration.")]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a small farm with sample parts, run the daemon on it and show what comes out
    Demo(demo::Args),
    /// Run the daemon in the foreground
    Run(run::Args),
    /// Check configuration, folders, permissions, ledger and limits
    Check(check::Args),
    /// Show what waits, what is being nested and whether the daemon runs
    Status(status::Args),
    /// List builds with their heights
    History(history::Args),
    /// Show a build, a part or an order
    Show(show::Args),
    /// Draw a build as a PNG
    Render(render::Args),
    /// Write a build as one HTML file to mail: 3D view, facts and pick map
    Report(report::Args),
    /// Publish what waits in a profile now
    Flush {
        /// Machine profile
        profile: String,
    },
    /// Fire no batch in a profile until it is resumed
    Pause {
        /// Machine profile
        profile: String,
    },
    /// Let a paused profile fire again
    Resume {
        /// Machine profile
        profile: String,
    },
    /// Take a rejected part back
    Retry {
        /// Part number, as status and show print it (5 or p5)
        #[arg(value_parser = values::part_number)]
        part: i64,
    },
    /// Take a waiting part out of the farm
    Cancel {
        /// Part number, as status and show print it (5 or p5)
        #[arg(value_parser = values::part_number)]
        part: i64,
    },
    /// Leave a profile's refused files where they lie, and need nobody for them any more
    Dismiss {
        /// Machine profile
        profile: String,
    },
    /// Tell what became of a published build
    Outcome(outcome::Args),
    /// Look into the hot folders now
    Scan,
    /// Take over the files that another nestd, which is gone, has claimed in a hot folder
    Adopt {
        /// Machine profile
        profile: String,
    },
    /// Copy the ledger to a file while the farm runs
    Backup(backup::Args),
    /// Put a backup of the ledger back; nothing that was published since is printed again
    Restore(backup::RestoreArgs),
    /// Show how far webhook and command have been told what happened, or try them out
    Notify(notify::Args),
    /// Print the farm's numbers as Prometheus reads them
    Metrics,
    /// Nest parts into a build file without a daemon
    Nest(Box<nest::Args>),
    /// Prove a build file on its triangles
    Verify(verify::Args),
    /// Read a file for the daemon, which asks on standard input
    #[command(name = farm::READ_PART, hide = true)]
    ReadPart,
}

/// Parses the command line, runs the command and prints an error chain once.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    match dispatch(&cli) {
        Ok(Exit::Success) => ExitCode::SUCCESS,
        Ok(Exit::Failure) => ExitCode::from(1),
        Err(error) => {
            table::tell(&format!("{error:#}"));
            ExitCode::from(if error.is::<Usage>() { 2 } else { 1 })
        }
    }
}

fn dispatch(cli: &Cli) -> Result<Exit> {
    use command::Order;
    let common = &cli.common;
    match &cli.command {
        Command::Demo(args) => demo::run(common, args),
        Command::Run(args) => run::run(common, args),
        Command::Check(args) => check::run(common, args),
        Command::Status(args) => status::run(common, args),
        Command::History(args) => history::run(common, args),
        Command::Show(args) => show::run(common, args),
        Command::Render(args) => render::run(common, args),
        Command::Report(args) => report::run(common, args),
        Command::Flush { profile } => command::run(common, &Order::Flush(profile.clone())),
        Command::Pause { profile } => command::run(common, &Order::Pause(profile.clone())),
        Command::Resume { profile } => command::run(common, &Order::Resume(profile.clone())),
        Command::Retry { part } => command::run(common, &Order::Retry(*part)),
        Command::Cancel { part } => command::run(common, &Order::Cancel(*part)),
        Command::Dismiss { profile } => dismiss::run(common, profile),
        Command::Outcome(args) => outcome::run(common, args),
        Command::Scan => command::run(common, &Order::Scan),
        Command::Adopt { profile } => adopt::run(common, profile),
        Command::Backup(args) => backup::run(common, args),
        Command::Restore(args) => backup::restore(common, args),
        Command::Notify(args) => notify::run(common, args),
        Command::Metrics => metrics::run(common),
        Command::Nest(args) => nest::run(common, args),
        Command::Verify(args) => verify::run(common, args),
        Command::ReadPart => farm::read_for_the_farm(std::io::stdin(), std::io::stdout()).map(|()| Exit::Success),
    }
}
