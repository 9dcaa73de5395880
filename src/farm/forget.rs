//! What the store forgets: files that no part needs any more, and notes of claims that are printed. A job removes them, for a
//! stored file may be large and a disk slow. Whether a file is needed is asked right before it starts, and until it has ended no
//! part with the same bytes is recorded or taken back.

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};

use super::{
    alert::AlertKind,
    farm::Farm,
    forgettable::{Forgettable, KEEP_REFUSED_SECS},
    jobs::BackgroundJob,
};
use crate::intake::StoreError;

/// Removing what the store does not need.
#[derive(Clone)]
pub(super) struct ForgetJob;

impl BackgroundJob<Farm> for ForgetJob {
    const KIND: &'static str = "Forget";
    type Outcome = Result<()>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, farm: &mut Farm, removed: Self::Outcome) -> Result<()> {
        farm.on_forgotten(removed).await
    }

    async fn on_panic(self, farm: &mut Farm, message: &str) -> Result<()> {
        farm.on_forgotten(Err(anyhow::anyhow!("panicked: {message}"))).await
    }

    fn on_not_started(self, farm: &mut Farm, _why: &str) {
        // The next tidying finds them again.
        farm.completion.forgetting.end();
    }
}

impl Farm {
    /// Removes these from the store where nobody needs them, with what was wanted before; what cannot be removed is found again
    /// by a later tidying.
    pub(super) async fn forget(&mut self, unneeded: impl IntoIterator<Item = Forgettable>) -> Result<()> {
        self.completion.forgetting.want(unneeded);
        if self.jobs.is_running::<ForgetJob>("") {
            return Ok(());
        }
        let mut work = Vec::new();
        for wanted in self.completion.forgetting.take_wanted() {
            if let Forgettable::StoredFile(hash) = &wanted
                && self.is_content_needed(hash).await?
            {
                continue;
            }
            self.completion.forgetting.begin(&wanted);
            work.push(wanted);
        }
        if work.is_empty() {
            return Ok(());
        }
        let forgetting = &self.completion.forgetting;
        self.meshes.mesh_cache.retain(|key| !forgetting.is_under_way(&key.content_hash));
        let store = self.meshes.store.clone();
        self.jobs.start(ForgetJob, move || {
            // One that cannot be removed keeps no other.
            let removed = work.iter().map(|one| one.remove_from(&store)).collect::<Vec<_>>();
            Ok(removed.into_iter().collect::<Result<(), StoreError>>()?)
        });
        Ok(())
    }

    async fn on_forgotten(&mut self, removed: Result<()>) -> Result<()> {
        self.completion.forgetting.end();
        match &removed {
            Ok(()) => self.alerts.clear(AlertKind::StepFails, "", "forgetting"),
            Err(failure) => self.report_failure(AlertKind::StepFails, "", "forgetting", failure),
        }
        self.forget([]).await
    }

    /// Whether a stored file is needed: by a live part, or by a refused one that may still be taken back.
    pub(super) async fn is_content_needed(&self, content_hash: &str) -> Result<bool> {
        let since = self.date().checked_sub(SignedDuration::from_secs_f64(KEEP_REFUSED_SECS));
        Ok(self.ledger.is_hash_in_use(content_hash, since.unwrap_or(Timestamp::UNIX_EPOCH)).await?)
    }
}
