//! Completes claims: refused files are moved into the error folder, and the originals of files that were read are
//! released. All file operations run on job threads: a folder may be slow or a network share, and the event loop must
//! not wait for it.

use anyhow::Result;
use intake::{ClaimedPart, ReleaseOutcome, StoredFile};
use jobs::{BackgroundJob, JobRunner};
use ledger::{PartRow, PartState, RefusalCause};
use tracing::{debug, warn};

use super::{
    deferred_refusal, forget, mark_note,
    refused_part::{ClaimOutcome, describe_refused_part},
};
use crate::{
    alerts::alert::AlertKind,
    core::{desks::Receiving, farm::Farm, state::CompletionState},
    files::standing_claim::StandingClaim,
    records::forgettable::Forgettable,
};

/// Completes a claim: moves or releases its file.
#[derive(Clone)]
pub(crate) struct ClaimCompletionJob {
    claim: String,
    machine: String,
    name: String,
}

impl BackgroundJob<Farm> for ClaimCompletionJob {
    const KIND: &'static str = "Claim";
    type Outcome = Result<ClaimOutcome>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.claim.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, ended: Self::Outcome) -> Result<()> {
        on_claim_completed(&mut desk, &self, ended).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_claim_completed(&mut desk, &self, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

impl ClaimCompletionJob {
    fn of(part: &PartRow) -> Self {
        Self { claim: part.file.claim.clone(), machine: part.machine.clone(), name: part.name.clone() }
    }

    fn of_claim(machine: &str, claim: &ClaimedPart) -> Self {
        Self { claim: claim.id.clone(), machine: machine.to_owned(), name: claim.display_name() }
    }
}

/// Refuses a claimed part. If its original is claimed: changes the part to refused, then moves the file into the error
/// folder; after a crash in between, `record_claimed_file` finishes this. A part that is read again has no original in the
/// hot folder any more, which could tell of it after a crash: its copy in the error folder comes first.
pub(crate) async fn refuse_part(
    desk: &mut Receiving<'_>,
    part: &PartRow,
    cause: RefusalCause,
    reason: &str,
) -> Result<()> {
    warn!(part.id = %part.id, machine = %part.machine, "Refused {} in {}: {reason}", part.name, part.machine);
    if deferred_refusal::is_without_original(desk.completion, part) && desk.machines.contains_key(&part.machine) {
        deferred_refusal::start_refusal(desk, part.clone(), cause, reason, None);
        return Ok(());
    }
    desk.shared.ledger.refuse_claim(part.id, cause, reason).await?;
    mark_note::update_decision_count(desk, part).await;
    move_to_error_folder(desk, part, Some(cause), reason);
    Ok(())
}

/// Completes the claims of parts that were read or refused, and retries what failed earlier (for example because
/// the error folder was not writable).
pub(crate) async fn complete_claims(desk: &mut Receiving<'_>) -> Result<()> {
    for claim in desk.completion.claims.keys().cloned().collect::<Vec<_>>() {
        let parts = desk.shared.ledger.parts_of_claim(&claim).await?;
        parts.first().into_iter().for_each(|part| complete_claim(desk, part));
    }
    Ok(())
}

pub(super) fn complete_claim(desk: &mut Receiving<'_>, part: &PartRow) {
    match part.state {
        PartState::Claimed => {}
        PartState::Refused => move_to_error_folder(desk, part, part.refused.refusal, &part.refused.reason),
        // The part was read: only its original must still be released.
        _ => release_claim(desk, part),
    }
}

/// Whether a job still completes the claim of a part, copies its refused file, or removes its stored file.
pub(crate) fn is_completing(completion: &CompletionState, jobs: &JobRunner<Farm>, part: &PartRow) -> bool {
    jobs.is_running::<ClaimCompletionJob>(&part.file.claim)
        || deferred_refusal::is_refusing(completion, jobs, part.id)
        || completion.forgetting.is_under_way(&part.file.content_hash)
}

fn move_to_error_folder(desk: &mut Receiving<'_>, part: &PartRow, cause: Option<RefusalCause>, reason: &str) {
    desk.reading.backoff.record_success(&part.id);
    let Some(refused) = describe_refused_part(desk, part, cause, reason) else { return };
    desk.jobs.start(ClaimCompletionJob::of(part), move || refused.move_to_error_folder());
}

/// Another farm has the file: copies it into the error folder if the store has it and this farm has the folder's
/// lease.
pub(crate) fn copy_given_up_part(desk: &mut Receiving<'_>, part: &PartRow, reason: &str) {
    let Some(refused) = describe_refused_part(desk, part, Some(RefusalCause::Cancelled), reason) else { return };
    let id = part.id;
    desk.jobs.start(ClaimCompletionJob::of(part), move || {
        if let Err(failure) = refused.copy_to_error_folder() {
            debug!(part.id = %id, "No copy of a part that was given up is in the error folder: {failure:#}.");
        }
        Ok(ClaimOutcome::Done)
    });
}

/// Releases the claimed original: the store has the file, and its row is committed.
pub(crate) fn release_claim(desk: &mut Receiving<'_>, part: &PartRow) {
    desk.reading.backoff.record_success(&part.id);
    let Some(StandingClaim { claim, .. }) = desk.completion.claims.get(&part.file.claim).cloned() else { return };
    let content_hash = part.file.content_hash.clone();
    desk.jobs.start(ClaimCompletionJob::of(part), move || {
        match intake::release_claim(&claim, &content_hash)? {
            ReleaseOutcome::GivenBack(path) => {
                let file = path.display();
                warn!("{file} was written to after it was claimed; it is taken again as a new revision.");
            }
            // The part is given up at the next lease renewal. No build takes it before that.
            ReleaseOutcome::TakenOver => return Ok(ClaimOutcome::Done),
            ReleaseOutcome::Removed => {}
        }
        Ok(ClaimOutcome::OriginalReleased)
    });
}

/// Puts a claimed file back into the hot folder. Somebody wrote to it after its row was committed, and then nestd
/// crashed: the file is a new revision.
pub(crate) fn give_back_claim(desk: &mut Receiving<'_>, machine: &str, claim: &ClaimedPart, stored: &StoredFile) {
    let (end, store) = (ClaimCompletionJob::of_claim(machine, claim), desk.meshes.store.clone());
    let (claim, hash) = (claim.clone(), stored.hash.clone());
    desk.jobs.start(end, move || {
        intake::give_back_claim(&claim)?;
        store.delete_note(&hash, &claim.id)?;
        Ok(ClaimOutcome::GivenBack(hash))
    });
}

/// Releases a claim that replaced a damaged stored file. Such a claim does not order new copies.
pub(super) fn release_replacement(desk: &mut Receiving<'_>, machine: &str, claim: &ClaimedPart, stored: &StoredFile) {
    let (claim, hash) = (claim.clone(), stored.hash.clone());
    desk.jobs.start(ClaimCompletionJob::of_claim(machine, &claim), move || {
        intake::release_claim(&claim, &hash)?;
        Ok(ClaimOutcome::Done)
    });
}

/// Processes the outcome of a claim completion. A completion that failed, or whose claim was not listed yet, is
/// retried.
async fn on_claim_completed(
    desk: &mut Receiving<'_>,
    of: &ClaimCompletionJob,
    ended: Result<ClaimOutcome>,
) -> Result<()> {
    match ended {
        Ok(ClaimOutcome::NotListedYet) => {}
        Ok(end) => {
            desk.completion.claims.remove(&of.claim);
            match end {
                ClaimOutcome::OriginalReleased => drop(desk.completion.released.insert(of.claim.clone())),
                ClaimOutcome::GivenBack(hash) => {
                    forget::forget_data(&mut desk.storing(), [Forgettable::StoredFile(hash)]).await?
                }
                _ => {}
            }
        }
        Err(failure) => {
            desk.shared.report_failure(AlertKind::EndingFails, &of.machine, &of.name, &failure);
            if let (false, Some(machine)) =
                (desk.completion.claims.contains_key(&of.claim), desk.machines.get_mut(&of.machine))
            {
                // The claim is known only by its folder: the next scan lists it.
                machine.inbox.relist = true;
            }
        }
    }
    Ok(())
}
