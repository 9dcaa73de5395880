//! `nestd quote`: when parts could be done that nobody has ordered yet, and what they would add.

use std::{path::PathBuf, sync::Arc};

use anyhow::{Context, Result};
use farm::{
    MaterialReading, QUOTE_SEARCH_TIME, QuoteError, QuoteMeshes, QuoteQuestion, QuotedFile, quote_order, read_plan,
    read_quoted_files,
};
use intake::{Ticket, read_copies_in_name};
use jiff::Timestamp;

use crate::cli::{
    CommandExit, CommonArgs, UsageError,
    serve::nest::{RequestedFile, parse_part_argument},
    terminal::{
        candidates,
        farm_context::{require_machine, with_ledger_to_read},
        table::{print_json, print_text},
    },
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct QuoteArgs {
    /// Part files (STL, 3MF, OBJ, PLY or CAMSPEC), with the number of copies, unless their names say it: bracket.stl=4
    #[arg(required = true, value_name = "FILE[=N]")]
    parts: Vec<String>,
    /// Machine
    #[arg(long, value_name = "MACHINE", add = candidates::of_machines())]
    machine: String,
    /// The date that is wished for: 2026-11-25 or 25.11.2026 (the end of that day), or "2026-11-25 17:00"
    #[arg(long, value_name = "DATE")]
    due: Option<String>,
    /// Ticket (TOML or JSON) that holds for all of them: unit, orientation, clearance, priority
    #[arg(long, value_name = "FILE")]
    ticket: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &QuoteArgs) -> Result<CommandExit> {
    let files = args.parts.iter().map(|text| parse_part_argument(text)).collect::<Result<Vec<_>>>()?;
    let ticket = match &args.ticket {
        Some(path) => intake::read_ticket(path).map_err(|error| UsageError(error.to_string()))?,
        None => Ticket::default(),
    };
    let asked = |file: RequestedFile| {
        let ticket = Ticket { copies: Some(wanted_copies(&file, ticket.copies)?), ..ticket.clone() };
        Ok(QuotedFile { name: file.name, path: file.file, ticket })
    };
    let files = files.into_iter().map(asked).collect::<Result<Vec<QuotedFile>>>()?;
    if let Some(missing) = files.iter().find(|file| !file.path.is_file()) {
        return Err(UsageError(format!("there is no file {}", missing.path.display())).into());
    }
    let (quote, sentences) = with_ledger_to_read(common, async |settings, ledger| {
        require_machine(settings, &args.machine)?;
        let profile = Arc::new(settings.profiles.get(&args.machine).context("its profile is not valid")?.clone());
        let zone = profile.time_zone.time_zone();
        let due = args.due.as_deref().map(|text| intake::parse_due_text(text, zone).map_err(UsageError)).transpose()?;
        let now = Timestamp::now();
        let reading = read_plan(ledger, &profile, now).await?;
        let parts = read_quoted_files(&profile, &settings.limits, &files, None, now).map_err(|error| match error {
            QuoteError::Refused(reason) => anyhow::anyhow!("it would be refused: {reason}"),
            QuoteError::AwaitsMaterial(why) | QuoteError::TryLater(why) => anyhow::anyhow!("{why}"),
        })?;
        MaterialReading::read(ledger, &settings.materials).await?.ensure_loaded(&parts)?;
        let question = QuoteQuestion { parts, due_at: due.map(|(at, _)| at), within: QUOTE_SEARCH_TIME };
        let quote = quote_order(&profile, &reading, question, &QuoteMeshes::of_farm(settings), (), now);
        let sentences = quote.sentences(&settings.time_zone);
        Ok((quote, sentences))
    })?;
    match args.json {
        true => print_json(&quote)?,
        false => sentences.iter().try_for_each(|sentence| print_text(sentence))?,
    }
    Ok(CommandExit::Success)
}

/// The copies of a file that would be ordered if it were dropped so: as it is said with it, else in its ticket, else in its name.
fn wanted_copies(file: &RequestedFile, in_ticket: Option<u32>) -> Result<u32> {
    match file.copies.or(in_ticket) {
        Some(copies) => Ok(copies),
        None => read_copies_in_name(&file.name)
            .number()
            .map_err(|why| UsageError(format!("{0}: {why}. Say how many: {0}=N", file.name)).into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quote_is_for_as_many_copies_as_the_same_file_would_order() {
        let of = |text: &str, in_ticket| wanted_copies(&parse_part_argument(text).unwrap(), in_ticket);
        let copies = |text: &str, in_ticket| of(text, in_ticket).unwrap();
        assert_eq!((copies("a.stl", None), copies("q 10x.stl", None), copies("q 10x.stl=3", None)), (1, 10, 3));
        assert_eq!((copies("q 10x.stl", Some(4)), copies("a.stl=2", Some(4))), (4, 2));
        let asked = of("2 or 3 pcs bracket.stl", None).unwrap_err().to_string();
        assert!(asked.contains("Say how many: 2 or 3 pcs bracket.stl=N"), "{asked}");
    }
}
