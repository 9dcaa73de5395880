//! What the folders tell of builds that a restored ledger knows: that they were published or taken back since, and whether a word that
//! waited for their file can still be carried out.

use anyhow::Result;
use delivery::queue::FileState;
use ledger::{BuildRow, BuildState, Ledger, TakeBackEnd, TakenBackFor, WITHDRAWN_BY_NESTD};
use settings::{MachineProfile, Settings};

use crate::records::{build_record, folder_builds, reconcile_report::ReconcileReport};

/// Records of verified builds that they were published after the backup was made: they have a record and no dot-file any more. The next
/// start finds them in their queue, or taken, and asks nobody for a yes.
pub(super) async fn record_published_builds(
    settings: &Settings,
    ledger: &Ledger,
    found: &mut ReconcileReport,
) -> Result<()> {
    for build in ledger.builds_in_state(BuildState::Verified).await? {
        let Some((profile, name)) = place_of(settings, &build) else { continue };
        let Some(record) = build_record::read_record(&profile.folders.archive, name)? else { continue };
        let is_withdrawn = build_record::is_withdrawn(&record);
        if build.staged.publishing_at.is_some() && !is_withdrawn
            || folder_builds::is_staged(profile, name, build.staged.queue_id.as_deref())?
        {
            continue;
        }
        ledger.begin_publishing(build.id).await?;
        if is_withdrawn {
            ledger.publish_build(build.id).await?;
        }
        found.done.push(format!("build {} ({name} of {}) was published since", build.id, build.machine));
    }
    Ok(())
}

/// Puts the copies of published builds back whose files were taken back untouched after the backup was made. Nobody can have printed
/// them; later builds, which are taken in after this, may have them.
pub(super) async fn take_in_withdrawals(
    settings: &Settings,
    ledger: &Ledger,
    found: &mut ReconcileReport,
) -> Result<()> {
    for build in ledger.builds_in_state(BuildState::Published).await? {
        let Some((profile, name)) = place_of(settings, &build) else { continue };
        let record = build_record::read_record(&profile.folders.archive, name)?;
        if record.is_some_and(|record| build_record::is_withdrawn(&record)) {
            ledger.take_in_withdrawal(build.id).await?;
            found.done.push(format!(
                "the file of build {} ({name} of {}) was taken back out of the queue untouched since; its copies wait, or are in a \
                 later build",
                build.id, build.machine
            ));
        }
    }
    Ok(())
}

/// A word that waited for a file when the backup was made is dropped where the file is in no queue folder any more: nobody knows
/// whether a printer took it, or nestd, which then did as was said.
pub(super) async fn end_noted_words(settings: &Settings, ledger: &Ledger, found: &mut ReconcileReport) -> Result<()> {
    for name in settings.profiles.keys() {
        for build in ledger.builds_to_take_back(name).await? {
            let (id, Some(by)) = (build.id, build.place.withdraw_by.clone()) else { continue };
            let is_over = ledger.taken_back_for(id).await? == Some(TakenBackFor::Nothing);
            let place = place_of(settings, &build);
            if is_over || place.is_none_or(|(machine, file)| is_in_queue(machine, file)) {
                continue;
            }
            ledger.end_take_back(id, TakeBackEnd::Removed).await?;
            // Its record would say so if nestd had taken it back: its printer did.
            if by == WITHDRAWN_BY_NESTD {
                continue;
            }
            found.doubts.push(format!(
                "before the backup was made, {by} said that copies of build {id} are to be printed again, and its file was to be taken out \
                 of the queue first. It is in no queue folder of {name} now: its printer took it, or nestd did, and then did as {by} said. \
                 That word is dropped. `nestd show b{id}` says which of its copies wait, or are in a later build: say it once more only of \
                 the others"
            ));
        }
    }
    Ok(())
}

/// The machine of a build and the name of its file.
fn place_of<'a>(settings: &'a Settings, build: &'a BuildRow) -> Option<(&'a MachineProfile, &'a str)> {
    Some((settings.profiles.get(&build.machine)?, build.staged.file_name.as_deref()?))
}

/// Whether a file is visible in a queue folder of a machine, or was taken back there.
fn is_in_queue(profile: &MachineProfile, name: &str) -> bool {
    let mut queues = profile.printers.iter().filter_map(|printer| printer.queue.find());
    queues.any(|queue| !matches!(queue.state(name), Ok(FileState::Gone)))
}
