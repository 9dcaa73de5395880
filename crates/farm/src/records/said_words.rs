//! What people said of the copies of a build, beside its record in the archive. A ledger that was put back from a backup does not know what was
//! said since: it is named then, with the command that says it again.

use std::{collections::BTreeMap, fs, io::Write, path::Path};

use anyhow::{Context, Result};
use jiff::Timestamp;
use ledger::{BuildId, BuildRow, Ledger, OperatorWord, PartId, PrintOutcome, ReprintTarget, ToldOutcome, UtcTimestamp};
use serde::{Deserialize, Serialize};
use settings::Settings;

use super::{build_record, reconcile_report::ReconcileReport};

/// Name of the words in the build's folder, one JSON object a line; a dot-file, so that people do not see it.
const WORDS_NAME: &str = ".nestd-said.jsonl";

/// A word as it is kept.
#[derive(Debug, Serialize, Deserialize)]
struct SaidWord {
    build: BuildId,
    /// Time of the ledger's last event when it was said: the ledger had it by then.
    at: String,
    by: String,
    /// The command that says it again.
    command: String,
}

/// Notes a word that was said of these builds in the archive of each.
///
/// # Errors
/// The ledger cannot be read, or an archive cannot be written.
pub(crate) async fn note_word(
    settings: &Settings,
    ledger: &Ledger,
    (word, by): (&OperatorWord, &str),
    builds: &[BuildRow],
) -> Result<()> {
    if builds.is_empty() {
        return Ok(());
    }
    let Some(at) = ledger.last_event_at().await? else { return Ok(()) };
    for build in builds {
        let Some(command) = command_of(ledger, word, build.id).await? else { continue };
        let (Some(profile), Some(name)) = (settings.profiles.get(&build.machine), &build.staged.file_name) else {
            continue;
        };
        let said = SaidWord { build: build.id, at: at.to_string(), by: by.to_owned(), command };
        let (archive, name) = (profile.folders.archive.clone(), name.clone());
        tokio::task::spawn_blocking(move || append_word(&archive, &name, &said)).await.context("a step ended")??;
    }
    Ok(())
}

/// One line is written at once, so that two words never mix.
fn append_word(archive: &Path, name: &str, said: &SaidWord) -> Result<()> {
    if !build_record::has_record(archive, name)? {
        return Ok(());
    }
    let file = build_record::archive_folder(archive, name).join(WORDS_NAME);
    let line = format!("{}\n", serde_json::to_string(said)?);
    let opened = fs::File::options().append(true).create(true).open(&file);
    opened
        .and_then(|mut file| {
            file.write_all(line.as_bytes())?;
            file.sync_data()
        })
        .with_context(|| format!("writing {}", file.display()))
}

/// The command that says a word of a build again; `None` = the record of this build or the next tells it.
async fn command_of(ledger: &Ledger, word: &OperatorWord, build: BuildId) -> Result<Option<String>> {
    Ok(match word {
        OperatorWord::Outcome(_, told) => Some(outcome_command(build, told)),
        OperatorWord::BreakOut(_) => {
            let complete = ToldOutcome::new(PrintOutcome::Complete, "", "");
            Some(outcome_command(build, &ToldOutcome { bad: lost_by_marks(ledger, build).await?, ..complete }))
        }
        OperatorWord::Reprint(target) => Some(match target {
            ReprintTarget::Build(build) => format!("nestd reprint b{build}"),
            ReprintTarget::Part(part, None) => format!("nestd reprint p{part}"),
            ReprintTarget::Part(part, Some(copies)) => format!("nestd reprint p{part}={copies}"),
            ReprintTarget::Order(order) => format!("nestd reprint '{order}'"),
        }),
        OperatorWord::Requeue(build) => Some(format!("nestd requeue {build}")),
        _ => None,
    })
}

fn outcome_command(build: BuildId, told: &ToldOutcome) -> String {
    let bad: Vec<String> = told.bad.iter().map(|(part, copies)| format!("{part}={copies}")).collect();
    let bad = if bad.is_empty() { String::new() } else { format!(" --bad {}", bad.join(",")) };
    let (keep, correct) = (if told.keep { " --keep" } else { "" }, if told.is_correction { " --correct" } else { "" });
    format!("nestd outcome {build} {}{bad}{keep}{correct}", told.outcome)
}

/// The copies that are printed again by the marks of a cake: part and number.
async fn lost_by_marks(ledger: &Ledger, build: BuildId) -> Result<Vec<(PartId, u32)>> {
    let mut lost: BTreeMap<PartId, u32> = BTreeMap::new();
    for row in ledger.picks_of_build(build).await?.into_iter().filter(|row| row.mark.is_lost()) {
        *lost.entry(row.part_id).or_default() += 1;
    }
    Ok(lost.into_iter().collect())
}

/// Names the words that were said after the last event that a restored ledger knows. One of several builds is noted with each of them, and
/// named once.
pub(super) fn name_words_since(
    settings: &Settings,
    last_event_at: Option<UtcTimestamp>,
    found: &mut ReconcileReport,
) -> Result<()> {
    let is_since = |said: &SaidWord| {
        let at = said.at.parse::<Timestamp>().ok();
        at.is_some_and(|at| last_event_at.is_none_or(|last| at > last.0))
    };
    let mut since = BTreeMap::new();
    for profile in settings.profiles.values() {
        for (_, record) in build_record::list_records(&profile.folders.archive)? {
            // It has none where nothing was said.
            let Ok(text) = fs::read_to_string(record.with_file_name(WORDS_NAME)) else { continue };
            let words = text.lines().filter_map(|line| serde_json::from_str::<SaidWord>(line).ok());
            for SaidWord { build, at, by, command } in words.filter(is_since) {
                since.entry((at, by, command)).or_insert_with(Vec::new).push(format!("`nestd show b{build}`"));
            }
        }
    }
    found.doubts.extend(since.into_iter().map(|((_, by, command), shown)| {
        let shown = shown.join(", ");
        format!(
            "after the backup was made, {by} said `{command}`. Say it again, save of copies that are in a later build ({shown})"
        )
    }));
    Ok(())
}
