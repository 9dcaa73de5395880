//! `nestd check`: finds everything that can be known to be wrong before the daemon runs, each problem with its remedy.
//! It leaves no files behind.

mod deep;
mod folders;
mod ledger;
mod machines;
mod notify;
mod other_machines;
mod report;
mod system;

use anyhow::Result;

pub use self::machines::volume_doubt;
use self::{other_machines::OtherMachines, report::CheckReport};
use settings::{Settings, SettingsError};

use crate::cli::{CommandExit, CommonArgs, UsageError};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Also read every file in store, error, archive and queue folders and compare it with the ledger
    #[arg(long)]
    deep: bool,
    /// Update a ledger that is older than the folders from their contents; only while no daemon runs
    #[arg(long, requires = "deep")]
    repair: bool,
    /// With --repair: a folder that is known to be empty, because its contents are lost for good or because it is new
    #[arg(long, value_name = "DIR", requires = "repair")]
    new_folder: Vec<std::path::PathBuf>,
}

/// Runs the command. Exit code 0: no problem, perhaps warnings, with which the daemon can run. 1: something around the
/// daemon is wrong. 2: the configuration is wrong.
pub fn run(common: &CommonArgs, args: &CheckArgs) -> Result<CommandExit> {
    let mut report = CheckReport::default();
    let settings = match settings::load_settings(common.config.as_deref(), common.root.as_deref()) {
        Ok(settings) => settings,
        Err(SettingsError::Invalid(problems)) => {
            problems.into_iter().for_each(|problem| report.add_configuration_problem(problem));
            report.print_findings(args.json)?;
            return Err(UsageError("the configuration is wrong".into()).into());
        }
        Err(error) => return Err(UsageError(error.to_string()).into()),
    };
    // What other nodes serve is for them to check.
    let others = OtherMachines::read(&settings)?;
    others.report_configured(&settings, &mut report);
    let own = others.taken_out_of(&settings);
    farm::watch_other_holders(&own);
    if args.repair {
        deep::repair_ledger(&settings, &args.new_folder, &mut report)?;
    }
    check_all(&own, &others, &mut report)?;
    if args.deep {
        deep::check_invariants(&own, &mut report)?;
    }
    report.print_findings(args.json)?;
    Ok(if report.problem_count() == 0 { CommandExit::Success } else { CommandExit::Failure })
}

fn check_all(settings: &Settings, others: &OtherMachines, report: &mut CheckReport) -> Result<()> {
    let machines: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    let served = match machines.is_empty() {
        false => machines.join(", "),
        true => "no machines: this node shows its pages, and keeps second copies of files".to_owned(),
    };
    report.add_ok("configuration", format!("{}: {served}", settings.file.display()));
    report.add_ok("root", settings.root.display().to_string());
    machines::check_machines(settings, report);
    system::check_system(settings, report);
    folders::check_folders(settings, others, report);
    notify::check_receivers(settings, report);
    ledger::check_ledger(settings, others, report)
}
