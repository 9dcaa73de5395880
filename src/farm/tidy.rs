//! Housekeeping: old archives go, and the store forgets what nobody needs.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};
use tracing::{info, warn};

use super::{
    attention::Attention,
    farm::Farm,
    forgettable::{Forgettable, KEEP_REFUSED_SECS},
    jobs::Job,
    owner::Hold,
    taken,
};
use crate::{intake, ledger::PartState};

/// The first tidying follows the start by so much, so that it delays no start.
pub const FIRST_TIDY_AFTER: Duration = Duration::from_secs(60);
/// How often the house is tidied.
pub const TIDY_EVERY: Duration = Duration::from_secs(3600);
/// Parts that were built or forgotten longer ago than this have been swept at an earlier tidying.
const SWEEP_WITHIN_SECS: f64 = 3.0 * 86_400.0;

/// Going through the archives.
#[derive(Clone)]
pub(super) struct PurgeJob;

impl Job<Farm> for PurgeJob {
    const KIND: &'static str = "Purge";
    type Outcome = ();

    fn about(&self) -> String {
        String::new()
    }

    async fn done(self, _farm: &mut Farm, (): ()) -> Result<()> {
        Ok(())
    }
}

/// Looking for files beside the hot folders; gives their names.
#[derive(Clone)]
pub(super) struct StrayJob;

impl Job<Farm> for StrayJob {
    const KIND: &'static str = "Stray";
    type Outcome = Vec<String>;

    fn about(&self) -> String {
        String::new()
    }

    async fn done(self, farm: &mut Farm, found: Self::Outcome) -> Result<()> {
        farm.on_stray(&found);
        Ok(())
    }
}

impl Farm {
    /// Tidies; nothing here is urgent, and everything is safe to repeat.
    pub(super) async fn tidy(&mut self) -> Result<()> {
        // By a clock that was just set, everything might be old.
        if !self.schedule.clock.may_delete() {
            return Ok(());
        }
        let archives: Vec<(Hold, PathBuf, u32)> = (self.stations.values())
            .map(|s| (s.holds.archive.clone(), s.profile.folders.archive.clone(), s.profile.output.archive_days))
            .filter(|(.., days)| *days > 0)
            .collect();
        let (settings, ledger, store) = (self.settings.clone(), self.ledger.clone(), self.meshes.store.clone());
        let runtime = tokio::runtime::Handle::current();
        self.jobs.start(PurgeJob, move || {
            if let Err(failure) = runtime.block_on(taken::drop_taken_over(&settings, &ledger, &store)) {
                warn!("What is stored of claims that another nestd has taken over is dropped later: {failure:#}.");
            }
            for (mut hold, archive, days) in archives {
                if hold.check().is_ok() {
                    purge(&archive, days);
                }
            }
        });
        self.sweep_store().await
    }

    /// Starts to look for what was dropped beside the hot folders.
    pub(super) fn look_for_stray_files(&mut self) {
        let (base, folders) = (self.settings.inbox_base.clone(), self.settings.folders());
        self.jobs.start(StrayJob, move || {
            let stray = intake::stray(&base, &folders).unwrap_or_default();
            stray.iter().filter_map(|path| path.file_name()).map(intake::display_name).collect()
        });
    }

    /// Tells what lies beside the hot folders.
    fn on_stray(&mut self, found: &[String]) {
        let Some(first) = found.first() else { return self.notices.clear(Attention::Stray, "", "") };
        let more = if found.len() > 1 { format!(" and {} more", found.len() - 1) } else { String::new() };
        let detail = format!("{first}{more} in {}", self.settings.inbox_base.display());
        self.notices.raise(Attention::Stray, "", "", &detail);
    }

    /// Forgets stored files of built and long refused parts that no live part needs.
    async fn sweep_store(&mut self) -> Result<()> {
        let now = self.date();
        let mut unneeded = Vec::new();
        for (state, keep_secs) in [(PartState::Built, 0.0), (PartState::Rejected, KEEP_REFUSED_SECS)] {
            let (from, to) = (ago(now, keep_secs + SWEEP_WITHIN_SECS), ago(now, keep_secs));
            unneeded.extend(self.ledger.hashes_in_state(state, from, to).await?);
        }
        self.forget(unneeded.into_iter().map(Forgettable::StoredFile)).await?;
        let mut live = HashSet::new();
        for state in [PartState::Claimed, PartState::Waiting, PartState::Batched] {
            live.extend(self.ledger.hashes_in_state(state, Timestamp::UNIX_EPOCH, now).await?);
        }
        self.meshes.shelf.keep(|key| live.contains(&key.content_hash));
        Ok(())
    }
}

fn ago(now: Timestamp, secs: f64) -> Timestamp {
    now.checked_sub(SignedDuration::from_secs_f64(secs)).unwrap_or(Timestamp::UNIX_EPOCH)
}

/// Removes originals that are older than the profile keeps them.
fn purge(archive: &Path, days: u32) {
    let keep = Duration::from_secs(u64::from(days) * 86_400);
    let Some(before) = SystemTime::now().checked_sub(keep) else { return };
    match intake::purge(archive, before) {
        Ok(0) => {}
        Ok(files) => info!("Removed {files} old originals from {}.", archive.display()),
        Err(error) => warn!("The archive {} could not be purged: {error}.", archive.display()),
    }
}
