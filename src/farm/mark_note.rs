//! The note beside a stored file says how often was decided of the parts of its claim (refused, cancelled, taken back), after the
//! ledger does. It is never ahead of the ledger; that it stays behind harms nothing.

use anyhow::Result;
use tracing::warn;

use super::{farm::Farm, jobs::BackgroundJob};
use crate::ledger::PartRow;

/// Marking the note of a claim with so many decisions.
#[derive(Clone)]
struct MarkJob {
    part: PartRow,
    decisions: u32,
}

impl BackgroundJob<Farm> for MarkJob {
    const KIND: &'static str = "Mark";
    type Outcome = Result<()>;

    fn subject(&self) -> String {
        self.part.file.claim.clone()
    }

    async fn on_done(self, farm: &mut Farm, marked: Self::Outcome) -> Result<()> {
        if let Err(failure) = marked {
            tell_failure(&self.part, &failure);
        }
        // What was decided meanwhile found this job running.
        if farm.ledger.decision_count(&self.part.file.claim).await? > self.decisions {
            farm.update_decision_count(&self.part).await;
        }
        Ok(())
    }
}

impl Farm {
    /// Something was decided of a part, and the ledger says so: the note beside its stored file is made to say it too.
    pub(super) async fn update_decision_count(&mut self, part: &PartRow) {
        match self.ledger.decision_count(&part.file.claim).await {
            Ok(decisions) => {
                let (store, hash, claim) =
                    (self.meshes.store.clone(), part.file.content_hash.clone(), part.file.claim.clone());
                self.jobs.start(MarkJob { part: part.clone(), decisions }, move || {
                    Ok(store.mark_decisions(&hash, &claim, decisions)?)
                });
            }
            Err(failure) => tell_failure(part, &failure.into()),
        }
    }
}

fn tell_failure(part: &PartRow, failure: &anyhow::Error) {
    warn!(part.id = %part.id, "The note of {} could not be updated: {failure:#}.", part.name);
}
