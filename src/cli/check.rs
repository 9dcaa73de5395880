//! `nestd check`: everything that can be known to be wrong before the daemon runs, each with its remedy. Leaves nothing
//! behind.

mod deep;
mod folders;
mod ledger;
mod notify;
mod report;
mod system;

use anyhow::Result;

use self::report::Report;
use super::{Common, Exit, Usage};
use crate::settings::{self, Settings, SettingsError};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Also read every file in store, error, archive and queue folders and hold it against the ledger
    #[arg(long)]
    deep: bool,
    /// Take what the folders tell into a ledger that is older than they are; only while no daemon runs
    #[arg(long, requires = "deep")]
    repair: bool,
    /// With --repair: a folder of which it is known that nothing is in it: it is lost for good, or truly new
    #[arg(long, value_name = "DIR", requires = "repair")]
    new_folder: Vec<std::path::PathBuf>,
}

/// Runs the command: exit code 0 when all is well or there are only warnings, which hinder no daemon, 1 when something around the daemon is wrong, 2 when the configuration is.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let mut report = Report::default();
    let settings = match settings::load(common.config.as_deref(), common.root.as_deref()) {
        Ok(settings) => settings,
        Err(SettingsError::Invalid(problems)) => {
            problems.into_iter().for_each(|problem| report.configuration_problem(problem));
            report.print(args.json)?;
            return Err(Usage("the configuration is wrong".into()).into());
        }
        Err(error) => return Err(Usage(error.to_string()).into()),
    };
    if args.repair {
        deep::repair(&settings, &args.new_folder, &mut report)?;
    }
    look(&settings, &mut report)?;
    if args.deep {
        deep::look(&settings, &mut report)?;
    }
    report.print(args.json)?;
    Ok(if report.problems() == 0 { Exit::Success } else { Exit::Failure })
}

fn look(settings: &Settings, report: &mut Report) -> Result<()> {
    let machines: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
    report.ok("configuration", format!("{}: {}", settings.file.display(), machines.join(", ")));
    report.ok("root", settings.root.display().to_string());
    system::look(settings, report);
    folders::look(settings, report);
    notify::look(settings, report);
    ledger::look(settings, report)
}
