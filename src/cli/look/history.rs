//! `nestd history`: lists builds with their heights.

use anyhow::Result;
use farm::DatedBuild;
use jiff::Timestamp;
use ledger::{HeightSummary, HistoryQuery};

use crate::{
    cli::{
        CommandExit, CommonArgs, UsageError,
        terminal::{
            candidates,
            farm_context::{parse_time, with_ledger_to_read},
            table::{TextTable, print_as_is, print_fitted, print_json, print_text},
            terminal::output_columns,
        },
    },
    tables::{HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS, TimeView, csv_of},
};

/// Columns that are left out on a narrow terminal, the first of them first.
const LEAST_COLUMNS: &[&str] = &[
    "printer",
    "clearance_proved_mm",
    "cpu_secs",
    "lower_bound_mm",
    "layers",
    "parts",
    "file_or_reason",
    "used",
    "copies",
    "state_word",
    "machine",
];

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct HistoryArgs {
    /// Builds since then: an age (7d, 12h), a date (2026-11-01) or an RFC 3339 time
    #[arg(long, value_name = "TIME")]
    since: Option<String>,
    /// Builds before then
    #[arg(long, value_name = "TIME")]
    until: Option<String>,
    /// Builds of one machine
    #[arg(long, value_name = "MACHINE", add = candidates::of_machines())]
    machine: Option<String>,
    /// The newest N builds only
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
    /// How to print
    #[arg(long, value_enum, default_value_t = HistoryFormat::Table)]
    format: HistoryFormat,
    /// Print all columns, however wide the terminal is
    #[arg(long)]
    wide: bool,
    /// Print JSON; the same as --format json
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// How a history is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum HistoryFormat {
    /// For people
    Table,
    /// For programs, every column
    Json,
    /// For spreadsheets, every column
    Csv,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &HistoryArgs) -> Result<CommandExit> {
    let (rows, sums, view) = with_ledger_to_read(common, async |settings, ledger| {
        let time = |text: &Option<String>| {
            let time = text.as_ref().map(|text| parse_time(text, Timestamp::now(), &settings.time_zone));
            time.transpose().map_err(UsageError)
        };
        let query = HistoryQuery {
            since: time(&args.since)?,
            until: time(&args.until)?,
            machine: args.machine.clone(),
            limit: args.limit,
            ..HistoryQuery::default()
        };
        let rows = ledger.read_history(&query).await?;
        let rows = DatedBuild::of_rows(ledger, settings.profiles.values(), rows, Timestamp::now()).await?;
        match &args.machine {
            // The history of a machine that is no longer configured stays readable.
            Some(machine)
                if rows.is_empty()
                    && !settings.profiles.contains_key(machine)
                    && ledger.node_of_machine(machine).await?.is_none() =>
            {
                Err(UsageError(format!("there is no machine '{machine}', and no build of one")).into())
            }
            _ => Ok((rows, ledger.height_summaries(&query).await?, TimeView::current(&settings.time_zone))),
        }
    })?;
    match if args.json { HistoryFormat::Json } else { args.format } {
        HistoryFormat::Table if rows.is_empty() => print_text("No builds.")?,
        HistoryFormat::Table => {
            let columns = output_columns(args.wide);
            let mut text = TextTable::of(HISTORY_COLUMNS, &rows, &view).fit_essentials(columns, LEAST_COLUMNS);
            // No sums with --limit: a reader would take them for the sums of all builds.
            if args.limit.is_none() {
                text += &format!(
                    "\nPublished\n{}",
                    TextTable::of(HEIGHT_SUM_COLUMNS, &HeightSummary::with_total(sums), &view).fit_columns(columns)
                );
            }
            print_fitted(&text, args.wide)?;
        }
        HistoryFormat::Json => print_json(&rows)?,
        HistoryFormat::Csv => print_as_is(&csv_of(HISTORY_COLUMNS, &rows)?)?,
    }
    Ok(CommandExit::Success)
}
