//! Housekeeping: old archives go, and the store forgets what nobody needs.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};
use jobs::BackgroundJob;
use ledger::PartState;
use settings::{OutputRules, Settings};
use tracing::{info, warn};

use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    core::{
        desks::{Receiving, Serving, Shared, Storing},
        farm::Farm,
    },
    files::claim_note,
    leases::{folder_lease::FolderLease, own_machines},
    receive::forget,
    records::forgettable::{Forgettable, KEEP_REFUSED_SECS},
};

/// Parts that were built or forgotten longer ago than this were handled by an earlier run.
const SWEEP_WITHIN_SECS: f64 = 3.0 * 86_400.0;

/// Purges the archives.
#[derive(Clone)]
pub(crate) struct ArchivePurgeJob;

impl BackgroundJob<Farm> for ArchivePurgeJob {
    const KIND: &'static str = "Purge";
    type Outcome = ();
    type Desk<'f> = Shared<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, _shared: Self::Desk<'_>, (): ()) -> Result<()> {
        Ok(())
    }
}

/// Looks for files beside the hot folders; returns their names.
#[derive(Clone)]
pub(crate) struct MisplacedFilesJob;

impl BackgroundJob<Farm> for MisplacedFilesJob {
    const KIND: &'static str = "Misplaced";
    const IS_LOOK: bool = true;
    type Outcome = Vec<String>;
    type Desk<'f> = Shared<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, shared: Self::Desk<'_>, found: Self::Outcome) -> Result<()> {
        on_misplaced_files(shared.settings, shared.alerts, &found);
        Ok(())
    }
}

/// Runs the housekeeping; nothing here is urgent, and everything is safe to repeat.
pub(super) async fn tidy_up(desk: &mut Receiving<'_>) -> Result<()> {
    // If the clock was just set, everything might seem old.
    if !desk.shared.schedule.clock.is_retention_trusted() {
        return Ok(());
    }
    let archives: Vec<(FolderLease, PathBuf, OutputRules)> = (desk.machines.values())
        .map(|s| (s.leases.archive.clone(), s.profile.folders.archive.clone(), s.profile.output.clone()))
        .collect();
    let (settings, ledger, store) =
        (desk.shared.settings.clone(), desk.shared.ledger.clone(), desk.meshes.store.clone());
    let runtime = tokio::runtime::Handle::current();
    desk.jobs.start(ArchivePurgeJob, move || {
        if let Err(failure) = runtime.block_on(claim_note::drop_taken_over_claims(&settings, &ledger, &store)) {
            warn!("Stored files of claims that another nestd has taken over are not removed yet: {failure:#}.");
        }
        for (mut lease, archive, output) in archives {
            if lease.check_usable().is_ok() {
                purge_old_files(&archive, output.archive_days, "originals", intake::purge_archive);
                purge_old_files(
                    &archive,
                    output.archive_builds_days.unwrap_or(0),
                    "build files",
                    intake::purge_kept_builds,
                );
            }
        }
    });
    sweep_store(&mut desk.storing()).await
}

/// Starts to look for files that were dropped beside the hot folders, those of other nodes' machines on the same share included.
pub(super) async fn start_misplaced_file_search(desk: &mut Serving<'_>) -> Result<()> {
    let (base, mut folders) = (desk.shared.settings.inbox_base.clone(), desk.shared.settings.all_folders());
    let others = own_machines::machines_of_other_nodes(desk.shared.settings, desk.shared.ledger).await?;
    folders.extend(others.keys().map(|machine| base.join(machine)));
    desk.jobs.start(MisplacedFilesJob, move || {
        let stray = intake::find_misplaced(&base, &folders).unwrap_or_default();
        stray.iter().filter_map(|path| path.file_name()).map(intake::display_name).collect()
    });
    Ok(())
}

/// Raises or clears the alert on files beside the hot folders.
fn on_misplaced_files(settings: &Settings, alerts: &mut AlertRegistry, found: &[String]) {
    let Some(first) = found.first() else { return alerts.clear(AlertKind::Stray, "", "") };
    let more = if found.len() > 1 { format!(" and {} more", found.len() - 1) } else { String::new() };
    let detail = format!("{first}{more} in {}", settings.inbox_base.display());
    alerts.raise(AlertKind::Stray, "", "", &detail);
}

/// Forgets stored files of built and long refused parts that no live part needs.
async fn sweep_store(desk: &mut Storing<'_>) -> Result<()> {
    let now = desk.shared.date();
    let mut unneeded = Vec::new();
    for (state, keep_secs) in [(PartState::Built, 0.0), (PartState::Refused, KEEP_REFUSED_SECS)] {
        let (from, to) = (time_before(now, keep_secs + SWEEP_WITHIN_SECS), time_before(now, keep_secs));
        unneeded.extend(desk.shared.ledger.hashes_in_state_between(state, from, to).await?);
    }
    forget::forget_data(desk, unneeded.into_iter().map(Forgettable::StoredFile)).await?;
    let mut live = HashSet::new();
    for state in [PartState::Claimed, PartState::Waiting, PartState::Batched] {
        live.extend(desk.shared.ledger.hashes_in_state_between(state, Timestamp::UNIX_EPOCH, now).await?);
    }
    // Whose order was not taken after all.
    desk.meshes.judged.clear();
    desk.meshes.mesh_cache.retain(|key| live.contains(&key.content_hash));
    Ok(())
}

fn time_before(now: Timestamp, secs: f64) -> Timestamp {
    now.checked_sub(SignedDuration::from_secs_f64(secs)).unwrap_or(Timestamp::UNIX_EPOCH)
}

/// Removes files that are older than their retention; 0 = they are kept for ever.
fn purge_old_files(archive: &Path, days: u32, what: &str, purge: impl Fn(&Path, SystemTime) -> std::io::Result<usize>) {
    if days == 0 {
        return;
    }
    let keep = Duration::from_secs(u64::from(days) * 86_400);
    let Some(before) = SystemTime::now().checked_sub(keep) else { return };
    match purge(archive, before) {
        Ok(0) => {}
        Ok(files) => info!("Removed {files} old {what} from {}.", archive.display()),
        Err(error) => warn!("The archive {} could not be purged: {error}.", archive.display()),
    }
}
