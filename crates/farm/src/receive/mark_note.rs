//! The claim note beside a stored file shows how many decisions were made about the parts of the claim (refused,
//! cancelled, taken back, changed), and how many copies were wanted then. It is updated after the ledger and never ahead of it. A note
//! that is behind does no harm.

use std::collections::BTreeMap;

use anyhow::Result;
use intake::ContentStore;
use jobs::BackgroundJob;
use ledger::{LedgerError, NewTerms, PartRow, PartState};
use tracing::warn;

use crate::{
    core::{desks::Receiving, farm::Farm},
    files::claim_note::{ClaimNote, terms_of},
};

/// Writes the number of decisions into the claim note.
#[derive(Clone)]
struct DecisionCountJob {
    part: PartRow,
    decisions: u32,
}

impl BackgroundJob<Farm> for DecisionCountJob {
    const KIND: &'static str = "Note";
    type Outcome = Result<()>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.part.file.claim.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, marked: Self::Outcome) -> Result<()> {
        if let Err(failure) = marked {
            log_note_failure(&self.part, &failure);
        }
        // No second job starts while this one runs: decisions made meanwhile are written now.
        if desk.shared.ledger.decision_count(&self.part.file.claim).await? > self.decisions {
            update_decision_count(&mut desk, &self.part).await;
        }
        Ok(())
    }
}

/// Updates the claim note beside the stored file of a part, after a decision about the part was recorded in the
/// ledger.
pub(crate) async fn update_decision_count(desk: &mut Receiving<'_>, part: &PartRow) {
    match read_decisions(desk, part).await {
        Ok((decisions, wanted, asked)) => {
            let (store, hash, claim) =
                (desk.meshes.store.clone(), part.file.content_hash.clone(), part.file.claim.clone());
            desk.jobs.start(DecisionCountJob { part: part.clone(), decisions }, move || {
                note_wanted(&store, &hash, &claim, wanted, asked)?;
                Ok(store.mark_decisions(&hash, &claim, decisions)?)
            });
        }
        Err(failure) => log_note_failure(part, &failure.into()),
    }
}

/// How often was decided about the parts of a claim, the copies that are wanted of each solid by now, and what is asked for with the one
/// part of a file.
async fn read_decisions(
    desk: &Receiving<'_>,
    part: &PartRow,
) -> Result<(u32, BTreeMap<u32, u32>, Option<NewTerms>), LedgerError> {
    let parts = desk.shared.ledger.parts_of_claim(&part.file.claim).await?;
    let live = parts.iter().filter(|part| part.state != PartState::Refused);
    let wanted = live.map(|part| (part.solid.object_index, part.wanted_copies())).collect();
    let asked = if let [only] = &parts[..] { Some(terms_of(only)) } else { None };
    Ok((desk.shared.ledger.decision_count(&part.file.claim).await?, wanted, asked))
}

fn note_wanted(
    store: &ContentStore,
    hash: &str,
    claim: &str,
    wanted: BTreeMap<u32, u32>,
    asked: Option<NewTerms>,
) -> Result<()> {
    match ClaimNote::read(store, hash, claim) {
        Some(note) if note.wanted != wanted || note.asked != asked => {
            let path = store.note_path(hash, claim)?;
            Ok(intake::write_file_atomically(&path, ClaimNote { wanted, asked, ..note }.to_text().as_bytes())?)
        }
        _ => Ok(()),
    }
}

fn log_note_failure(part: &PartRow, failure: &anyhow::Error) {
    warn!(part.id = %part.id, "The note of {} could not be updated: {failure:#}.", part.name);
}
