//! The claim note beside a stored file shows how many decisions were made about the parts of the claim (refused,
//! cancelled, taken back). It is updated after the ledger and never ahead of it. A note that is behind does no harm.

use anyhow::Result;
use tracing::warn;

use super::{farm::Farm, jobs::BackgroundJob};
use crate::ledger::PartRow;

/// Writes the number of decisions into the claim note.
#[derive(Clone)]
struct DecisionCountJob {
    part: PartRow,
    decisions: u32,
}

impl BackgroundJob<Farm> for DecisionCountJob {
    const KIND: &'static str = "Note";
    type Outcome = Result<()>;

    fn subject(&self) -> String {
        self.part.file.claim.clone()
    }

    async fn on_done(self, farm: &mut Farm, marked: Self::Outcome) -> Result<()> {
        if let Err(failure) = marked {
            log_note_failure(&self.part, &failure);
        }
        // No second job starts while this one runs: decisions made meanwhile are written now.
        if farm.ledger.decision_count(&self.part.file.claim).await? > self.decisions {
            update_decision_count(farm, &self.part).await;
        }
        Ok(())
    }
}

/// Updates the claim note beside the stored file of a part, after a decision about the part was recorded in the
/// ledger.
pub(super) async fn update_decision_count(farm: &mut Farm, part: &PartRow) {
    match farm.ledger.decision_count(&part.file.claim).await {
        Ok(decisions) => {
            let (store, hash, claim) =
                (farm.meshes.store.clone(), part.file.content_hash.clone(), part.file.claim.clone());
            farm.jobs.start(DecisionCountJob { part: part.clone(), decisions }, move || {
                Ok(store.mark_decisions(&hash, &claim, decisions)?)
            });
        }
        Err(failure) => log_note_failure(part, &failure.into()),
    }
}

fn log_note_failure(part: &PartRow, failure: &anyhow::Error) {
    warn!(part.id = %part.id, "The note of {} could not be updated: {failure:#}.", part.name);
}
