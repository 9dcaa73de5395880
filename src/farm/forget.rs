//! Removes data from the store: files that no part needs any more, and claim notes of printed claims. A job removes
//! them, because a stored file may be large and a disk slow. Right before the job starts, the farm checks whether each
//! file is needed. Until the job has ended, no part with the same bytes is recorded or taken back.

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};

use super::{
    alert::AlertKind,
    farm::Farm,
    forgettable::{Forgettable, KEEP_REFUSED_SECS},
    jobs::BackgroundJob,
};
use crate::intake::StoreError;

/// Removes the files and claim notes that the store does not need.
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
        // The next cleanup finds them again.
        farm.completion.forgetting.end();
    }
}

impl Farm {
    /// Removes these from the store if no part needs them, together with earlier requests. A later cleanup finds those
    /// again that cannot be removed now.
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
            // If one cannot be removed, the others are still removed.
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

    /// Whether a stored file is needed by a live part, or by a refused part that may still be taken back.
    pub(super) async fn is_content_needed(&self, content_hash: &str) -> Result<bool> {
        let since = self.date().checked_sub(SignedDuration::from_secs_f64(KEEP_REFUSED_SECS));
        Ok(self.ledger.is_hash_in_use(content_hash, since.unwrap_or(Timestamp::UNIX_EPOCH)).await?)
    }
}
