//! The one door for what a person says of published builds, whichever face says it: the command line, a page or a program. It looks
//! into the queue folders, where this process can see them; `ledger/operator_word` then judges the word and carries it out, notes it
//! for the daemon that serves the machine, or refuses it.

use std::{collections::BTreeSet, path::PathBuf, time::Duration};

use crate::{
    ledger::{BuildRow, Ledger, LedgerError, OperatorWord, WordAnswer},
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

async fn look_for_file(settings: &Settings, build: &BuildRow) -> SeenFile {
    let (Some(profile), Some(name)) = (settings.profiles.get(&build.profile), build.staged.file_name.clone()) else {
        return SeenFile::Unknown;
    };
    let folders: Vec<(String, PathBuf)> =
        profile.printers.iter().map(|printer| (printer.name.clone(), printer.queue.clone())).collect();
    let own = build.staged.queue_id.clone();
    let look = tokio::task::spawn_blocking(move || look_into(&folders, &name, own.as_deref()));
    match tokio::time::timeout(LOOK_TIMEOUT, look).await {
        Ok(Ok(seen)) => seen,
        _ => SeenFile::Unknown,
    }
}

fn look_into(folders: &[(String, PathBuf)], name: &str, own: Option<&str>) -> SeenFile {
    let mut seen = SeenFile::Unknown;
    for (printer, folder) in folders {
        let Some(queue) = QueueFolder::find(folder) else { continue };
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
