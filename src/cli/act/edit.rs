//! `nestd edit|cancel|move|confirm`: changes of what was asked, carried out by the daemon. `nestd reprint|requeue`: what
//! was printed is printed again.

use anyhow::Result;
use build_file::{MAX_COPIES, MAX_PRIORITY};
use ledger::{BuildId, Ledger, OperatorWord, PartEdit, ReprintTarget};
use nester::OrientationRule;
use settings::FarmZone;

use super::{
    command::{DaemonCommand, run_for_parts},
    operate::{say, say_all},
};
use crate::cli::{
    CommandExit, CommonArgs, UsageError,
    terminal::{
        candidates,
        farm_context::{load_settings, with_ledger},
        table::print_text,
        target::find_targets,
        values::{parse_build_number, parse_distance, parse_prefixed_number, parse_word},
    },
};

/// Arguments of `nestd edit`.
#[derive(Debug, clap::Args)]
pub struct EditArgs {
    /// Parts: numbers (5 or p5), orders, file names, patterns ('bracket*')
    #[arg(required = true, value_name = "PART|ORDER", add = candidates::of_parts())]
    targets: Vec<String>,
    /// Copies wanted in all, those in builds included
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_COPIES)))]
    copies: Option<u32>,
    /// When it is due: 2026-11-25 or 25.11.2026 (the end of that day), "2026-11-25 17:00", or none
    #[arg(long, value_name = "DATE")]
    due: Option<String>,
    /// Priority from 0 to 100; a part with 100 must be in the next build
    #[arg(long, value_name = "0-100", value_parser = clap::value_parser!(u8).range(0..=i64::from(MAX_PRIORITY)))]
    priority: Option<u8>,
    /// How it may be turned: free, upright, axis or fixed
    #[arg(long, value_name = "RULE", value_parser = parse_word::<OrientationRule>)]
    orientation: Option<OrientationRule>,
    /// Its own clearance in mm, or none
    #[arg(long, value_name = "MM")]
    clearance: Option<String>,
    /// Unit of its file: mm, cm, m, inch, ft or micron
    #[arg(long, value_name = "UNIT", value_parser = parse_word::<build_file::LengthUnit>)]
    unit: Option<build_file::LengthUnit>,
    /// A note for people, or none
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
    /// Name of its order, or none
    #[arg(long, value_name = "NAME")]
    order: Option<String>,
    /// What it is to be made of, or none
    #[arg(long, value_name = "NAME")]
    material: Option<String>,
    /// Finishing steps after the print, such as "dye black, smooth", or none; can also be changed where nothing waits any more
    #[arg(long, value_name = "STEPS")]
    finish: Option<String>,
    /// Who it is for, or none; can also be changed where nothing waits any more
    #[arg(long, value_name = "NAME")]
    customer: Option<String>,
    /// Where the customer gets e-mail when the order is complete, or none; can also be changed where nothing waits any more
    #[arg(long, value_name = "ADDRESS")]
    email: Option<String>,
}

/// Runs `nestd edit`.
pub fn run(common: &CommonArgs, args: &EditArgs) -> Result<CommandExit> {
    let edit = args.to_edit(&load_settings(common)?.time_zone)?;
    if edit.is_empty() {
        return Err(UsageError("say what is to change, for example --copies 3 or --due 2026-11-25".to_owned()).into());
    }
    run_for_parts(
        common,
        &args.targets,
        |parts| format!("nestd edit {parts} .."),
        |target| match target.copies {
            None => {
                // Of an order of which some is printed, what can be changed there.
                let possible =
                    Some(edit.possible_in(target.part.state)).filter(|part| edit.copies.is_none() && !part.is_empty());
                Ok(DaemonCommand::Edit(target.part.id, Box::new(possible.unwrap_or_else(|| edit.clone()))))
            }
            Some(_) => Err(UsageError("an edit concerns whole parts: say --copies N for a number".to_owned()).into()),
        },
    )
}

/// Whether a word says that there is none.
pub(super) fn is_none(word: &str) -> bool {
    word.is_empty() || word.eq_ignore_ascii_case("none")
}

impl EditArgs {
    fn to_edit(&self, zone: &FarmZone) -> Result<PartEdit> {
        let due = self.due.as_deref().map(|text| match is_none(text) {
            true => Ok(None),
            false => intake::parse_due_text(text, zone.time_zone()).map(Some).map_err(UsageError),
        });
        let clearance = self.clearance.as_deref().map(|text| match is_none(text) {
            true => Ok(None),
            false => parse_distance(text).map(Some).map_err(UsageError),
        });
        let text = |given: &Option<String>| {
            given.as_deref().map(|word| if is_none(word) { String::new() } else { word.to_owned() })
        };
        let edit = PartEdit {
            copies: self.copies,
            order_name: text(&self.order),
            customer: text(&self.customer),
            email: text(&self.email),
            material: text(&self.material),
            finish: text(&self.finish),
            priority: self.priority,
            due: due.transpose()?,
            orientation: self.orientation,
            tilts: None,
            clearance_mm: clearance.transpose()?,
            unit: self.unit,
            note: text(&self.note),
        };
        edit.checked().map_err(|wrong| UsageError(wrong).into())
    }
}

/// Runs `nestd cancel`.
pub fn run_cancel(common: &CommonArgs, targets: &[String]) -> Result<CommandExit> {
    let again = |parts: &str| format!("nestd cancel {parts}");
    run_for_parts(common, targets, again, |target| Ok(DaemonCommand::Cancel(target.part.id, target.copies)))
}

/// Runs `nestd move`.
pub fn run_move(common: &CommonArgs, targets: &[String], machine: &str) -> Result<CommandExit> {
    let again = |parts: &str| format!("nestd move {parts} --to {machine}");
    run_for_parts(common, targets, again, |target| Ok(DaemonCommand::Move(target.part.id, machine.to_owned())))
}

/// Runs `nestd confirm`.
pub fn run_confirm(common: &CommonArgs, targets: &[String]) -> Result<CommandExit> {
    let again = |parts: &str| format!("nestd confirm {parts}");
    run_for_parts(common, targets, again, |target| Ok(DaemonCommand::Confirm(target.part.id)))
}

/// Runs `nestd reprint`.
pub fn run_reprint(common: &CommonArgs, words: &[String], anyway: bool) -> Result<CommandExit> {
    let sentences = with_ledger(common, async |settings, ledger| {
        let mut all = Vec::new();
        for word in words {
            all.extend(reprint_targets(ledger, word).await?.into_iter().map(OperatorWord::Reprint));
        }
        say_all(settings, ledger, &all, anyway).await
    })?;
    sentences.iter().try_for_each(|sentence| print_text(sentence))?;
    Ok(CommandExit::Success)
}

/// What a word means: `b4`, `p5`, `5=2`, the name of an order or of a file.
async fn reprint_targets(ledger: &Ledger, word: &str) -> Result<Vec<ReprintTarget>> {
    if let Some(order) = word.strip_prefix("order:") {
        return Ok(vec![ReprintTarget::Order(order.to_owned())]);
    }
    if word.parse::<u64>().is_ok() {
        let text = format!(
            "say b{word} for build {word}, p{word} for part {word}, or order:{word} for the order of that name"
        );
        return Err(UsageError(text).into());
    }
    if let Some(build) = parse_prefixed_number(word, 'b') {
        return Ok(vec![ReprintTarget::Build(BuildId(build))]);
    }
    if !ledger.parts_of_order(word).await?.is_empty() {
        return Ok(vec![ReprintTarget::Order(word.to_owned())]);
    }
    let targets = find_targets(ledger, &[word.to_owned()], |parts| format!("nestd reprint {parts}")).await?;
    Ok(targets.into_iter().map(|target| ReprintTarget::Part(target.part.id, target.copies)).collect())
}

/// Arguments of `nestd requeue`.
#[derive(Debug, clap::Args)]
pub struct RequeueArgs {
    /// Build number, as history prints it (4 or b4)
    #[arg(value_parser = parse_build_number, add = candidates::of_builds())]
    build: i64,
    /// Also if the file of the build lies in the queue: it is taken out first
    #[arg(long)]
    anyway: bool,
}

/// Runs `nestd requeue`.
pub fn run_requeue(common: &CommonArgs, args: &RequeueArgs) -> Result<CommandExit> {
    say(common, &[OperatorWord::Requeue(BuildId(args.build))], args.anyway)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(clap::Parser)]
    struct TestLine {
        #[command(flatten)]
        args: EditArgs,
    }

    #[test]
    fn none_takes_every_text_away() {
        use clap::Parser;
        for option in ["--customer", "--email", "--order", "--material", "--finish", "--note"] {
            let edit = |word: &str| {
                let line =
                    TestLine::try_parse_from(["edit", "p1", option, word]).unwrap_or_else(|error| panic!("{error}"));
                line.args.to_edit(&FarmZone::default()).unwrap()
            };
            assert_eq!(edit("none"), edit(""), "{option}");
            assert!(!edit("none").is_empty(), "{option} none changes something");
            assert!(!format!("{:?}", edit("None")).contains("None\")"), "{option}");
        }
    }

    #[test]
    fn a_due_date_is_read_as_in_lists_and_in_the_zone_of_the_farm() {
        let berlin = FarmZone::from(jiff::tz::TimeZone::get("Europe/Berlin").unwrap());
        let args = |due: &str| EditArgs {
            targets: Vec::new(),
            copies: None,
            due: Some(due.to_owned()),
            priority: None,
            orientation: None,
            clearance: None,
            unit: None,
            note: None,
            order: None,
            customer: None,
            email: None,
            material: None,
            finish: None,
        };
        let due = |text: &str| args(text).to_edit(&berlin).unwrap().due.unwrap();
        let day = Some(("2026-12-24T22:59:59Z".parse().unwrap(), "2026-12-24".to_owned()));
        assert_eq!((due("24.12.2026"), due("2026-12-24"), due("none")), (day.clone(), day, None));
        assert_eq!(due("24.12.2026 17:00").unwrap().0.to_string(), "2026-12-24T16:00:00Z");
        assert!(args("soon").to_edit(&berlin).unwrap_err().to_string().contains("such as 2026-11-25"));
    }
}
