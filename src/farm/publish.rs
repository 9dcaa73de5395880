//! The step "published": each verified build is taken into the queue step by step; the ledger says how far it is, so that a
//! crash anywhere is taken up where it was.

use anyhow::Result;
use tracing::{info, warn};

use super::{
    attention::Attention,
    farm::Farm,
    forgettable::Forgettable,
    jobs::Job,
    staged::{Replaced, Staged, Step},
};
use crate::{
    ledger::{BuildId, BuildRow, BuildState, PartState},
    queue::Published,
};

/// Taking a verified build a step further into the queue.
#[derive(Clone)]
pub(super) struct PublishJob {
    build: BuildId,
}

impl Job<Farm> for PublishJob {
    const KIND: &'static str = "Publish";
    type Outcome = Result<Step>;

    fn about(&self) -> String {
        self.build.to_string()
    }

    async fn done(self, farm: &mut Farm, step: Self::Outcome) -> Result<()> {
        farm.on_published(self.build, step).await
    }

    async fn panicked(self, farm: &mut Farm, message: &str) -> Result<()> {
        farm.on_published(self.build, Err(anyhow::anyhow!("panicked: {message}"))).await
    }

    fn not_started(self, farm: &mut Farm, _why: &str) {
        farm.nesting.resting.failed(self.build);
    }
}

impl Farm {
    /// Whether a build failed a moment ago and is left alone for now.
    pub(super) fn rests(&self, build: BuildId) -> bool {
        self.nesting.resting.rests(&build)
    }

    /// Takes every verified build one step further into the queue: it is looked at, the ledger is told that it will be tried,
    /// it is compared with what was proved and renamed.
    pub(super) async fn publish(&mut self) -> Result<()> {
        for build in self.ledger.builds_in_state(BuildState::Verified).await? {
            let id = build.id;
            if self.rests(id) || self.jobs.runs::<PublishJob>(id) {
                continue;
            }
            // The notice of a machine that is gone tells it.
            let Some(station) = self.stations.get(&build.profile) else { continue };
            let is_served = station.agrees.is_some() && station.holds.are_fresh();
            let Some(queue) = station.queue.opened.clone().filter(|_| is_served) else { continue };
            let (is_tried, archive) = (build.staged.publishing_at.is_some(), station.profile.folders.archive.clone());
            let (record, is_first) = (self.ledger.record_of_build(id).await?, self.nesting.untried.remove(&id));
            let staged = Staged { queue, build, archive, holds: station.holds.clone() };
            self.jobs.start(PublishJob { build: id }, move || match staged.holds.demand_published() {
                Err(away) if is_first => Ok(Step::Untried(away.into())),
                Err(away) => Err(away.into()),
                Ok(()) if is_tried => staged.publish(&record, is_first),
                Ok(()) => staged.look(),
            });
        }
        Ok(())
    }

    /// Commits what a build's step into the queue has brought.
    async fn on_published(&mut self, id: BuildId, step: Result<Step>) -> Result<()> {
        match step {
            Ok(Step::Ready) => {
                self.ledger.begin_publishing(id).await?;
                self.nesting.untried.insert(id);
                self.publish().await
            }
            Ok(Step::Done(published)) => self.on_appeared(id, published).await,
            Ok(Step::Spoilt(why)) => {
                warn!(build.id = %id, "Build {id} is made again: {why}.");
                self.nesting.resting.failed(id);
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
        self.nesting.resting.failed(id);
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
        self.nesting.resting.done(&id);
        let Some(build) = self.ledger.build(id).await? else { return Ok(()) };
        for kind in [Attention::QueueReplaced, Attention::PublishingFails] {
            self.notices.clear(kind, &build.profile, &format!("build {id}"));
        }
        let height_mm = (build.measures.height_mm.unwrap_or_default() * 1000.0).round() / 1000.0;
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

    /// The store's copies of parts that are built are needed no more: the archive has them.
    async fn forget_built(&mut self, build: &BuildRow) -> Result<()> {
        let mut unneeded = Vec::new();
        for part in self.ledger.parts_of_build(build.id).await? {
            unneeded.push(Forgettable::StoredFile(part.file.content_hash.clone()));
            if self.ledger.parts_of_claim(&part.file.claim).await?.iter().all(|p| p.state == PartState::Built) {
                // Where the file is kept for another claim, a note of this one would have it printed again.
                unneeded.push(Forgettable::ClaimNote { hash: part.file.content_hash, claim: part.file.claim });
            }
        }
        self.forget(unneeded).await
    }
}
