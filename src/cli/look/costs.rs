//! `nestd costs`: what builds cost, and which order bears what.

use anyhow::Result;
use farm::CostReport;
use jiff::Timestamp;
use ledger::{BuildId, CostQuery};

use crate::{
    cli::{
        CommandExit, CommonArgs, UsageError,
        terminal::{
            candidates,
            farm_context::{parse_time, with_ledger_to_read},
            table::{TextTable, print_as_is, print_fitted, print_json, print_text},
            terminal::output_columns,
            values::parse_build_number,
        },
    },
    tables::{COST_SHARE_COLUMNS, LEAST_COST_COLUMNS, ORDER_COST_COLUMNS, TimeView, csv_of},
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct CostsArgs {
    /// Builds published since then: an age (7d, 12h), a date (2026-11-01) or an RFC 3339 time
    #[arg(long, value_name = "TIME")]
    since: Option<String>,
    /// Builds published before then
    #[arg(long, value_name = "TIME")]
    until: Option<String>,
    /// What this order bears
    #[arg(long, value_name = "ORDER", add = candidates::of_orders())]
    order: Option<String>,
    /// One build
    #[arg(long, value_name = "BUILD", value_parser = parse_build_number, add = candidates::of_builds())]
    build: Option<i64>,
    /// A row for each order in each build, and not the sums of the orders
    #[arg(long)]
    by_build: bool,
    /// How to print
    #[arg(long, value_enum, default_value_t = CostFormat::Table)]
    format: CostFormat,
    /// Print all columns, however wide the terminal is
    #[arg(long)]
    wide: bool,
    /// Print JSON; the same as --format json
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// How costs are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum CostFormat {
    /// For people
    Table,
    /// For programs: sums and rows
    Json,
    /// For spreadsheets
    Csv,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &CostsArgs) -> Result<CommandExit> {
    let (report, view) = with_ledger_to_read(common, async |settings, ledger| {
        let time = |text: &Option<String>| {
            let time = text.as_ref().map(|text| parse_time(text, Timestamp::now(), &settings.time_zone));
            time.transpose().map_err(UsageError)
        };
        let query = CostQuery {
            since: time(&args.since)?,
            until: time(&args.until)?,
            order_name: args.order.clone(),
            build: args.build.map(BuildId),
        };
        let report = CostReport::read(ledger, &query, &settings.profiles).await?;
        Ok((report, TimeView::current(&settings.time_zone)))
    })?;
    match if args.json { CostFormat::Json } else { args.format } {
        CostFormat::Table if report.shares.is_empty() => print_text("No published builds.")?,
        CostFormat::Table => {
            let columns = output_columns(args.wide);
            let mut text =
                match args.by_build {
                    true => TextTable::of(COST_SHARE_COLUMNS, &report.shares, &view)
                        .fit_essentials(columns, LEAST_COST_COLUMNS),
                    false => TextTable::of(ORDER_COST_COLUMNS, &report.orders, &view)
                        .fit_essentials(columns, LEAST_COST_COLUMNS),
                };
            match report.totals.is_empty() {
                true => text += "\nNothing has a price: the rates stand in [costs] of a machine's file.\n",
                false => report.totals.iter().for_each(|sum| text += &format!("\nIn all {sum}")),
            }
            print_fitted(&text, args.wide)?;
        }
        CostFormat::Json => print_json(&report)?,
        CostFormat::Csv if args.by_build => print_as_is(&csv_of(COST_SHARE_COLUMNS, &report.shares)?)?,
        CostFormat::Csv => print_as_is(&csv_of(ORDER_COST_COLUMNS, &report.orders)?)?,
    }
    Ok(CommandExit::Success)
}
