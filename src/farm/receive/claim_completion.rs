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
use crate::farm::{
    alerts::alert::AlertKind,
    core::{farm::Farm, state::CompletionState},
    files::standing_claim::StandingClaim,
    records::forgettable::Forgettable,
};

/// Completes a claim: moves or releases its file.
#[derive(Clone)]
pub(crate) struct ClaimCompletionJob {
    claim: String,
    profile: String,
    name: String,
}

impl BackgroundJob<Farm> for ClaimCompletionJob {
    const KIND: &'static str = "Claim";
    type Outcome = Result<ClaimOutcome>;

    fn subject(&self) -> String {
        self.claim.clone()
    }

    async fn on_done(self, farm: &mut Farm, ended: Self::Outcome) -> Result<()> {
        on_claim_completed(farm, &self, ended).await
    }

    async fn on_panic(self, farm: &mut Farm, message: &str) -> Result<()> {
        on_claim_completed(farm, &self, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

impl ClaimCompletionJob {
    fn of(part: &PartRow) -> Self {
        Self { claim: part.file.claim.clone(), profile: part.profile.clone(), name: part.name.clone() }
    }

    fn of_claim(profile: &str, claim: &ClaimedPart) -> Self {
        Self { claim: claim.id.clone(), profile: profile.to_owned(), name: claim.display_name() }
    }
}

/// Refuses a claimed part. If its original is claimed: changes the part to rejected, then moves the file into the error
/// folder; after a crash in between, `record_claimed_file` finishes this. A part that is read again has no original in the
/// hot folder any more, which could tell of it after a crash: its copy in the error folder comes first.
pub(crate) async fn refuse_part(farm: &mut Farm, part: &PartRow, cause: RefusalCause, reason: &str) -> Result<()> {
    warn!(part.id = %part.id, profile = %part.profile, "Refused {} in {}: {reason}", part.name, part.profile);
    if deferred_refusal::is_without_original(&farm.completion, part) && farm.machines.contains_key(&part.profile) {
        deferred_refusal::start_refusal(farm, part.clone(), cause, reason, None);
        return Ok(());
    }
    farm.ledger.reject_claim(part.id, cause, reason).await?;
    mark_note::update_decision_count(farm, part).await;
    move_to_error_folder(farm, part, Some(cause), reason);
    Ok(())
}

/// Completes the claims of parts that were read or refused, and retries what failed earlier (for example because
/// the error folder was not writable).
pub(crate) async fn complete_claims(farm: &mut Farm) -> Result<()> {
    for claim in farm.completion.claims.keys().cloned().collect::<Vec<_>>() {
        let parts = farm.ledger.parts_of_claim(&claim).await?;
        parts.first().into_iter().for_each(|part| complete_claim(farm, part));
    }
    Ok(())
}

pub(super) fn complete_claim(farm: &mut Farm, part: &PartRow) {
    match part.state {
        PartState::Claimed => {}
        PartState::Rejected => move_to_error_folder(farm, part, part.rejection.refusal, &part.rejection.reason),
        // The part was read: only its original must still be released.
        _ => release_claim(farm, part),
    }
}

/// Whether a job still completes the claim of a part, copies its refused file, or removes its stored file.
pub(crate) fn is_completing(completion: &CompletionState, jobs: &JobRunner<Farm>, part: &PartRow) -> bool {
    jobs.is_running::<ClaimCompletionJob>(&part.file.claim)
        || deferred_refusal::is_refusing(completion, jobs, part.id)
        || completion.forgetting.is_under_way(&part.file.content_hash)
}

fn move_to_error_folder(farm: &mut Farm, part: &PartRow, cause: Option<RefusalCause>, reason: &str) {
    farm.reading.backoff.record_success(&part.id);
    let Some(refused) = describe_refused_part(farm, part, cause, reason) else { return };
    farm.jobs.start(ClaimCompletionJob::of(part), move || refused.move_to_error_folder());
}

/// Another farm has the file: copies it into the error folder if the store has it and this farm has the folder's
/// lease.
pub(crate) fn copy_given_up_part(farm: &mut Farm, part: &PartRow, reason: &str) {
    let Some(refused) = describe_refused_part(farm, part, Some(RefusalCause::Cancelled), reason) else { return };
    let id = part.id;
    farm.jobs.start(ClaimCompletionJob::of(part), move || {
        if let Err(failure) = refused.copy_to_error_folder() {
            debug!(part.id = %id, "No copy of a part that was given up is in the error folder: {failure:#}.");
        }
        Ok(ClaimOutcome::Done)
    });
}

/// Releases the claimed original: the store has the file, and its row is committed.
pub(crate) fn release_claim(farm: &mut Farm, part: &PartRow) {
    farm.reading.backoff.record_success(&part.id);
    let Some(StandingClaim { claim, .. }) = farm.completion.claims.get(&part.file.claim).cloned() else { return };
    let content_hash = part.file.content_hash.clone();
    farm.jobs.start(ClaimCompletionJob::of(part), move || {
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
pub(crate) fn give_back_claim(farm: &mut Farm, profile: &str, claim: &ClaimedPart, stored: &StoredFile) {
    let (end, store) = (ClaimCompletionJob::of_claim(profile, claim), farm.meshes.store.clone());
    let (claim, hash) = (claim.clone(), stored.hash.clone());
    farm.jobs.start(end, move || {
        intake::give_back_claim(&claim)?;
        store.delete_note(&hash, &claim.id)?;
        Ok(ClaimOutcome::GivenBack(hash))
    });
}

/// Releases a claim that replaced a damaged stored file. Such a claim does not order new copies.
pub(super) fn release_replacement(farm: &mut Farm, profile: &str, claim: &ClaimedPart, stored: &StoredFile) {
    let (claim, hash) = (claim.clone(), stored.hash.clone());
    farm.jobs.start(ClaimCompletionJob::of_claim(profile, &claim), move || {
        intake::release_claim(&claim, &hash)?;
        Ok(ClaimOutcome::Done)
    });
}

/// Processes the outcome of a claim completion. A completion that failed, or whose claim was not listed yet, is
/// retried.
async fn on_claim_completed(farm: &mut Farm, of: &ClaimCompletionJob, ended: Result<ClaimOutcome>) -> Result<()> {
    match ended {
        Ok(ClaimOutcome::NotListedYet) => {}
        Ok(end) => {
            farm.completion.claims.remove(&of.claim);
            match end {
                ClaimOutcome::OriginalReleased => drop(farm.completion.released.insert(of.claim.clone())),
                ClaimOutcome::GivenBack(hash) => forget::forget_data(farm, [Forgettable::StoredFile(hash)]).await?,
                _ => {}
            }
        }
        Err(failure) => {
            farm.report_failure(AlertKind::EndingFails, &of.profile, &of.name, &failure);
            if let (false, Some(machine)) =
                (farm.completion.claims.contains_key(&of.claim), farm.machines.get_mut(&of.profile))
            {
                // The claim is known only by its folder: the next scan lists it.
                machine.inbox.relist = true;
            }
        }
    }
    Ok(())
}
