//! The steps "nested", "verified" and "published" of a fired build: each looks into the ledger for its work, so that a crash
//! anywhere is taken up where it was.

use std::{collections::HashMap, sync::Arc};

use anyhow::{Context, Result, ensure};
use tracing::{info, warn};

use super::{
    attention::Attention,
    budget::Budget,
    event::Event,
    failure::{Lost, is_of_the_disk},
    farm::Farm,
    jobs::JobKey,
    layout::{placed_from_json, placed_from_rows},
    meshes::Meshes,
    nest::{Best, NestOrder, Nested},
    owner::Hold,
    prove::{Unproved, WriteOrder, Written, file_name, write_and_prove},
    staged::{Replaced, Staged, Step},
};
use crate::{
    format::counted,
    intake,
    ledger::{BuildId, BuildRow, BuildState, PartId, PartRow, PartState, Verified},
    queue::{Published, StagedState},
    settings::Profile,
};

/// Who pauses a profile whose build was given up.
pub const GAVE_UP: &str = "nestd";
/// A build whose making was begun so often without an end is given up, whatever ended the daemon each time.
const MAX_STARTS: u32 = 200;

impl Farm {
    /// Starts the final search of every build that is to be nested and is not in work. What keeps one build from being
    /// begun keeps no other.
    pub(super) async fn nest(&mut self) -> Result<()> {
        let mut builds = self.ledger.builds_in_state(BuildState::Nesting).await?;
        // One that ends the daemon each time must not keep the others from their turn.
        builds.sort_by_key(|build| (build.attempts, build.id));
        for build in builds {
            let (id, profile) = (build.id, build.profile.clone());
            if let Err(failure) = self.nest_build(build).await {
                self.trouble(Attention::NestingFails, &profile, &format!("build {id}"), &failure);
            }
        }
        Ok(())
    }

    async fn nest_build(&mut self, build: BuildRow) -> Result<()> {
        let key = JobKey::Final(build.id);
        if self.rests(build.id) || self.jobs.runs(&key) || !self.has_free_slot() || !self.has_queue(&build.profile) {
            return Ok(());
        }
        let parts = self.ledger.parts_of_build(build.id).await?;
        if self.is_wary(&build, build.searches, &parts.iter().collect::<Vec<_>>()) {
            return Ok(());
        }
        self.ledger.begin_search(build.id).await?;
        let attempts = match self.fresh_builds.remove(&build.id) {
            true => build.attempts,
            false => self.ledger.begin_attempt(build.id).await?,
        };
        let failures = self.failures.get(&build.id).map_or(0, |(count, _)| *count);
        if failures >= self.stations[&build.profile].profile.max_attempts || attempts > MAX_STARTS {
            return self.give_up(&build, attempts - 1).await;
        }
        self.start_final(build, attempts, key).await
    }

    /// Whether a build failed a moment ago and is left alone for now.
    fn rests(&self, build: BuildId) -> bool {
        self.resting.rests(&build)
    }

    /// Whether the queue folder of a profile is there; one that went away is opened anew, and its absence costs no attempt.
    fn has_queue(&mut self, profile: &str) -> bool {
        let Some(station) = self.stations.get_mut(profile) else { return false };
        if station.agrees.is_none() {
            return false;
        }
        let is_held = station.holds.queue.check().is_ok() && station.holds.archive.check().is_ok();
        if station.queue.as_ref().is_some_and(|queue| !is_held || queue.check().is_err()) {
            station.queue = None;
        }
        station.queue.is_some() && station.holds.are_fresh()
    }

    async fn start_final(&mut self, build: BuildRow, attempts: u32, key: JobKey) -> Result<()> {
        let wanted = self.parts_with_copies(build.id).await?;
        let station = &self.stations[&build.profile];
        let profile = station.profile.clone();
        let queue = station.queue.clone().context("the queue folder is not open")?;
        // Each further attempt gets half the time: an attempt that a crash or a restart cut short should come through.
        let secs = profile.final_secs / f64::from(1 << (attempts.saturating_sub(1)).min(10));
        let budget = Budget::starting_now(secs);
        let start = match build.layout.as_deref() {
            Some(layout) => placed_from_json(layout),
            // It was proved once, and its file was spoilt.
            None => placed_from_rows(&self.ledger.placements_of_build(build.id).await?, profile.origin_mm()),
        };
        let seed =
            profile.nest.seed.wrapping_add(build.id.0.unsigned_abs()).wrapping_add(u64::from(attempts - 1) << 32);
        let mut holds = station.holds.clone();
        let unsure =
            wanted.iter().map(|(part, _)| part.claim.clone()).filter(|claim| !self.let_go.contains(claim)).collect();
        let order =
            NestOrder { profile: profile.clone(), wanted, start, budget: budget.clone(), seed, best: Best::default() };
        self.finals.insert(build.id, (budget, order.best.clone()));
        let write = WriteOrder { profile, queue, build, seed, limits: self.meshes.limits.clone() };
        let meshes = self.meshes.clone();
        self.jobs.start(key, move || {
            let build = write.build.id;
            Event::Written {
                build,
                written: (super::adopt::demand_let_go(&order.profile, holds.inbox.farm(), &unsure).map_err(Into::into))
                    .and_then(|()| nest_write_and_prove(&order, &write, &mut holds.archive, &meshes))
                    .map(Box::new),
            }
        });
        Ok(())
    }

    /// The parts of a build with the copies of them that it took, in order of precedence.
    async fn parts_with_copies(&self, build: BuildId) -> Result<Vec<(PartRow, Vec<u32>)>> {
        let mut copies: HashMap<PartId, Vec<u32>> = HashMap::new();
        for (part, copy) in self.ledger.copies_of_build(build).await? {
            copies.entry(part).or_default().push(copy);
        }
        let parts = self.ledger.parts_of_build(build).await?;
        Ok((parts.into_iter()).filter_map(|part| copies.remove(&part.id).map(|copies| (part, copies))).collect())
    }

    /// Commits a written and proved build; publishing follows in the same beat.
    pub(super) async fn on_written(&mut self, build: BuildId, written: Result<Box<Written>>) -> Result<()> {
        self.jobs.ended(&JobKey::Final(build));
        self.finals.remove(&build);
        if let Some(build) = self.ledger.build(build).await? {
            self.has_ended_well(&build).await?;
        }
        if written.is_ok() {
            self.failures.remove(&build);
            self.resting.done(&build);
            let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
            self.notices.clear(Attention::NestingFails, &profile, &format!("build {build}"));
        }
        let written = match written {
            Ok(written) => written,
            Err(failure) if self.stopping => {
                info!(build.id = %build, "A build was left for the next start: {failure:#}.");
                return Ok(());
            }
            Err(failure) if Lost::of(&failure).is_some() => return self.go_on_without(build, &failure).await,
            Err(failure) if is_of_the_disk(&failure) => {
                // No fault of the build's: it costs no attempt, and the parts stay in it.
                self.fresh_builds.insert(build);
                self.resting.failed(build);
                let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
                self.trouble(Attention::NestingFails, &profile, &format!("build {build}"), &failure);
                return Ok(());
            }
            Err(failure) => {
                warn!(build.id = %build, "A build could not be made; it is tried again: {failure:#}.");
                if failure.is::<Unproved>() {
                    let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
                    let why = format!("{failure:#}");
                    self.ledger.event("proof_failed", &profile, None, Some(build), &why).await?;
                }
                return self.note_failure(build, &format!("{failure:#}")).await;
            }
        };
        if let Err(why) = self.still_staged(build, &written.verified).await {
            return self.note_failure(build, &format!("{why:#}")).await;
        }
        if !written.unplaced.is_empty() {
            info!(build.id = %build, "{} in build {build}: left for the next.", counted(written.unplaced.len(), "copy found no place", "copies found no place"));
            self.ledger.release_copies(build, &written.unplaced).await?;
        }
        self.ledger.verify_build(build, &written.verified, &written.placed).await?;
        if !written.locked.is_empty() {
            warn!(build.id = %build, "Parts of build {build} are locked into each other: {}.", written.locked);
            let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
            self.ledger.event("locked", &profile, None, Some(build), &written.locked).await?;
        }
        self.publish().await
    }

    /// The dot-file must be there, in the queue folder that is configured now, before the ledger relies on it: a missing one
    /// would read as published.
    async fn still_staged(&self, build: BuildId, verified: &Verified) -> Result<()> {
        let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
        let queue = self.stations.get(&profile).and_then(|s| s.queue.as_ref());
        let queue = queue.context("the queue folder is not available any more")?;
        ensure!(queue.id() == verified.queue_id, "the queue folder has changed since the build was written");
        ensure!(
            queue.state(&verified.file_name)? == StagedState::Staged,
            "the written build is gone from the queue folder"
        );
        Ok(())
    }

    /// Takes every verified build one step further into the queue: it is looked at, the ledger is told that it will be tried,
    /// it is compared with what was proved and renamed.
    pub(super) async fn publish(&mut self) -> Result<()> {
        for build in self.ledger.builds_in_state(BuildState::Verified).await? {
            let id = build.id;
            if self.rests(id) || self.jobs.runs(&JobKey::Publish(id)) {
                continue;
            }
            // The notice of a machine that is gone tells it.
            let Some(station) = self.stations.get(&build.profile) else { continue };
            let is_served = station.agrees.is_some() && station.holds.are_fresh();
            let Some(queue) = station.queue.clone().filter(|_| is_served) else { continue };
            let (is_tried, archive) = (build.publishing_at.is_some(), station.profile.folders.archive.clone());
            let (record, is_first) = (self.ledger.record_of_build(id).await?, self.untried.remove(&id));
            let staged = Staged { queue, build, archive, holds: station.holds.clone() };
            self.jobs.start(JobKey::Publish(id), move || {
                let step = match staged.holds.demand_published() {
                    Err(away) if is_first => Ok(Step::Untried(away.into())),
                    Err(away) => Err(away.into()),
                    Ok(()) if is_tried => staged.publish(&record, is_first),
                    Ok(()) => staged.look(),
                };
                Event::Published { build: id, step }
            });
        }
        Ok(())
    }

    /// Commits what a build's step into the queue has brought.
    pub(super) async fn on_published(&mut self, id: BuildId, step: Result<Step>) -> Result<()> {
        self.jobs.ended(&JobKey::Publish(id));
        match step {
            Ok(Step::Ready) => {
                self.ledger.begin_publishing(id).await?;
                self.untried.insert(id);
                self.publish().await
            }
            Ok(Step::Done(published)) => self.on_appeared(id, published).await,
            Ok(Step::Spoilt(why)) => {
                warn!(build.id = %id, "Build {id} is made again: {why}.");
                self.resting.failed(id);
                Ok(self.ledger.write_again(id, &format!("made again: {why}")).await?)
            }
            Ok(Step::Untried(failure)) => {
                self.ledger.end_publishing(id).await?;
                self.not_published(id, &failure).await
            }
            Err(failure) => self.not_published(id, &failure).await,
        }
    }

    async fn not_published(&mut self, id: BuildId, failure: &anyhow::Error) -> Result<()> {
        self.resting.failed(id);
        let profile = self.ledger.build(id).await?.map(|b| b.profile).unwrap_or_default();
        let about = format!("build {id}");
        match failure.downcast_ref::<Replaced>() {
            Some(replaced) => {
                self.notices.raise(Attention::QueueReplaced, &profile, &about, &format!("{about}: {replaced}"));
            }
            None => self.trouble(Attention::PublishingFails, &profile, &about, failure),
        }
        Ok(())
    }

    async fn on_appeared(&mut self, id: BuildId, published: Published) -> Result<()> {
        self.ledger.publish_build(id).await?;
        self.resting.done(&id);
        let Some(build) = self.ledger.build(id).await? else { return Ok(()) };
        for kind in [Attention::QueueReplaced, Attention::PublishingFails] {
            self.notices.clear(kind, &build.profile, &format!("build {id}"));
        }
        let height_mm = (build.height_mm.unwrap_or_default() * 1000.0).round() / 1000.0;
        match published {
            Published::Now => {
                info!(build.id = %id, profile = %build.profile, height_mm, "Published build {id} of {}: {height_mm} mm.", build.profile)
            }
            Published::Before => {
                warn!(build.id = %id, "Build {id} had been published before a crash; nothing was done twice.")
            }
        }
        self.forget_built(&build).await
    }

    /// Removes the store's copies of parts that are built: the archive has them.
    async fn forget_built(&mut self, build: &BuildRow) -> Result<()> {
        for part in self.ledger.parts_of_build(build.id).await? {
            if !self.is_needed(&part.content_hash).await? {
                self.meshes.store.remove(&part.content_hash)?;
                self.meshes.shelf.keep(|key| key.content_hash != part.content_hash);
            } else if self.ledger.parts_of_claim(&part.claim).await?.iter().all(|p| p.state == PartState::Built) {
                // The file is kept for another claim: a note of this one would have it printed again.
                self.meshes.store.forget_note(&part.content_hash, &part.claim)?;
            }
        }
        Ok(())
    }

    /// A build that cannot be made fails; its parts wait again, and its profile is paused, for a person must act.
    async fn give_up(&mut self, build: &BuildRow, attempts: u32) -> Result<()> {
        let (_, last) = self.failures.remove(&build.id).unwrap_or((0, "nestd stopped each time".to_owned()));
        let reason = format!("gave up after {attempts} attempts: {last}");
        warn!(build.id = %build.id, profile = %build.profile, "Build {} failed, and its profile is paused: {reason}.", build.id);
        if let Some(queue) = self.stations.get(&build.profile).and_then(|s| s.queue.as_ref()) {
            // What cannot be removed now is swept when the folder is opened next.
            if let Err(failure) = queue.discard(&file_name(&build.profile, build)) {
                warn!(build.id = %build.id, "The build's dot-file could not be removed: {failure}.");
            }
        }
        self.ledger.fail_build(build.id, &reason).await?;
        self.ledger.pause(&build.profile, GAVE_UP).await?;
        Ok(())
    }

    async fn note_failure(&mut self, build: BuildId, why: &str) -> Result<()> {
        let failure = self.failures.entry(build).or_default();
        *failure = (failure.0 + 1, why.to_owned());
        self.resting.failed(build);
        let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
        Ok(self.ledger.event("attempt_failed", &profile, None, Some(build), why).await?)
    }

    /// A build's job panicked.
    pub(super) async fn on_final_panicked(&mut self, build: BuildId, message: &str) -> Result<()> {
        self.finals.remove(&build);
        self.ledger.end_search(build).await?;
        self.note_failure(build, &format!("panicked: {message}")).await
    }
}

/// The whole final job: search, write, prove, archive the originals.
fn nest_write_and_prove(order: &NestOrder, write: &WriteOrder, archive: &mut Hold, meshes: &Meshes) -> Result<Written> {
    let nested = order.run(meshes)?;
    ensure!(!nested.layout.placed.is_empty(), "no copy found a place");
    let written = write_and_prove(write, &nested)?;
    archive.check()?;
    archive_originals(&write.profile, &write.build, &nested, meshes)?;
    Ok(written)
}

/// Copies the originals into the archive before the build is verified, so that every published build has them; the same
/// file again changes nothing.
fn archive_originals(profile: &Arc<Profile>, build: &BuildRow, nested: &Nested, meshes: &Meshes) -> Result<()> {
    let name = file_name(&profile.name, build);
    let stem = name.strip_suffix(".build.3mf").unwrap_or(&name);
    for part in &nested.batch.parts {
        if nested.layout.placed.iter().any(|p| p.copy.0 == part.part.id) {
            let stored = meshes.stored(&part.part)?;
            intake::archive(&stored, &profile.folders.archive, stem, &part.part.name)
                .with_context(|| format!("archiving {}", part.part.name))?;
        }
    }
    Ok(())
}
