//! Completes claims: refused files are moved into the error folder, and the originals of files that were read are
//! released. All file operations run on job threads: a folder may be slow or a network share, and the event loop must
//! not wait for it.

use std::path::PathBuf;

use anyhow::{Context, Result};
use tracing::{debug, warn};

use super::{
    alert::AlertKind,
    deferred_refusal,
    error_folder::{find_refused_files, reason_text},
    failure::LostFileError,
    farm::Farm,
    folder_leases::FolderLeases,
    forget,
    forgettable::Forgettable,
    jobs::BackgroundJob,
    jobs::JobRunner,
    mark_note,
    mesh_source::MeshSource,
    standing_claim::StandingClaim,
    state::CompletionState,
};
use crate::{
    intake::{self, ClaimedPart, ReleaseOutcome, StoredFile},
    ledger::{PartRow, PartState, RefusalCause},
};

/// A refused part whose file must be moved into the error folder.
pub(super) struct RefusedPart {
    part: PartRow,
    text: String,
    inbox: PathBuf,
    error_dir: PathBuf,
    meshes: MeshSource,
    leases: FolderLeases,
    claim: Option<StandingClaim>,
}

/// Result of completing a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ClaimOutcome {
    /// This farm released its original.
    OriginalReleased,
    /// Nothing is left to do.
    Done,
    /// Its file is back in the hot folder. The stored file with this hash may not be needed any more.
    GivenBack(String),
    /// The claim is in the hot folder, but the scan that lists it was not processed yet. It is completed after that.
    NotListedYet,
}

impl RefusedPart {
    fn move_to_error_folder(&self) -> Result<ClaimOutcome> {
        self.leases.check_error_folder()?;
        if let Some(claim) = &self.claim {
            // The stored file is needed if somebody takes the part back.
            claim.ensure_stored(&self.meshes.store, &self.part.file.content_hash)?;
            if self.is_copied()? && claim.claim.part.exists() {
                intake::release_claim(&claim.claim, &self.part.file.content_hash)?;
                return Ok(ClaimOutcome::Done);
            }
            intake::refuse_claim(&claim.claim, &self.error_dir, &self.text)?;
            return Ok(ClaimOutcome::Done);
        }
        // The original of a claim that is not listed yet is moved once the claim is listed.
        if intake::claim_dir(&self.inbox, &self.part.file.claim).exists() {
            return Ok(ClaimOutcome::NotListedYet);
        }
        // The part was taken back and is refused again.
        self.copy_to_error_folder().map(|()| ClaimOutcome::Done)
    }

    /// Brings the file of a part that is cancelled into the error folder before the ledger says so. A claimed original is
    /// left alone: its claim is completed afterwards.
    pub(super) fn copy_before_cancel(&self) -> Result<()> {
        let is_claimed = self.claim.is_some() || intake::claim_dir(&self.inbox, &self.part.file.claim).exists();
        match self.part.state == PartState::Claimed && is_claimed {
            true => Ok(()),
            false => self.copy_to_error_folder(),
        }
    }

    /// Whether a cancel copied the file into the error folder before its claim was listed, right after a crash.
    fn is_copied(&self) -> Result<bool> {
        Ok(self.error_dir.join(self.copy_folder()).exists()
            && !find_refused_files(&self.error_dir, &self.part)?.is_empty())
    }

    /// Folder of the copy in the error folder.
    fn copy_folder(&self) -> String {
        format!("part-{}", self.part.id)
    }

    /// Copies the stored file into the error folder, because the original was released when the part began to wait.
    /// Repeating this changes nothing.
    fn copy_to_error_folder(&self) -> Result<()> {
        self.leases.check_error_folder()?;
        let (row, error_dir, text) = (&self.part, &self.error_dir, &self.text);
        let folder = self.copy_folder();
        match find_refused_files(error_dir, row)?.first() {
            Some((_, known)) => intake::rewrite_reason(known, text),
            None => match self.meshes.verified_file(row) {
                Ok(stored) => intake::copy_to_error_folder(Some(&stored), error_dir, &folder, &row.name, text),
                Err(failure) if LostFileError::find_in_chain(&failure).is_some() => {
                    let text = format!(
                        "{text}\nThe file is not here, for nestd does not have it whole any more: {failure:#}.\n"
                    );
                    intake::copy_to_error_folder(None, error_dir, &folder, &row.name, &text)
                }
                Err(failure) => return Err(failure),
            },
        }
        .with_context(|| format!("copying {} into the error folder", row.name))
    }
}

/// Completes a claim: moves or releases its file.
#[derive(Clone)]
pub(super) struct ClaimCompletionJob {
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
pub(super) async fn refuse_part(farm: &mut Farm, part: &PartRow, cause: RefusalCause, reason: &str) -> Result<()> {
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
pub(super) async fn complete_claims(farm: &mut Farm) -> Result<()> {
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
pub(super) fn is_completing(completion: &CompletionState, jobs: &JobRunner<Farm>, part: &PartRow) -> bool {
    jobs.is_running::<ClaimCompletionJob>(&part.file.claim)
        || deferred_refusal::is_refusing(completion, jobs, part.id)
        || completion.forgetting.is_under_way(&part.file.content_hash)
}

/// A refused part with all that a job needs to copy or move its file; `None` = its machine is gone.
pub(super) fn describe_refused_part(
    farm: &Farm,
    part: &PartRow,
    cause: Option<RefusalCause>,
    reason: &str,
) -> Option<RefusedPart> {
    let machine = farm.machines.get(&part.profile)?;
    let folders = &machine.profile.folders;
    Some(RefusedPart {
        part: part.clone(),
        text: reason_text(part, cause, reason),
        inbox: folders.inbox.clone(),
        error_dir: folders.error.clone(),
        meshes: farm.meshes.clone(),
        leases: machine.leases.clone(),
        claim: farm.completion.claims.get(&part.file.claim).cloned(),
    })
}

fn move_to_error_folder(farm: &mut Farm, part: &PartRow, cause: Option<RefusalCause>, reason: &str) {
    farm.reading.backoff.record_success(&part.id);
    let Some(refused) = describe_refused_part(farm, part, cause, reason) else { return };
    farm.jobs.start(ClaimCompletionJob::of(part), move || refused.move_to_error_folder());
}

/// Another farm has the file: copies it into the error folder if the store has it and this farm has the folder's
/// lease.
pub(super) fn copy_given_up_part(farm: &mut Farm, part: &PartRow, reason: &str) {
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
pub(super) fn release_claim(farm: &mut Farm, part: &PartRow) {
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
pub(super) fn give_back_claim(farm: &mut Farm, profile: &str, claim: &ClaimedPart, stored: &StoredFile) {
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
