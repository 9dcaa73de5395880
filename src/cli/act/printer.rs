//! `nestd printer`: the printers of the farm; takes one out of use, and puts it into use again.

use anyhow::{Context, Result};
use farm::{FarmReading, PrinterFact};
use jiff::Timestamp;
use ledger::{Ledger, OperatorWord};
use settings::{MachineProfile, Settings};

use super::operate::say_all;
use crate::{
    cli::{
        CommandExit, CommonArgs, UsageError,
        terminal::{
            farm_context::{with_ledger, with_ledger_to_read},
            table::{TextTable, print_json, print_text},
            terminal::output_columns,
        },
    },
    tables::{PRINTER_COLUMNS, TimeView},
};

/// Columns that are left out on a narrow terminal, the first of them first.
const LEAST_COLUMNS: &[&str] = &["times", "free_at"];

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
        let said = with_ledger(common, async |settings, ledger| {
            let word = word_of(settings, ledger, (name, state), &args.reason).await?;
            say_all(settings, ledger, &[word], false).await
        })?;
        print_text(&said.join(" "))?;
        return Ok(CommandExit::Success);
    }
    let (printers, view) = with_ledger_to_read(common, async |settings, ledger| {
        let mut printers = Vec::new();
        let reading = FarmReading::read(ledger, settings.profiles.values(), Timestamp::now()).await?;
        printers.extend(reading.facts().into_iter().flat_map(|fact| fact.printers));
        if let Some(name) = &args.name {
            machine_of_printer(settings, name)?;
            printers.retain(|printer: &PrinterFact| printer.printer == *name);
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

/// What is said of the printer of this name.
async fn word_of(
    settings: &Settings,
    ledger: &Ledger,
    (name, state): (&str, PrinterUse),
    reason: &str,
) -> Result<OperatorWord> {
    // Also one that is configured no more is put into use: another one may get its name.
    let down = ledger.down_printers().await?.into_iter().find(|down| down.printer == name && state == PrinterUse::Up);
    let machine = match down {
        Some(down) => down.machine,
        None => machine_of_printer(settings, name)?.name.clone(),
    };
    let printer = name.to_owned();
    Ok(match state {
        PrinterUse::Down => OperatorWord::PrinterDown { machine, printer, reason: reason.to_owned() },
        PrinterUse::Up => OperatorWord::PrinterUp { machine, printer },
    })
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
