//! `nestd history`: builds with their heights.

use anyhow::Result;
use jiff::Timestamp;

use super::{
    Common, Exit, Usage,
    reach::{look_at_ledger, time_argument},
    table::{Table, say, say_json},
};
use crate::{
    ledger::{HeightSum, HistoryQuery},
    tables::{HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS, csv_of},
};

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
        Format::Table => {
            let mut text = Table::of(HISTORY_COLUMNS, &rows).to_string();
            // The sum of a few of them would be taken for that of all.
            if args.limit.is_none() {
                text += &format!("\nPublished\n{}", Table::of(HEIGHT_SUM_COLUMNS, &HeightSum::with_all(sums)));
            }
            say(&text)?;
        }
        Format::Json => say_json(&rows)?,
        Format::Csv => say(&csv_of(HISTORY_COLUMNS, &rows)?)?,
    }
    Ok(Exit::Success)
}
