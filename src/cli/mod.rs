//! The command line: parses arguments, calls the other modules, prints results. Exit code 0 success, 1 the work failed,
//! 2 wrong use or configuration.
#![allow(clippy::print_stdout, clippy::print_stderr)] // the only module that writes to a terminal

mod act;
mod look;
mod serve;
mod terminal;
#[cfg(test)]
mod tests;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Command, CommandFactory, FromArgMatches, Parser, Subcommand};

pub use terminal::common::{CommandExit, CommonArgs, UsageError};

/// Runs a powder-bed print farm: parts dropped into a folder become nested builds in the printer's queue.
#[derive(Debug, Parser)]
#[command(version = env!("NESTD_VERSION"), about, after_help = "Exit code 0 success, 1 the work failed, 2 wrong use or configuration.")]
struct CommandLine {
    #[command(flatten)]
    common: CommonArgs,
    #[command(subcommand)]
    command: CliCommand,
}

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Make a small farm with sample parts, run the daemon on it and show the results
    Demo(serve::demo::DemoArgs),
    /// Run the daemon in the foreground
    Run(serve::run::RunArgs),
    /// Check configuration, folders, permissions, ledger and limits
    Check(serve::check::CheckArgs),
    /// Show waiting parts, builds that are being nested and whether the daemon runs
    Status(look::status::StatusArgs),
    /// List builds with their heights
    History(look::history::HistoryArgs),
    /// List what builds cost, and which order bears what
    Costs(look::costs::CostsArgs),
    /// Show a build, a part or an order
    Show(look::show::ShowArgs),
    /// Draw a build as a PNG
    Render(look::render::RenderArgs),
    /// Write a build as one HTML file to mail: 3D view, facts and pick map
    Report(look::report::ReportArgs),
    /// Nest and publish the waiting parts of a machine now
    Flush {
        /// Machine
        #[arg(add = terminal::candidates::of_machines())]
        machine: String,
    },
    /// Stop a machine from firing batches until it is resumed
    Pause {
        /// Machine
        #[arg(add = terminal::candidates::of_machines())]
        machine: String,
    },
    /// Let a paused machine fire again
    Resume {
        /// Machine
        #[arg(add = terminal::candidates::of_machines())]
        machine: String,
    },
    /// Take a refused part back
    Retry {
        /// Part number, as status and show print it (5 or p5)
        #[arg(value_parser = terminal::values::parse_part_number, add = terminal::candidates::of_refused_parts())]
        part: i64,
    },
    /// Take a refused part back with its mesh mended: holes closed, triangles turned
    Mend {
        /// Part number, as status and show print it (5 or p5)
        #[arg(value_parser = terminal::values::parse_part_number, add = terminal::candidates::of_refused_parts())]
        part: i64,
    },
    /// Take waiting parts, or some of their copies, out of the farm
    Cancel {
        /// Parts: numbers (5 or p5, 5=2 for two copies), orders, file names, patterns ('bracket*')
        #[arg(required = true, value_name = "PART[=N]|ORDER", add = terminal::candidates::of_parts())]
        targets: Vec<String>,
    },
    /// Change what was asked with waiting parts: copies, due date, priority, order and so on
    Edit(act::edit::EditArgs),
    /// Move waiting parts to another machine
    Move {
        /// Parts: numbers (5 or p5), orders, file names, patterns ('bracket*')
        #[arg(required = true, value_name = "PART|ORDER", add = terminal::candidates::of_parts())]
        targets: Vec<String>,
        /// Machine to move them to
        #[arg(long, value_name = "MACHINE", add = terminal::candidates::of_machines())]
        to: String,
    },
    /// Print parts as they are that wait for a yes
    Confirm {
        /// Parts: numbers (5 or p5), orders, file names, patterns ('bracket*')
        #[arg(required = true, value_name = "PART|ORDER", add = terminal::candidates::of_parts())]
        targets: Vec<String>,
    },
    /// Print again what was printed: a build, the last copies of a part, or an order
    Reprint {
        /// Build (b4), part (p5, 5=2 for two copies), order or file name
        #[arg(required = true, value_name = "BUILD|PART[=N]|ORDER", add = terminal::candidates::of_everything())]
        targets: Vec<String>,
        /// Also if the file of a build lies in the queue: it is taken out first
        #[arg(long)]
        anyway: bool,
    },
    /// Issue the same proved build once more, as a new build
    Requeue(act::edit::RequeueArgs),
    /// List orders, what became of their copies, and when they are done
    Orders(look::orders::OrdersArgs),
    /// Close orders as they are: what waits is cancelled, what was refused asks nobody any more
    Close {
        /// Names of orders
        #[arg(required = true, value_name = "ORDER", add = terminal::candidates::of_orders())]
        orders: Vec<String>,
    },
    /// Mark a machine's refused files, or the failed print of a build, as seen: they raise no alert any more
    Dismiss {
        /// Machine, or build (b4)
        #[arg(value_name = "MACHINE|BUILD", add = terminal::candidates::of_machines())]
        machine: String,
    },
    /// Record the outcome of a published build
    Outcome(act::outcome::OutcomeArgs),
    /// Scan the hot folders now
    Scan,
    /// Take over a machine, and the files that another nestd claimed in its hot folder before it went away
    Adopt {
        /// Machine
        #[arg(add = terminal::candidates::of_machines())]
        machine: String,
    },
    /// Show the printers, or take one out of use (down) and into use again (up)
    Printer(act::printer::PrinterArgs),
    /// Show the builds to come of the machines, and which due dates are at risk
    Plan(look::plan::PlanArgs),
    /// Say when parts could be done that nobody has ordered yet, and what they would add
    Quote(look::quote::QuoteArgs),
    /// Say that a proved build may be published, where a machine asks for that; shows what it means
    Release(act::release::ReleaseArgs),
    /// Take a published build that its printer has not taken back out of the queue: its copies wait again
    Withdraw(act::withdraw::WithdrawArgs),
    /// Make, list and take back the tokens with which programs ask the dashboard
    #[command(subcommand)]
    Token(act::token::TokenCommand),
    /// Say who may sign in to the dashboard, and what each may do
    #[command(subcommand)]
    People(act::person::PeopleCommand),
    /// Show the daemons that share the ledger: whether they run, and which machines they serve
    Nodes(look::nodes::NodesArgs),
    /// Copy the ledger to a file while the farm runs
    Backup(serve::backup::BackupArgs),
    /// Put a backup of the ledger back; builds published since then are not printed again
    Restore(serve::backup::RestoreArgs),
    /// Copy the ledger between a file and a PostgreSQL database
    #[command(subcommand)]
    Ledger(serve::ledger::LedgerCommand),
    /// Show which messages the webhook and the command have received, or send them a trial message
    Notify(act::notify::NotifyArgs),
    /// Print the farm's metrics in the Prometheus format
    Metrics,
    /// Nest parts into a build file without a daemon
    Nest(Box<serve::nest::NestArgs>),
    /// Prove a build file on its triangles
    Verify(serve::verify::VerifyArgs),
    /// Write the configuration of a new farm
    Init(serve::new_farm::InitArgs),
    /// Add a machine to the configuration
    #[command(subcommand)]
    Machine(act::machine::MachineCommand),
    /// Print the completions of a shell: nestd completions bash > /etc/bash_completion.d/nestd
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder
    Man {
        /// The folder; it is made if it is not there
        dir: std::path::PathBuf,
    },
    /// Read a part file for the daemon; the request comes on standard input
    #[command(name = farm::READ_PART, hide = true)]
    ReadPart,
}

/// Parses the command line, runs the command and prints an error chain once.
pub fn main() -> ExitCode {
    // A shell that completes a word runs nestd with COMPLETE set; then this prints and ends.
    clap_complete::CompleteEnv::with_factory(command_line).complete();
    let cli = CommandLine::from_arg_matches(&command_line().get_matches()).unwrap_or_else(|wrong| wrong.exit());
    match dispatch_command(&cli) {
        Ok(CommandExit::Success) => ExitCode::SUCCESS,
        Ok(CommandExit::Failure) => ExitCode::from(1),
        Err(error) => {
            terminal::table::print_to_stderr(&format!("{error:#}"));
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}

/// All commands and options.
fn command_line() -> Command {
    terminal::values::with_former_option(CommandLine::command())
}

fn dispatch_command(cli: &CommandLine) -> Result<CommandExit> {
    use act::command::DaemonCommand;
    let common = &cli.common;
    match &cli.command {
        CliCommand::Demo(args) => serve::demo::run(common, args),
        CliCommand::Run(args) => serve::run::run(common, args),
        CliCommand::Check(args) => serve::check::run(common, args),
        CliCommand::Status(args) => look::status::run(common, args),
        CliCommand::History(args) => look::history::run(common, args),
        CliCommand::Costs(args) => look::costs::run(common, args),
        CliCommand::Show(args) => look::show::run(common, args),
        CliCommand::Render(args) => look::render::run(common, args),
        CliCommand::Report(args) => look::report::run(common, args),
        CliCommand::Flush { machine } => act::command::run(common, &DaemonCommand::Flush(machine.clone())),
        CliCommand::Pause { machine } => act::command::run(common, &DaemonCommand::Pause(machine.clone())),
        CliCommand::Resume { machine } => act::command::run(common, &DaemonCommand::Resume(machine.clone())),
        CliCommand::Retry { part } => act::command::run(common, &DaemonCommand::Retry(ledger::PartId(*part))),
        CliCommand::Mend { part } => act::command::run(common, &DaemonCommand::Mend(ledger::PartId(*part))),
        CliCommand::Cancel { targets } => act::edit::run_cancel(common, targets),
        CliCommand::Edit(args) => act::edit::run(common, args),
        CliCommand::Move { targets, to } => act::edit::run_move(common, targets, to),
        CliCommand::Confirm { targets } => act::edit::run_confirm(common, targets),
        CliCommand::Reprint { targets, anyway } => act::edit::run_reprint(common, targets, *anyway),
        CliCommand::Requeue(args) => act::edit::run_requeue(common, args),
        CliCommand::Orders(args) => look::orders::run(common, args),
        CliCommand::Close { orders } => act::operate::run_close(common, orders),
        CliCommand::Dismiss { machine } => act::dismiss::run(common, machine),
        CliCommand::Outcome(args) => act::outcome::run(common, args),
        CliCommand::Scan => act::command::run(common, &DaemonCommand::Scan),
        CliCommand::Adopt { machine } => act::adopt::run(common, machine),
        CliCommand::Printer(args) => act::printer::run(common, args),
        CliCommand::Plan(args) => look::plan::run(common, args),
        CliCommand::Quote(args) => look::quote::run(common, args),
        CliCommand::Release(args) => act::release::run(common, args),
        CliCommand::Withdraw(args) => act::withdraw::run(common, args),
        CliCommand::Token(command) => act::token::run(common, command),
        CliCommand::People(command) => act::person::run(common, command),
        CliCommand::Nodes(args) => look::nodes::run(common, args),
        CliCommand::Backup(args) => serve::backup::run(common, args),
        CliCommand::Restore(args) => serve::backup::run_restore(common, args),
        CliCommand::Ledger(command) => serve::ledger::run(command),
        CliCommand::Notify(args) => act::notify::run(common, args),
        CliCommand::Metrics => look::metrics::run(common),
        CliCommand::Nest(args) => serve::nest::run(common, args),
        CliCommand::Verify(args) => serve::verify::run(common, args),
        CliCommand::Init(args) => serve::new_farm::run_init(args),
        CliCommand::Machine(command) => act::machine::run(common, command),
        CliCommand::Completions { shell } => serve::completions::print_completions(*shell),
        CliCommand::Man { dir } => serve::manual::write_manual(CommandLine::command(), dir),
        CliCommand::ReadPart => {
            farm::answer_read_request(std::io::stdin(), std::io::stdout()).map(|()| CommandExit::Success)
        }
    }
}
