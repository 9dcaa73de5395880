//! The steps "nested" and "verified" of a fired build: it is searched, written and proved by one job. Each look into the ledger
//! finds the builds that are to be nested, so that a crash anywhere is taken up where it was.

use std::{collections::HashMap, sync::Arc};

use anyhow::{Context, Result, ensure};
use build_file::counted;
use nester::SearchBudget;
use tracing::{info, warn};

use super::{
    attention::Attention,
    failure::{Lost, is_of_the_disk},
    farm::Farm,
    jobs::Job,
    layout::{placed_from_json, placed_from_rows},
    meshes::Meshes,
    nest_order::{Best, NestOrder, Nested},
    owner::Hold,
    prove::{Unproved, WriteOrder, Written, file_name, write_and_prove},
    queues::demand_staged,
};
use crate::{
    intake,
    ledger::{BuildId, BuildRow, BuildState, PartId, PartRow},
    settings::Profile,
};

/// Who pauses a profile whose build was given up.
pub const GAVE_UP: &str = "nestd";
/// A build whose making was begun so often without an end is given up, whatever ended the daemon each time.
const MAX_STARTS: u32 = 200;

/// Nesting, writing and proving a build.
#[derive(Clone)]
pub(super) struct FinalJob {
    build: BuildId,
}

impl Job<Farm> for FinalJob {
    const KIND: &'static str = "Final";
    type Outcome = Result<Box<Written>>;

    fn about(&self) -> String {
        self.build.to_string()
    }

    async fn done(self, farm: &mut Farm, written: Self::Outcome) -> Result<()> {
        farm.on_written(self.build, written).await
    }

    async fn panicked(self, farm: &mut Farm, message: &str) -> Result<()> {
        farm.on_final_panicked(self.build, message).await
    }

    fn not_started(self, farm: &mut Farm, _why: &str) {
        farm.nesting.finals.remove(&self.build);
        farm.nesting.fresh.insert(self.build);
        farm.nesting.resting.failed(self.build);
    }
}

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
        if self.rests(build.id)
            || self.jobs.runs::<FinalJob>(build.id)
            || !self.has_free_slot()
            || !self.has_queue(&build.profile)
        {
            return Ok(());
        }
        let parts = self.ledger.parts_of_build(build.id).await?;
        if self.is_wary(&build, build.searches, &parts.iter().collect::<Vec<_>>()) {
            return Ok(());
        }
        self.ledger.begin_search(build.id).await?;
        let attempts = match self.nesting.fresh.remove(&build.id) {
            true => build.attempts,
            false => self.ledger.begin_attempt(build.id).await?,
        };
        let failures = self.nesting.failures.get(&build.id).map_or(0, |(count, _)| *count);
        if failures >= self.stations[&build.profile].profile.search.max_attempts || attempts > MAX_STARTS {
            return self.give_up(&build, attempts - 1).await;
        }
        self.start_final(build, attempts).await
    }

    async fn start_final(&mut self, build: BuildRow, attempts: u32) -> Result<()> {
        let wanted = self.parts_with_copies(build.id).await?;
        let station = &self.stations[&build.profile];
        let profile = station.profile.clone();
        let queue = station.queue.opened.clone().context("the queue folder is not open")?;
        // Each further attempt gets half the time: an attempt that a crash or a restart cut short should come through.
        let secs = profile.search.final_secs / f64::from(1 << (attempts.saturating_sub(1)).min(10));
        let budget = SearchBudget::of_secs(secs);
        let start = match build.kept.layout.as_deref() {
            Some(layout) => placed_from_json(layout),
            // It was proved once, and its file was spoilt.
            None => placed_from_rows(&self.ledger.placements_of_build(build.id).await?, profile.origin_mm()),
        };
        let seed = profile
            .search
            .nest
            .seed
            .wrapping_add(build.id.0.unsigned_abs())
            .wrapping_add(u64::from(attempts - 1) << 32);
        let mut holds = station.holds.clone();
        let unsure = wanted
            .iter()
            .map(|(part, _)| part.file.claim.clone())
            .filter(|claim| !self.ending.let_go.contains(claim))
            .collect();
        let order =
            NestOrder { profile: profile.clone(), wanted, start, budget: budget.clone(), seed, best: Best::default() };
        self.nesting.finals.insert(build.id, (budget, order.best.clone()));
        let write = WriteOrder { profile, queue, build, seed, limits: self.meshes.limits.clone() };
        let meshes = self.meshes.clone();
        self.jobs.start(FinalJob { build: write.build.id }, move || {
            super::adopt::demand_let_go(&order.profile, holds.inbox.farm(), &unsure)?;
            nest_write_and_prove(&order, &write, &mut holds.archive, &meshes).map(Box::new)
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
    async fn on_written(&mut self, build: BuildId, written: Result<Box<Written>>) -> Result<()> {
        self.nesting.finals.remove(&build);
        if let Some(build) = self.ledger.build(build).await? {
            self.has_ended_well(&build).await?;
        }
        if written.is_ok() {
            self.nesting.failures.remove(&build);
            self.nesting.resting.done(&build);
            let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
            self.notices.clear(Attention::NestingFails, &profile, &format!("build {build}"));
        }
        let written = match written {
            Ok(written) => written,
            Err(failure) if self.life.stopping => {
                info!(build.id = %build, "A build was left for the next start: {failure:#}.");
                return Ok(());
            }
            Err(failure) if Lost::of(&failure).is_some() => return self.go_on_without(build, &failure).await,
            Err(failure) if is_of_the_disk(&failure) => {
                // No fault of the build's: it costs no attempt, and the parts stay in it.
                self.nesting.fresh.insert(build);
                self.nesting.resting.failed(build);
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
        if let Err(why) = self.demand_same_queue(build, &written.verified).await {
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

    /// A build that cannot be made fails; its parts wait again, and its profile is paused, for a person must act.
    async fn give_up(&mut self, build: &BuildRow, attempts: u32) -> Result<()> {
        let (_, last) = self.nesting.failures.remove(&build.id).unwrap_or((0, "nestd stopped each time".to_owned()));
        let reason = format!("gave up after {attempts} attempts: {last}");
        warn!(build.id = %build.id, profile = %build.profile, "Build {} failed, and its profile is paused: {reason}.", build.id);
        self.discard_staged(build);
        self.ledger.fail_build(build.id, &reason).await?;
        self.ledger.pause(&build.profile, GAVE_UP).await?;
        Ok(())
    }

    async fn note_failure(&mut self, build: BuildId, why: &str) -> Result<()> {
        let failure = self.nesting.failures.entry(build).or_default();
        *failure = (failure.0 + 1, why.to_owned());
        self.nesting.resting.failed(build);
        let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
        Ok(self.ledger.event("attempt_failed", &profile, None, Some(build), why).await?)
    }

    /// A build's job panicked.
    async fn on_final_panicked(&mut self, build: BuildId, message: &str) -> Result<()> {
        self.nesting.finals.remove(&build);
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
    demand_staged(&write.queue, &written.verified.file.file_name)?;
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
