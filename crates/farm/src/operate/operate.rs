//! The one door for what a person says of builds, printers and orders, whichever face says it: the command line, a page or a program. It
//! looks into the queue folders, where this process can see them; `ledger/words/operator_word` then judges the word and carries it out, notes
//! it for the daemon that serves the machine, or refuses it.

use std::time::Duration;

use anyhow::Context;
use build_file::check_name;
use delivery::queue::{OpenQueue, QueueAddress};
use ledger::{
    BuildId, BuildRow, BuildState, Ledger, LedgerError, MaterialError, OperatorWord, SeenFile, SeenFiles, WordAnswer,
};
use settings::Settings;

use crate::{
    nesting::node_client::NodeClient,
    printers::printers::fate_of_queued,
    records::said_words::note_word,
    scanning::{
        machine_fit::find_misfit,
        queue_contents::{BuildFiles, ContentReader, SoughtFile, VisibleFile, is_at, is_proved},
    },
};

/// How long a queue folder may take to answer. On a share that hangs, the file may still be there.
const LOOK_TIMEOUT: Duration = Duration::from_secs(5);
/// How long another node may take to look into its queues.
const ASK_TIMEOUT: Duration = Duration::from_secs(8);

/// What was seen of the file of a build.
struct FileLook {
    place: QueuePlace,
    /// Where its copies lie visible besides.
    others: Vec<String>,
    /// Where second files were seen, in queues that could not be looked into.
    unseen: Vec<String>,
}

/// Where the file of a build is, as far as this process can see.
enum QueuePlace {
    /// Something is visible under its name.
    Visible {
        printer: String,
        /// Marker of the folder.
        queue_id: String,
        /// Whether it is what was proved, as far as it could be read.
        is_proved: bool,
    },
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
    let word = &with_known_material(settings, word)?;
    let mut seen = SeenFiles::new();
    let meant = ledger.builds_meant(word).await?;
    for build in meant.clone() {
        let (id, file) = (build.id, see_file(ledger, settings, build, word).await?);
        seen.extend(file.map(|file| (id, file)));
    }
    if let OperatorWord::Release { build, .. } = word {
        ensure_not_made_again(ledger, settings, *build).await?;
    }
    let mut answer = ledger.carry_out(word, by, &seen, anyway).await?;
    // It is said, whether or not its note is kept.
    match tokio::time::timeout(LOOK_TIMEOUT, note_word(settings, ledger, (word, by), &meant)).await {
        Ok(Ok(())) => {}
        Ok(Err(failure)) => tracing::warn!("What was said is in the ledger, and not in the archive: {failure:#}."),
        Err(_) => tracing::warn!("What was said is in the ledger, and not in the archive, which does not answer."),
    }
    if let OperatorWord::PrinterDown { machine: profile, printer, .. } = word
        && let Some(profile) = settings.profiles.get(profile)
    {
        answer.sentences.push(fate_of_queued(ledger, profile, printer).await?);
    }
    Ok(answer)
}

/// A word with the name of the material that is loaded, as the settings call it.
fn with_known_material(settings: &Settings, word: &OperatorWord) -> Result<OperatorWord, LedgerError> {
    let OperatorWord::Load { machine, material, lot } = word else { return Ok(word.clone()) };
    if !settings.profiles.contains_key(machine) {
        return Err(MaterialError::NoMachine(machine.clone()).into());
    }
    let material = check_name("material", material).map_err(LedgerError::UnusableTerm)?;
    let lot = check_name("lot", lot).map_err(LedgerError::UnusableTerm)?;
    Ok(OperatorWord::Load { machine: machine.clone(), material: settings.materials.require_name(&material)?, lot })
}

/// A build that does not fit its machine any more is made again before it is published: nobody can say yes to it.
async fn ensure_not_made_again(ledger: &Ledger, settings: &Settings, build: BuildId) -> Result<(), LedgerError> {
    let Some(row) = ledger.find_build(build).await?.filter(|row| row.state == BuildState::Verified) else {
        return Ok(());
    };
    match settings.profiles.get(&row.machine).and_then(|machine| find_misfit(machine, &row)) {
        Some(why) => Err(LedgerError::MadeAgain { build, why }),
        None => Ok(()),
    }
}

/// What is certain of the file of a published build, as the node sees it whose queues are meant. Where that does not answer, as it is seen
/// from here.
async fn see_file(
    ledger: &Ledger,
    settings: &Settings,
    build: BuildRow,
    word: &OperatorWord,
) -> Result<Option<SeenFile>, LedgerError> {
    let is_outcome = matches!(word, OperatorWord::Outcome(..));
    let node = match settings.profiles.get(&build.machine) {
        Some(machine) => NodeClient::of_machine(settings, ledger, machine).await?,
        None => None,
    };
    if let Some(node) = node.filter(|node| node.is_alive) {
        let path = format!("/builds/{}/seen?outcome={is_outcome}", build.id);
        let asked = tokio::task::spawn_blocking(move || {
            let answer = node.get(&path, ASK_TIMEOUT)?.context("it knows no such build")?;
            Ok::<_, anyhow::Error>(serde_json::from_reader(answer.into_reader())?)
        });
        match asked.await {
            Ok(Ok(seen)) => return Ok(seen),
            Ok(Err(failure)) => tracing::warn!("The queues of {} cannot be asked for: {failure:#}.", build.machine),
            Err(failure) => tracing::warn!("The queues of {} cannot be asked for: {failure}.", build.machine),
        }
    }
    see_own_file(ledger, settings, build, is_outcome).await
}

/// What is certain of the file of a published build, as far as it can be seen from this node. `is_outcome` = the outcome of its print is
/// being told.
///
/// # Errors
/// The ledger does not answer.
pub async fn see_own_file(
    ledger: &Ledger,
    settings: &Settings,
    build: BuildRow,
    is_outcome: bool,
) -> Result<Option<SeenFile>, LedgerError> {
    let second = ledger.second_files(build.id).await?;
    let is_second = !second.is_empty();
    let FileLook { place: seen, others, unseen } = look_for_file(settings, &build, second.clone()).await;
    if let QueuePlace::Visible { printer, queue_id, .. } = &seen {
        ledger.record_back_in_queue(build.id, printer, queue_id).await?;
    }
    if !others.is_empty() {
        let own = if let QueuePlace::Visible { printer, .. } = seen { Some(printer) } else { None };
        return Ok(Some(SeenFile::Copied { own, is_second, others }));
    }
    if !unseen.is_empty() {
        return Ok(Some(SeenFile::SecondUnseen { places: unseen }));
    }
    let place = &build.place;
    let is_out = match seen {
        QueuePlace::Visible { printer, is_proved: false, .. } => return Ok(Some(SeenFile::Altered { printer })),
        // Both were copies of one print: nobody but a person can say whether the one that is gone is printed.
        QueuePlace::Visible { printer, .. } if is_second => {
            return Ok(Some(SeenFile::SecondGone { printer, places: second }));
        }
        QueuePlace::Visible { printer, .. } => return Ok(Some(SeenFile::Untouched { printer })),
        _ if place.move_queue_id.is_some() => false,
        QueuePlace::Gone(queue_id) => {
            ledger.record_taken(build.id, &queue_id).await?;
            true
        }
        // A move ends without a file once an outcome is told.
        QueuePlace::Withdrawn => place.move_to.is_some() && is_outcome,
        QueuePlace::Unknown => {
            place.taken_at.is_some() || place.withdrawn_at.is_some() || build.staged.queue_id.is_none()
        }
    };
    Ok(is_out.then_some(SeenFile::OutOfQueue))
}

/// Looks into the queues of the machine of a build.
async fn look_for_file(settings: &Settings, build: &BuildRow, second: Vec<String>) -> FileLook {
    let unknown = FileLook { place: QueuePlace::Unknown, others: Vec::new(), unseen: second.clone() };
    let Some(profile) = settings.profiles.get(&build.machine) else { return unknown };
    let queues: Vec<(String, QueueAddress)> =
        profile.printers.iter().map(|printer| (printer.name.clone(), printer.queue.clone())).collect();
    let build = build.clone();
    let look = tokio::task::spawn_blocking(move || look_into(&queues, &build, &second));
    match tokio::time::timeout(LOOK_TIMEOUT, look).await {
        Ok(Ok(Some(seen))) => seen,
        _ => unknown,
    }
}

/// `None` = the build was never written.
fn look_into(printers: &[(String, QueueAddress)], build: &BuildRow, second: &[String]) -> Option<FileLook> {
    let sought = SoughtFile::of(build, second)?;
    let name = sought.name;
    let find = |(printer, queue): &(String, QueueAddress)| Some((printer.clone(), queue.find()?));
    let queues: Vec<(String, OpenQueue)> = printers.iter().filter_map(find).collect();
    let published_in = queues.iter().find(|(_, queue)| Some(queue.id()) == sought.queue_id);
    // Before and after: it may come or go meanwhile.
    let was_withdrawn = published_in.is_some_and(|(_, queue)| queue.holds_taken_back(name));
    let files = BuildFiles::find(&queues, &sought);
    let others = files.other_places();
    let is_unseen = |place: &&String| !queues.iter().any(|(printer, _)| is_at(place, printer));
    let unseen = second.iter().filter(is_unseen).cloned().collect();
    if let Some(VisibleFile { printer, queue, .. }) = files.own {
        let mut reader = ContentReader::new(1);
        let is_proved = queue.stamp(name).is_none_or(|stamp| is_proved(build, (&*queue, name, stamp), &mut reader));
        let place = QueuePlace::Visible { printer, queue_id: queue.id().to_owned(), is_proved };
        return Some(FileLook { place, others, unseen });
    }
    let place = match published_in {
        // The marker once more: the folder may have been unmounted in between.
        Some((_, queue)) if queue.state(name).is_ok() && queue.check().is_ok() => {
            match was_withdrawn || queue.holds_taken_back(name) {
                true => QueuePlace::Withdrawn,
                false => QueuePlace::Gone(queue.id().to_owned()),
            }
        }
        _ => QueuePlace::Unknown,
    };
    Some(FileLook { place, others, unseen })
}
