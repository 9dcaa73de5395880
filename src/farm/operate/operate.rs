//! The one door for what a person says of builds and printers, whichever face says it: the command line, a page or a program. It looks
//! into the queue folders, where this process can see them; `ledger/words/operator_word` then judges the word and carries it out, notes it
//! for the daemon that serves the machine, or refuses it.

use std::time::Duration;

use ledger::{BuildId, BuildRow, BuildState, Ledger, LedgerError, OperatorWord, SeenFile, SeenFiles, WordAnswer};

use crate::{
    farm::{
        printers::printers::fate_of_queued,
        scanning::{machine_fit::find_misfit, queue_contents},
    },
    queue::{FileState, OpenQueue, QueueAddress},
    settings::Settings,
};

/// How long a queue folder may take to answer. On a share that hangs, the file may still be there.
const LOOK_TIMEOUT: Duration = Duration::from_secs(5);

/// Where the file of a build is, as far as this process can see.
enum QueuePlace {
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
    let mut seen = SeenFiles::new();
    for build in ledger.builds_meant(word).await? {
        let (id, file) = (build.id, see_file(ledger, settings, build, word).await?);
        seen.extend(file.map(|file| (id, file)));
    }
    if let OperatorWord::Release { build, .. } = word {
        ensure_not_made_again(ledger, settings, *build).await?;
    }
    let mut answer = ledger.carry_out(word, by, &seen, anyway).await?;
    if let OperatorWord::PrinterDown { profile, printer, .. } = word
        && let Some(profile) = settings.profiles.get(profile)
    {
        answer.sentences.push(fate_of_queued(ledger, profile, printer).await?);
    }
    Ok(answer)
}

/// A build that does not fit its machine any more is made again before it is published: nobody can say yes to it.
async fn ensure_not_made_again(ledger: &Ledger, settings: &Settings, build: BuildId) -> Result<(), LedgerError> {
    let Some(row) = ledger.find_build(build).await?.filter(|row| row.state == BuildState::Verified) else {
        return Ok(());
    };
    match settings.profiles.get(&row.profile).and_then(|profile| find_misfit(profile, &row)) {
        Some(why) => Err(LedgerError::MadeAgain { build, why }),
        None => Ok(()),
    }
}

/// What is certain of the file of a published build.
async fn see_file(
    ledger: &Ledger,
    settings: &Settings,
    build: BuildRow,
    word: &OperatorWord,
) -> Result<Option<SeenFile>, LedgerError> {
    let (copy, seen) = look_for_file(settings, &build).await;
    if let QueuePlace::Visible(printer, queue_id) = &seen {
        ledger.record_back_in_queue(build.id, printer, queue_id).await?;
    }
    if let Some(name) = copy {
        return Ok(Some(SeenFile::Copied { name, is_alone: !matches!(seen, QueuePlace::Visible(..)) }));
    }
    let place = &build.place;
    let is_out = match seen {
        QueuePlace::Visible(..) => false,
        _ if place.move_queue_id.is_some() => false,
        QueuePlace::Gone(queue_id) => {
            ledger.record_taken(build.id, &queue_id).await?;
            true
        }
        // A move ends without a file once an outcome is told.
        QueuePlace::Withdrawn => place.move_to.is_some() && matches!(word, OperatorWord::Outcome(..)),
        QueuePlace::Unknown => {
            place.taken_at.is_some() || place.withdrawn_at.is_some() || build.staged.queue_id.is_none()
        }
    };
    Ok(is_out.then_some(SeenFile::OutOfQueue))
}

/// The name, other than its own, under which the file of a build lies in a queue folder of its machine; and where its own is.
async fn look_for_file(settings: &Settings, build: &BuildRow) -> (Option<String>, QueuePlace) {
    let (Some(profile), Some(name)) = (settings.profiles.get(&build.profile), build.staged.file_name.clone()) else {
        return (None, QueuePlace::Unknown);
    };
    let queues: Vec<(String, QueueAddress)> =
        profile.printers.iter().map(|printer| (printer.name.clone(), printer.queue.clone())).collect();
    let own = build.staged.queue_id.clone();
    let look = tokio::task::spawn_blocking(move || look_into(&queues, &name, own.as_deref()));
    match tokio::time::timeout(LOOK_TIMEOUT, look).await {
        Ok(Ok(seen)) => seen,
        _ => (None, QueuePlace::Unknown),
    }
}

fn look_into(printers: &[(String, QueueAddress)], name: &str, own: Option<&str>) -> (Option<String>, QueuePlace) {
    let mut seen = QueuePlace::Unknown;
    let queues: Vec<(&String, OpenQueue)> =
        printers.iter().filter_map(|(printer, queue)| Some((printer, queue.find()?))).collect();
    let copy = queues.iter().find_map(|(_, queue)| queue_contents::find_copy(&**queue, name));
    for (printer, queue) in queues {
        let is_withdrawn = queue.holds_taken_back(name);
        match queue.state(name) {
            Ok(FileState::Visible) => {
                return (copy, QueuePlace::Visible(printer.clone(), queue.id().to_owned()));
            }
            // The marker once more: the folder may have been unmounted in between.
            Ok(_) if Some(queue.id()) == own && queue.check().is_ok() => {
                seen = match is_withdrawn {
                    true => QueuePlace::Withdrawn,
                    false => QueuePlace::Gone(queue.id().to_owned()),
                };
            }
            _ => {}
        }
    }
    (copy, seen)
}
