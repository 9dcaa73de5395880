//! What people said of the copies of a build, beside its record in the archive. A ledger that was put back from a backup does not know what was
//! said since: it is named then, with the command that says it again.

use std::{collections::BTreeMap, fs, io::Write, path::Path};

use anyhow::{Context, Result};
use jiff::Timestamp;
use ledger::{BuildId, BuildRow, Ledger, OperatorWord, PartId, PickMark, ReprintTarget, ToldOutcome, UtcTimestamp};
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

/// Notes a word that was said of these builds in their archives. What is noted there twice is named twice.
///
/// # Errors
/// The ledger cannot be read, or an archive cannot be written.
pub(crate) async fn note_word(
    settings: &Settings,
    ledger: &Ledger,
    (word, by): (&OperatorWord, &str),
    builds: &[BuildRow],
) -> Result<()> {
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
    let told = match word {
        OperatorWord::Outcome(_, told) => told.clone(),
        OperatorWord::BreakOut(_) => ToldOutcome { bad: bad_marks(ledger, build).await?, ..complete() },
        OperatorWord::Reprint(ReprintTarget::Build(build)) => return Ok(Some(format!("nestd reprint b{build}"))),
        OperatorWord::Reprint(ReprintTarget::Part(part, None)) => return Ok(Some(format!("nestd reprint p{part}"))),
        OperatorWord::Reprint(ReprintTarget::Part(part, Some(copies))) => {
            return Ok(Some(format!("nestd reprint p{part}={copies}")));
        }
        OperatorWord::Reprint(ReprintTarget::Order(order)) => return Ok(Some(format!("nestd reprint '{order}'"))),
        OperatorWord::Requeue(build) => return Ok(Some(format!("nestd requeue {build}"))),
        _ => return Ok(None),
    };
    let mut command = format!("nestd outcome {build} {}", told.outcome);
    if !told.bad.is_empty() {
        let bad: Vec<String> = told.bad.iter().map(|(part, copies)| format!("{part}={copies}")).collect();
        command += &format!(" --bad {}", bad.join(","));
    }
    for (is_said, option) in [(told.keep, " --keep"), (told.is_correction, " --correct")] {
        command += if is_said { option } else { "" };
    }
    Ok(Some(command))
}

fn complete() -> ToldOutcome {
    ToldOutcome::new(ledger::PrintOutcome::Complete, "", "")
}

/// The copies that are printed again by the marks of a cake: part and number.
async fn bad_marks(ledger: &Ledger, build: BuildId) -> Result<Vec<(PartId, u32)>> {
    let mut bad: BTreeMap<PartId, u32> = BTreeMap::new();
    for row in ledger.picks_of_build(build).await? {
        if matches!(row.mark, PickMark::Bad | PickMark::Missing) {
            *bad.entry(row.part_id).or_default() += 1;
        }
    }
    Ok(bad.into_iter().collect())
}

/// Names the words that were said after the last event that a restored ledger knows.
pub(super) fn name_words_since(
    settings: &Settings,
    last_event_at: Option<UtcTimestamp>,
    found: &mut ReconcileReport,
) -> Result<()> {
    let is_since = |said: &SaidWord| {
        let at = said.at.parse::<Timestamp>().ok();
        at.is_some_and(|at| last_event_at.is_none_or(|last| at > last.0))
    };
    for profile in settings.profiles.values() {
        for (_, record) in build_record::list_records(&profile.folders.archive)? {
            // It has none where nothing was said.
            let Ok(text) = fs::read_to_string(record.with_file_name(WORDS_NAME)) else { continue };
            let words = text.lines().filter_map(|line| serde_json::from_str::<SaidWord>(line).ok());
            for SaidWord { build, by, command, .. } in words.filter(is_since) {
                found.doubts.push(format!(
                    "after the backup was made, {by} said `{command}`. Say it again, save of copies that are in a later build: \
                     `nestd show b{build}` tells which"
                ));
            }
        }
    }
    Ok(())
}
