//! `nestd show`: shows a build, a part or an order, with everything that the ledger knows about it.

use anyhow::Result;
use farm::{locate_build_file, read_plans};
use jiff::Timestamp;
use settings::MachineProfile;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::with_ledger_to_read,
            lookup::{LookupQuery, look_up},
            show_text,
            table::{print_fitted, print_json, print_to_stderr},
            terminal::output_columns,
        },
    },
    tables::TimeView,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct ShowArgs {
    /// 'build 42' or b42, 'part 7' or p7, 'part FILE', 'order NAME', or only a number or name, which shows everything
    /// that matches
    #[arg(required = true, num_args = 1.., value_name = "BUILD|PART|ORDER", add = crate::cli::terminal::candidates::of_everything())]
    what: Vec<String>,
    /// Print all columns, however wide the terminal is
    #[arg(long)]
    wide: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &ShowArgs) -> Result<CommandExit> {
    let wanted = LookupQuery::from_words(&args.what);
    let (found, view) = with_ledger_to_read(common, async |settings, ledger| {
        let plans = read_plans(ledger, settings.profiles.values(), Timestamp::now()).await?;
        let mut found = look_up(ledger, &wanted, &plans, (&settings.time_zone, &settings.materials)).await?;
        if let Some(sheet) = &mut found.build {
            let build = &sheet.build;
            let now = settings.profiles.get(&build.machine);
            sheet.file = now.and_then(|machine| locate_build_file(machine, build));
            sheet.machine =
                Some(MachineProfile::from_snapshot(&build.machine, build.kept.profile_snapshot.as_deref(), now));
        }
        Ok((found, TimeView::current(&settings.time_zone)))
    })?;
    if found.is_empty() {
        // With --json, the output is JSON even when nothing was found; the exit code says so.
        match args.json {
            true => print_json(&found)?,
            false => print_to_stderr(&format!("there is no build, part or order '{}'", args.what.join(" "))),
        }
        return Ok(CommandExit::Failure);
    }
    match args.json {
        true => print_json(&found)?,
        false => print_fitted(&show_text::lookup_text(&found, &view, output_columns(args.wide)), args.wide)?,
    }
    Ok(CommandExit::Success)
}
