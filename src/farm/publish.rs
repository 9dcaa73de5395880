//! The steps "nested", "verified" and "published" of a fired build: each looks into the ledger for its work, so that a crash
//! anywhere is taken up where it was.

use std::{collections::HashMap, sync::Arc};

use anyhow::{Context, Result, bail, ensure};
use tracing::{error, info, warn};

use super::{
    budget::Budget,
    event::Event,
    farm::Farm,
    jobs::JobKey,
    layout::placed_from_json,
    nest::{Best, NestOrder},
    prove::{WriteOrder, Written, file_name, write_and_prove},
};
use crate::{
    intake,
    ledger::{BuildId, BuildRow, BuildState, PartId, PartRow},
    queue::{Published, StagedState},
    settings::Profile,
};

/// A build whose making was begun so often without an end is given up, whatever ended the daemon each time.
const MAX_STARTS: u32 = 30;

impl Farm {
    /// Starts the final search of every build that is to be nested and is not in work.
    pub(super) async fn nest(&mut self) -> Result<()> {
        for build in self.ledger.builds_in_state(BuildState::Nesting).await? {
            let key = JobKey::Final(build.id);
            if self.jobs.runs(&key) || !self.has_free_slot() {
                continue;
            }
            let Some(station) = self.stations.get_mut(&build.profile) else { continue };
            if station.queue.is_none() {
                continue;
            }
            let attempts = match self.fresh_builds.remove(&build.id) {
                true => build.attempts,
                false => self.ledger.begin_attempt(build.id).await?,
            };
            let failures = self.failures.get(&build.id).map_or(0, |(count, _)| *count);
            if failures >= self.stations[&build.profile].profile.max_attempts || attempts > MAX_STARTS {
                self.give_up(&build, attempts - 1).await?;
                continue;
            }
            self.start_final(build, attempts, key).await?;
        }
        Ok(())
    }

    async fn start_final(&mut self, build: BuildRow, attempts: u32, key: JobKey) -> Result<()> {
        let wanted = self.parts_with_copies(build.id).await?;
        let station = &self.stations[&build.profile];
        let profile = station.profile.clone();
        let queue = station.queue.clone().context("the queue folder is not open")?;
        // Each further attempt gets half the time: an attempt that a crash or a restart cut short should come through.
        let secs = profile.final_secs / f64::from(1 << (attempts.saturating_sub(1)).min(10));
        let budget = Budget::starting_now(secs);
        let seed =
            profile.nest.seed.wrapping_add(build.id.0.unsigned_abs()).wrapping_add(u64::from(attempts - 1) << 32);
        let order = NestOrder {
            profile: profile.clone(),
            wanted,
            start: build.layout.as_deref().map(placed_from_json).unwrap_or_default(),
            budget: budget.clone(),
            seed,
            best: Best::default(),
        };
        self.finals.insert(build.id, (budget, order.best.clone()));
        let write = WriteOrder { profile, queue, build, seed, limits: self.meshes.limits.clone() };
        let meshes = self.meshes.clone();
        self.jobs.start(key, move || {
            let build = write.build.id;
            Event::Written { build, written: nest_write_and_prove(&order, &write, &meshes).map(Box::new) }
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
        if written.is_ok() {
            self.failures.remove(&build);
        }
        let written = match written {
            Ok(written) => written,
            Err(failure) if self.stopping => {
                info!(build.id = %build, "A build was left for the next start: {failure:#}.");
                return Ok(());
            }
            Err(failure) => {
                error!(build.id = %build, "A build could not be made; it is tried again: {failure:#}.");
                return self.note_failure(build, &format!("{failure:#}")).await;
            }
        };
        if !written.unplaced.is_empty() {
            info!(build.id = %build, copies = written.unplaced.len(), "Copies found no place and wait for the next build.");
            self.ledger.release_copies(build, &written.unplaced).await?;
        }
        self.ledger.verify_build(build, &written.verified, &written.placed).await?;
        self.publish().await
    }

    /// Publishes every verified build: one rename, then the row.
    pub(super) async fn publish(&mut self) -> Result<()> {
        for build in self.ledger.builds_in_state(BuildState::Verified).await? {
            if let Err(failure) = self.publish_build(&build).await {
                self.complain(
                    &format!("publish {}", build.id),
                    &format!("Build {} cannot be published: {failure:#}", build.id),
                );
            }
        }
        Ok(())
    }

    async fn publish_build(&mut self, build: &BuildRow) -> Result<()> {
        let station = self.stations.get(&build.profile).context("its profile is not configured")?;
        let queue = station.queue.clone().context("its queue folder is unavailable")?;
        let name = build.file_name.clone().context("its row names no file")?;
        let same_folder = build.queue_id.as_deref() == Some(queue.id());
        let published = tokio::task::spawn_blocking(move || {
            // In another folder than it was staged in, "gone" does not mean published: a person must look.
            if !same_folder && queue.state(&name)? == StagedState::Gone {
                bail!("the queue folder was replaced after {name} was staged in it, and the file is not there");
            }
            Ok(queue.publish(&name)?)
        })
        .await??;
        self.ledger.publish_build(build.id).await?;
        let height_mm = (build.height_mm.unwrap_or_default() * 1000.0).round() / 1000.0;
        match published {
            Published::Now => {
                info!(build.id = %build.id, profile = %build.profile, height_mm, "Published build {} of {}: {height_mm} mm.", build.id, build.profile)
            }
            Published::Before => {
                warn!(build.id = %build.id, "The build had been published before a crash; nothing was done twice.")
            }
        }
        self.forget_built(build).await
    }

    /// Removes the store's copies of parts that are built: the archive has them.
    async fn forget_built(&mut self, build: &BuildRow) -> Result<()> {
        for part in self.ledger.parts_of_build(build.id).await? {
            if !self.ledger.hash_in_use(&part.content_hash).await? {
                self.meshes.store.remove(&part.content_hash)?;
                self.meshes.shelf.keep(|key| key.content_hash != part.content_hash);
            }
        }
        Ok(())
    }

    /// A build that cannot be made fails; its parts wait again, and its profile is paused, for a person must act.
    async fn give_up(&mut self, build: &BuildRow, attempts: u32) -> Result<()> {
        let (_, last) = self.failures.remove(&build.id).unwrap_or((0, "nestd stopped each time".to_owned()));
        let reason = format!("gave up after {attempts} attempts: {last}");
        error!(build.id = %build.id, profile = %build.profile, "A build failed, and its profile is paused: {reason}.");
        if let Some(queue) = self.stations.get(&build.profile).and_then(|s| s.queue.as_ref()) {
            queue.discard(&file_name(&build.profile, build))?;
        }
        self.ledger.fail_build(build.id, &reason).await?;
        self.ledger.pause(&build.profile, "nestd").await?;
        Ok(())
    }

    async fn note_failure(&mut self, build: BuildId, why: &str) -> Result<()> {
        let failure = self.failures.entry(build).or_default();
        *failure = (failure.0 + 1, why.to_owned());
        let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
        Ok(self.ledger.event("attempt_failed", &profile, None, Some(build), why).await?)
    }

    /// A build's job panicked.
    pub(super) async fn on_final_panicked(&mut self, build: BuildId, message: &str) -> Result<()> {
        self.finals.remove(&build);
        self.note_failure(build, &format!("panicked: {message}")).await
    }
}

/// The whole final job: search, write, prove, archive the originals.
fn nest_write_and_prove(order: &NestOrder, write: &WriteOrder, meshes: &super::nest::Meshes) -> Result<Written> {
    let nested = order.run(meshes)?;
    ensure!(!nested.layout.placed.is_empty(), "no copy found a place");
    let written = write_and_prove(write, &nested)?;
    archive_originals(&write.profile, &write.build, &nested, meshes)?;
    Ok(written)
}

/// Copies the originals into the archive before the build is verified, so that every published build has them; the same
/// file again changes nothing.
fn archive_originals(
    profile: &Arc<Profile>,
    build: &BuildRow,
    nested: &super::nest::Nested,
    meshes: &super::nest::Meshes,
) -> Result<()> {
    let name = file_name(&profile.name, build);
    let stem = name.strip_suffix(".build.3mf").unwrap_or(&name);
    for part in &nested.batch.parts {
        if nested.layout.placed.iter().any(|p| p.copy.0 == part.part.id) {
            let stored = meshes.store.path(&part.part.content_hash)?;
            intake::archive(&stored, &profile.folders.archive, stem, &part.part.name)
                .with_context(|| format!("archiving {}", part.part.name))?;
        }
    }
    Ok(())
}
