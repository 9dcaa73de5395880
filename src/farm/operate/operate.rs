//! The one door for what a person says of published builds, whichever face says it: the command line, a page or a program. It looks
//! into the queue folders, where this process can see them; `ledger/words/operator_word` then judges the word and carries it out, notes it
//! for the daemon that serves the machine, or refuses it.

use std::{collections::BTreeSet, fs, path::PathBuf, time::Duration};

use crate::{
    farm::{records::staged_build::has_hash, scanning::queue_files::own_name},
    ledger::{BuildRow, InQueueError, Ledger, LedgerError, OperatorWord, PrintOutcome, StagedFile, WordAnswer},
    queue::{QueueFolder, StagedState},
    settings::Settings,
};

/// How long a queue folder may take to answer. On a share that hangs, the file may still be there.
const LOOK_TIMEOUT: Duration = Duration::from_secs(5);

/// Where the file of a build is, as far as this process can see.
enum SeenFile {
    /// It is visible in the queue folder of this printer, with this marker.
    Visible(String, String),
    /// The folder where it was published is there, and the file is not; with the marker of that folder.
    Gone(String),
    /// It was taken back out of the folder where it was published.
    Withdrawn,
    /// Its bytes lie in a queue folder under this other name.
    Copied(String),
    Unknown,
}

/// Says a word: carries it out, notes it or refuses it. `anyway` = the person insists although the file of a build lies in a queue.
pub async fn operate(
    ledger: &Ledger,
    settings: &Settings,
    word: &OperatorWord,
    by: &str,
    anyway: bool,
) -> Result<WordAnswer, LedgerError> {
    let mut out_of_queue = BTreeSet::new();
    for build in ledger.builds_meant(word).await? {
        if is_out_of_queue(ledger, settings, &build, word).await? {
            out_of_queue.insert(build.id);
        }
    }
    ledger.carry_out(word, by, &out_of_queue, anyway).await
}

/// Whether the file of a published build is certainly in no queue folder, and comes into none.
async fn is_out_of_queue(
    ledger: &Ledger,
    settings: &Settings,
    build: &BuildRow,
    word: &OperatorWord,
) -> Result<bool, LedgerError> {
    let place = &build.place;
    Ok(match look_for_file(settings, build).await {
        SeenFile::Visible(printer, queue_id) => {
            ledger.record_back_in_queue(build.id, &printer, &queue_id).await?;
            false
        }
        SeenFile::Copied(name) if prints_again(word) => {
            return Err(LedgerError::InQueue(InQueueError::Copied { build: build.id, name }));
        }
        SeenFile::Copied(_) => false,
        _ if place.move_queue_id.is_some() => false,
        SeenFile::Gone(queue_id) => {
            ledger.record_taken(build.id, &queue_id).await?;
            true
        }
        // A move ends without a file once an outcome is told.
        SeenFile::Withdrawn => place.move_to.is_some() && matches!(word, OperatorWord::Outcome(..)),
        SeenFile::Unknown => {
            place.taken_at.is_some() || place.withdrawn_at.is_some() || build.staged.queue_id.is_none()
        }
    })
}

/// Whether a word says by itself that copies are to be printed again.
fn prints_again(word: &OperatorWord) -> bool {
    match word {
        OperatorWord::Outcome(_, told) => told.outcome == PrintOutcome::Failed || !told.bad.is_empty(),
        OperatorWord::Reprint(_) | OperatorWord::Requeue(_) | OperatorWord::Withdraw(..) => true,
        OperatorWord::BreakOut(_) => false,
    }
}

async fn look_for_file(settings: &Settings, build: &BuildRow) -> SeenFile {
    let (Some(profile), Some(name)) = (settings.profiles.get(&build.profile), build.staged.file_name.clone()) else {
        return SeenFile::Unknown;
    };
    let folders: Vec<(String, PathBuf)> =
        profile.printers.iter().map(|printer| (printer.name.clone(), printer.queue.clone())).collect();
    let staged = build.staged.clone();
    let look = tokio::task::spawn_blocking(move || look_into(&folders, &name, &staged));
    match tokio::time::timeout(LOOK_TIMEOUT, look).await {
        Ok(Ok(seen)) => seen,
        _ => SeenFile::Unknown,
    }
}

fn look_into(folders: &[(String, PathBuf)], name: &str, staged: &StagedFile) -> SeenFile {
    let own = staged.queue_id.as_deref();
    let mut seen = SeenFile::Unknown;
    let queues: Vec<(&String, QueueFolder)> =
        folders.iter().filter_map(|(printer, folder)| Some((printer, QueueFolder::find(folder)?))).collect();
    if let Some(other) = queues.iter().find_map(|(_, queue)| find_copy(queue, name, staged)) {
        return SeenFile::Copied(other);
    }
    for (printer, queue) in queues {
        let is_withdrawn = queue.withdrawn_path(name).exists();
        match queue.staged_state(name) {
            Ok(StagedState::Published) => return SeenFile::Visible(printer.clone(), queue.marker_id().to_owned()),
            // The marker once more: the folder may have been unmounted in between.
            Ok(_) if Some(queue.marker_id()) == own && queue.check_marker().is_ok() => {
                seen = match is_withdrawn {
                    true => SeenFile::Withdrawn,
                    false => SeenFile::Gone(queue.marker_id().to_owned()),
                };
            }
            _ => {}
        }
    }
    seen
}

/// The name, other than its own, under which a build file lies in a queue folder: its bytes, or what was made of them.
fn find_copy(queue: &QueueFolder, name: &str, staged: &StagedFile) -> Option<String> {
    let (bytes, hash) = (staged.file_bytes?, staged.file_hash.as_deref()?);
    let names = fs::read_dir(queue.folder_path()).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|other| other != name && !other.starts_with('.')).find(|other| {
        let path = queue.published_path(other);
        let Ok(seen) = fs::symlink_metadata(&path) else { return false };
        let is_same = || seen.len() == bytes && has_hash(&path, hash).unwrap_or(false);
        let is_made_of_it = || other.to_lowercase().ends_with(".3mf") && own_name(&path).as_deref() == Some(name);
        seen.is_file() && (is_same() || is_made_of_it())
    })
}
