//! `nestd printer`: the printers of the farm; takes one out of use, and puts it into use again.

use anyhow::{Context, Result};
use jiff::Timestamp;
use ledger::Ledger;

use crate::{
    cli::{
        CommandExit, CommonArgs, UsageError,
        terminal::{
            farm_context::{user_at_host, with_ledger, with_ledger_to_read},
            table::{TextTable, print_json, print_text},
            terminal::output_columns,
        },
    },
    farm::{PrinterView, fate_of_queued, printer_views},
    settings::{MachineProfile, Settings},
    tables::{PRINTER_COLUMNS, TimeView},
};

/// Columns that are left out on a narrow terminal, the first of them first.
const LEAST_COLUMNS: &[&str] = &["times", "told_by", "down_at"];

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct PrinterArgs {
    /// Name of the printer; a machine without [[printer]] is one printer of its own name
    name: Option<String>,
    /// Take it out of use, or put it into use again
    #[arg(requires = "name")]
    state: Option<PrinterUse>,
    /// Why it is down
    #[arg(long, default_value = "", value_name = "TEXT", requires = "state")]
    reason: String,
    /// Print JSON
    #[arg(long, conflicts_with = "state")]
    json: bool,
}

/// Whether a printer takes builds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum PrinterUse {
    /// It takes no builds; those in its queue folder that it has not taken go to another printer of its machine
    Down,
    /// It takes builds
    Up,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &PrinterArgs) -> Result<CommandExit> {
    if let (Some(name), Some(state)) = (&args.name, args.state) {
        let text = with_ledger(common, async |settings, ledger| {
            set_printer_use(settings, ledger, (name, state), &args.reason).await
        })?;
        print_text(&text)?;
        return Ok(CommandExit::Success);
    }
    let (printers, view) = with_ledger_to_read(common, async |settings, ledger| {
        let mut printers = Vec::new();
        for profile in settings.profiles.values() {
            printers.extend(printer_views(ledger, profile, Timestamp::now()).await?);
        }
        if let Some(name) = &args.name {
            machine_of_printer(settings, name)?;
            printers.retain(|printer: &PrinterView| printer.printer == *name);
        }
        Ok((printers, TimeView::current(&settings.time_zone)))
    })?;
    match args.json {
        true => print_json(&printers)?,
        false => {
            let table = TextTable::of(PRINTER_COLUMNS, &printers, &view);
            print_text(&table.fit_essentials(output_columns(false), LEAST_COLUMNS))?;
        }
    }
    Ok(CommandExit::Success)
}

async fn set_printer_use(
    settings: &Settings,
    ledger: &Ledger,
    (name, state): (&str, PrinterUse),
    reason: &str,
) -> Result<String> {
    let (by, down) = (user_at_host(), ledger.down_printers().await?);
    if state == PrinterUse::Up {
        // Also one that is configured no more: another one may get its name.
        let profile = match down.into_iter().find(|down| down.printer == name) {
            Some(down) => down.profile,
            None => machine_of_printer(settings, name)?.name.clone(),
        };
        return Ok(match ledger.bring_printer_up(name, &profile, &by).await? {
            true => format!("The printer {name} takes builds again."),
            false => format!("The printer {name} was not down."),
        });
    }
    let profile = machine_of_printer(settings, name)?;
    ledger.take_printer_down(name, &profile.name, &by, reason).await?;
    let next = fate_of_queued(ledger, profile, name).await?;
    Ok(format!("The printer {name} is down: it is given no builds. {next}"))
}

/// The machine of a printer.
fn machine_of_printer<'s>(settings: &'s Settings, name: &str) -> Result<&'s MachineProfile> {
    let has = |profile: &&MachineProfile| profile.printers.iter().any(|printer| printer.name == name);
    settings.profiles.values().find(has).with_context(|| {
        let known = settings.profiles.values().flat_map(|profile| &profile.printers);
        let known: Vec<&str> = known.map(|printer| printer.name.as_str()).collect();
        UsageError(format!("there is no printer '{name}' here, only {}", known.join(", ")))
    })
}
