//! Housekeeping: old archives go, the store forgets what nobody needs, leftovers in the queue folders go.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};
use tracing::{info, warn};

use super::{attention::Attention, failure::chain, farm::Farm, jobs::Job, owner::Hold, prove::file_name, taken};
use crate::{
    intake,
    ledger::{BuildId, BuildState, Ledger, PartState, REFUSED_COUNTS},
    queue::Queue,
};

/// The first tidying follows the start by so much, so that it delays no start.
pub const FIRST_TIDY_AFTER: Duration = Duration::from_secs(60);
/// How often the house is tidied.
pub const TIDY_EVERY: Duration = Duration::from_secs(3600);
/// Refused files stay in the store so long, so that `nestd retry` finds them.
pub const KEEP_REFUSED_SECS: f64 = REFUSED_COUNTS.as_secs() as f64;
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
            .map(|s| (s.holds.archive.clone(), s.profile.folders.archive.clone(), s.profile.archive_days))
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

    /// Removes stored files of built and long refused parts that no live part needs.
    async fn sweep_store(&mut self) -> Result<()> {
        let now = Timestamp::now();
        for (state, keep_secs) in [(PartState::Built, 0.0), (PartState::Rejected, KEEP_REFUSED_SECS)] {
            let (from, to) = (ago(now, keep_secs + SWEEP_WITHIN_SECS), ago(now, keep_secs));
            for hash in self.ledger.hashes_in_state(state, from, to).await? {
                if !self.is_needed(&hash).await? {
                    self.meshes.store.remove(&hash)?;
                }
            }
        }
        let mut live = HashSet::new();
        for state in [PartState::Claimed, PartState::Waiting, PartState::Batched] {
            live.extend(self.ledger.hashes_in_state(state, Timestamp::UNIX_EPOCH, now).await?);
        }
        self.meshes.shelf.keep(|key| live.contains(&key.content_hash));
        Ok(())
    }

    /// Whether a stored file is needed: by a part that lives, or by a refused one that may still be taken back.
    pub(super) async fn is_needed(&self, content_hash: &str) -> Result<bool> {
        Ok(self.ledger.hash_in_use(content_hash, ago(Timestamp::now(), KEEP_REFUSED_SECS)).await?)
    }

    /// Opens the queue folders that are not open and sweeps what a crash left half written in them.
    pub(super) async fn open_queues(&mut self) -> Result<()> {
        let mut staged = Vec::new();
        // A build that is being nested may have been staged already: only what no build names is swept.
        for state in [BuildState::Nesting, BuildState::Verified] {
            for build in self.ledger.builds_in_state(state).await? {
                staged.push(build.file_name.clone().unwrap_or_else(|| file_name(&build.profile, &build)));
            }
        }
        let mut closed = Vec::new();
        for (name, station) in self.stations.iter_mut().filter(|(_, s)| s.queue.is_none()) {
            // An empty mount point is not marked as a queue.
            if let Err(error) = station.holds.queue.check() {
                closed.push((name.clone(), error.to_string()));
                continue;
            }
            match Queue::open(&station.profile.folders.queue) {
                Ok(queue) => {
                    // What this farm has not fired is staged by another one, and left alone.
                    let mut keep = staged.clone();
                    for file in queue.staged_builds().unwrap_or_default() {
                        if !is_own(&self.ledger, name, &file).await? {
                            keep.push(file);
                        }
                    }
                    let swept = match queue.sweep(&keep) {
                        Ok(swept) => swept,
                        Err(error) => {
                            closed.push((name.clone(), chain(&error)));
                            continue;
                        }
                    };
                    if !swept.is_empty() {
                        info!(profile = %name, files = swept.len(), "Removed half-written files of an earlier run.");
                    }
                    station.queue = Some(queue);
                }
                Err(error) => closed.push((name.clone(), chain(&error))),
            }
        }
        for name in self.stations.keys().cloned().collect::<Vec<_>>() {
            match closed.iter().find(|(of, _)| *of == name) {
                Some((_, why)) => self.notices.raise(Attention::QueueAway, &name, "", why),
                None => self.notices.clear(Attention::QueueAway, &name, ""),
            }
        }
        Ok(())
    }
}

/// Whether a build file is one of the builds that this farm has fired. An open one has no file yet: what bears the name that it
/// would have now is another farm's.
async fn is_own(ledger: &Ledger, profile: &str, file: &str) -> Result<bool> {
    let Some((_, number)) = super::record::fired_and_number(file) else { return Ok(false) };
    let build = ledger.build(BuildId(number)).await?;
    Ok(build.is_some_and(|build| build.state != BuildState::Open && file_name(profile, &build) == file))
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
