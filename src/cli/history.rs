//! `nestd history`: builds with their heights.

use anyhow::Result;
use jiff::Timestamp;

use super::{
    Common, Exit, Usage,
    reach::{brief, look_at_ledger, time_argument},
    table::{Table, number, or_dash, percent, say, say_json, text},
};
use crate::ledger::{HeightSum, HistoryQuery, HistoryRow};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Builds since then: an age (7d, 12h), a date (2026-11-01, UTC) or an RFC 3339 time
    #[arg(long, value_name = "TIME", value_parser = time_argument)]
    since: Option<Timestamp>,
    /// Builds before then
    #[arg(long, value_name = "TIME", value_parser = time_argument)]
    until: Option<Timestamp>,
    /// Builds of one machine profile
    #[arg(long, value_name = "P")]
    profile: Option<String>,
    /// The newest N builds only
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Print JSON; the same as --format json
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// How a history is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// For people
    Table,
    /// For programs, every column
    Json,
    /// For spreadsheets, every column
    Csv,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let query = HistoryQuery {
        since: args.since,
        until: args.until,
        profile: args.profile.clone(),
        limit: args.limit,
        ..HistoryQuery::default()
    };
    let (rows, sums) = look_at_ledger(common, async |settings, ledger| {
        let rows = ledger.history(&query).await?;
        match &args.profile {
            // The history of a machine that was sold stays readable.
            Some(profile) if rows.is_empty() && !settings.profiles.contains_key(profile) => {
                Err(Usage(format!("there is no profile '{profile}', and no build of one")).into())
            }
            _ => Ok((rows, ledger.height_sums(&query).await?)),
        }
    })?;
    match if args.json { Format::Json } else { args.format } {
        Format::Table if rows.is_empty() => say("No builds.")?,
        // The sum of a few of them would be taken for that of all.
        Format::Table if args.limit.is_some() => say(&table(&rows).to_string())?,
        Format::Table => say(&format!("{}\n{}", table(&rows), sums_table(sums)))?,
        Format::Json => say_json(&rows)?,
        Format::Csv => say(&HistoryRow::csv(&rows)?)?,
    }
    Ok(Exit::Success)
}

/// What was published comes to, by machine.
fn sums_table(sums: Vec<HeightSum>) -> Table {
    let mut table = Table::new(&["PUBLISHED", ">HEIGHT mm", ">BUILDS", ">COPIES", ">MEAN DENSITY %"]);
    for sum in HeightSum::with_all(sums) {
        let (height, density) = (number(Some(sum.height_mm), 2), percent(sum.mean_density));
        table.row(vec![sum.profile, height, sum.builds.to_string(), sum.copies.to_string(), density]);
    }
    table
}

/// The builds.
pub fn table(rows: &[HistoryRow]) -> Table {
    let mut table = Table::new(&[
        ">BUILD",
        "PROFILE",
        "STATE",
        "TIME (UTC)",
        ">HEIGHT mm",
        ">BOUND mm",
        ">DENSITY %",
        ">LAYERS",
        ">PARTS",
        ">COPIES",
        ">PROVED mm",
        ">CPU s",
        "FILE",
    ]);
    for row in rows {
        table.row(vec![
            row.build.to_string(),
            row.profile.clone(),
            row.state.to_string(),
            brief(Some(row.at)),
            number(row.height_mm, 2),
            number(row.lower_bound_mm, 2),
            percent(row.density),
            or_dash(row.layers),
            row.parts.to_string(),
            or_dash(row.copies),
            number(row.clearance_proved_mm, 3),
            number(row.cpu_secs, 1),
            row.file_name.clone().unwrap_or_else(|| text(&row.reason)),
        ]);
    }
    table
}
