//! The end of a dropped file: refused ones go into the error folder, originals that were read are let go. All that touches
//! files runs on a job's thread: a folder may be slow or a share, and the event loop must not wait for it.

use std::path::PathBuf;

use anyhow::{Context, Result};
use tracing::{debug, info, warn};

use super::{
    attention::Attention,
    error_folder::{reason_text, refused_files},
    failure::Lost,
    farm::Farm,
    forgettable::Forgettable,
    holds::Holds,
    jobs::Job,
    meshes::Meshes,
    standing_claim::StandingClaim,
    state::Leaving,
};
use crate::{
    intake::{self, Claim, Released, Stored},
    ledger::{CommandRow, LedgerError, PartId, PartRow, PartState, Refusal},
};

/// A refused part on its way into the error folder.
struct Refused {
    part: PartRow,
    text: String,
    inbox: PathBuf,
    error_dir: PathBuf,
    meshes: Meshes,
    holds: Holds,
    claim: Option<StandingClaim>,
}

/// How the work on a claim has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ClaimEnd {
    /// This farm let its original go.
    LetGo,
    /// Nothing is left to do for it.
    Done,
    /// Its file is back in the hot folder; what was stored of it under this hash may not be needed.
    GivenBack(String),
    /// It stands in the hot folder, but the look that finds it was not taken in yet: it ends after that.
    ToBeFound,
}

impl Refused {
    fn put_into_error(&self) -> Result<ClaimEnd> {
        self.holds.demand_error()?;
        if let Some(claim) = &self.claim {
            // For who takes it back.
            claim.ensure_stored(&self.meshes.store, &self.part.file.content_hash)?;
            intake::refuse(&claim.claim, &self.error_dir, &self.text)?;
            return Ok(ClaimEnd::Done);
        }
        // A claim that is still to be found brings its original itself.
        if intake::claim_dir(&self.inbox, &self.part.file.claim).exists() {
            return Ok(ClaimEnd::ToBeFound);
        }
        // One that was taken back and is refused again.
        self.copy_into_error().map(|()| ClaimEnd::Done)
    }

    /// The original was let go when the part began to wait: a copy from the store goes into the error folder. The same
    /// copy again changes nothing.
    fn copy_into_error(&self) -> Result<()> {
        self.holds.demand_error()?;
        let (row, error_dir, text) = (&self.part, &self.error_dir, &self.text);
        let folder = format!("part-{}", row.id);
        match refused_files(error_dir, row)?.first() {
            Some((_, known)) => intake::rewrite_reason(known, text),
            None => match self.meshes.stored(row) {
                Ok(stored) => intake::refuse_copy(Some(&stored), error_dir, &folder, &row.name, text),
                Err(failure) if Lost::of(&failure).is_some() => {
                    let text = format!(
                        "{text}\nThe file is not here, for nestd does not have it whole any more: {failure:#}.\n"
                    );
                    intake::refuse_copy(None, error_dir, &folder, &row.name, &text)
                }
                Err(failure) => return Err(failure),
            },
        }
        .with_context(|| format!("copying {} into the error folder", row.name))
    }
}

/// Putting a claimed file where it belongs.
#[derive(Clone)]
pub(super) struct EndJob {
    claim: String,
    profile: String,
    name: String,
}

impl Job<Farm> for EndJob {
    const KIND: &'static str = "End";
    type Outcome = Result<ClaimEnd>;

    fn about(&self) -> String {
        self.claim.clone()
    }

    async fn done(self, farm: &mut Farm, ended: Self::Outcome) -> Result<()> {
        farm.on_ended(&self, ended).await
    }
}

impl EndJob {
    fn of(part: &PartRow) -> Self {
        Self { claim: part.file.claim.clone(), profile: part.profile.clone(), name: part.name.clone() }
    }

    fn of_claim(profile: &str, claim: &Claim) -> Self {
        Self { claim: claim.id.clone(), profile: profile.to_owned(), name: claim.display_name() }
    }
}

/// Copying the original of a waiting part that is refused.
#[derive(Clone)]
pub(super) struct CopyJob {
    part: PartId,
}

impl Job<Farm> for CopyJob {
    const KIND: &'static str = "Copy";
    type Outcome = Result<()>;

    fn about(&self) -> String {
        self.part.to_string()
    }

    async fn done(self, farm: &mut Farm, copied: Self::Outcome) -> Result<()> {
        farm.on_copied(self.part, copied).await
    }

    async fn panicked(self, farm: &mut Farm, message: &str) -> Result<()> {
        farm.on_copied(self.part, Err(anyhow::anyhow!("panicked: {message}"))).await
    }

    fn not_started(self, farm: &mut Farm, why: &str) {
        farm.on_not_copied(self.part, &anyhow::anyhow!("{why}"));
    }
}

impl Farm {
    /// claimed -> rejected, then the file goes into the error folder; a crash between is caught up by `record`.
    pub(super) async fn refuse(&mut self, part: &PartRow, cause: Refusal, reason: &str) -> Result<()> {
        warn!(part.id = %part.id, profile = %part.profile, "Refused {} in {}: {reason}", part.name, part.profile);
        self.ledger.reject(part.id, cause, reason).await?;
        self.mark_decided(part).await;
        self.put_into_error(part, Some(cause), reason);
        Ok(())
    }

    /// Ends the claims of parts that were read or refused; what failed earlier (an error folder that could not be
    /// written to) is tried again.
    pub(super) async fn settle_claims(&mut self) -> Result<()> {
        for claim in self.ending.claims.keys().cloned().collect::<Vec<_>>() {
            let parts = self.ledger.parts_of_claim(&claim).await?;
            parts.first().into_iter().for_each(|part| self.settle_claim(part));
        }
        Ok(())
    }

    pub(super) fn settle_claim(&mut self, part: &PartRow) {
        match part.state {
            PartState::Claimed => {}
            PartState::Rejected => self.put_into_error(part, part.refusal, &part.reason),
            // It was read: only its original is left to let go.
            _ => self.let_go(part),
        }
    }

    /// Whether a job still puts a part's file where it belongs, or takes it out of the store.
    pub(super) fn is_ending(&self, part: &PartRow) -> bool {
        self.jobs.runs::<EndJob>(&part.file.claim)
            || self.ending.leaving.contains_key(&part.id)
            || self.ending.forgetting.is_under_way(&part.file.content_hash)
    }

    fn refused(&self, part: &PartRow, cause: Option<Refusal>, reason: &str) -> Option<Refused> {
        let station = self.stations.get(&part.profile)?;
        let folders = &station.profile.folders;
        Some(Refused {
            part: part.clone(),
            text: reason_text(part, cause, reason),
            inbox: folders.inbox.clone(),
            error_dir: folders.error.clone(),
            meshes: self.meshes.clone(),
            holds: station.holds.clone(),
            claim: self.ending.claims.get(&part.file.claim).cloned(),
        })
    }

    fn put_into_error(&mut self, part: &PartRow, cause: Option<Refusal>, reason: &str) {
        self.reading.again.done(&part.id);
        let Some(refused) = self.refused(part, cause, reason) else { return };
        self.end(EndJob::of(part), move || refused.put_into_error());
    }

    /// Another farm has the file: a copy goes to the refused ones where there is one and the folder is ours.
    pub(super) fn put_aside(&mut self, part: &PartRow, reason: &str) {
        let Some(refused) = self.refused(part, Some(Refusal::Cancelled), reason) else { return };
        let id = part.id;
        self.end(EndJob::of(part), move || {
            if let Err(failure) = refused.copy_into_error() {
                debug!(part.id = %id, "No copy of a part that was given up is in the error folder: {failure:#}.");
            }
            Ok(ClaimEnd::Done)
        });
    }

    /// Lets the claimed original go: the store has it, and its row is committed.
    pub(super) fn let_go(&mut self, part: &PartRow) {
        self.reading.again.done(&part.id);
        let Some(StandingClaim { claim, .. }) = self.ending.claims.get(&part.file.claim).cloned() else { return };
        let content_hash = part.file.content_hash.clone();
        self.end(EndJob::of(part), move || {
            match intake::release(&claim, &content_hash)? {
                Released::GivenBack(path) => {
                    let file = path.display();
                    warn!("{file} was written to after it was claimed; it is taken again as a new revision.");
                }
                // Its part is given up with the next look at the folders, and no build takes it before.
                Released::TakenOver => return Ok(ClaimEnd::Done),
                Released::Removed => {}
            }
            Ok(ClaimEnd::LetGo)
        });
    }

    /// Puts a claimed file back into the hot folder: it was written to after its row was committed, and then nestd crashed, so
    /// that it is a new revision.
    pub(super) fn give_back(&mut self, profile: &str, claim: &Claim, stored: &Stored) {
        let (end, store) = (EndJob::of_claim(profile, claim), self.meshes.store.clone());
        let (claim, hash) = (claim.clone(), stored.hash.clone());
        self.end(end, move || {
            intake::give_back(&claim)?;
            store.forget_note(&hash, &claim.id)?;
            Ok(ClaimEnd::GivenBack(hash))
        });
    }

    /// Lets a claim go that brought a damaged file again, and is no order of its own.
    pub(super) fn let_replacement_go(&mut self, profile: &str, claim: &Claim, stored: &Stored) {
        let (claim, hash) = (claim.clone(), stored.hash.clone());
        self.end(EndJob::of_claim(profile, &claim), move || {
            intake::release(&claim, &hash)?;
            Ok(ClaimEnd::Done)
        });
    }

    fn end(&mut self, end: EndJob, work: impl FnOnce() -> Result<ClaimEnd> + Send + 'static) {
        self.jobs.start(end, work);
    }

    /// A claim has ended; one that could not, or was found while its end was worked at, is tried again.
    async fn on_ended(&mut self, of: &EndJob, ended: Result<ClaimEnd>) -> Result<()> {
        match ended {
            Ok(ClaimEnd::ToBeFound) => {}
            Ok(end) => {
                self.ending.claims.remove(&of.claim);
                match end {
                    ClaimEnd::LetGo => drop(self.ending.let_go.insert(of.claim.clone())),
                    ClaimEnd::GivenBack(hash) => self.forget([Forgettable::StoredFile(hash)]).await?,
                    _ => {}
                }
            }
            Err(failure) => {
                self.trouble(Attention::EndingFails, &of.profile, &of.name, &failure);
                if let (false, Some(station)) =
                    (self.ending.claims.contains_key(&of.claim), self.stations.get_mut(&of.profile))
                {
                    // Nobody remembers it but its folder: the next look finds it there.
                    station.inbox.relist = true;
                }
            }
        }
        Ok(())
    }

    /// waiting -> rejected, once a copy of the original is in the error folder: after a crash between, whoever asked asks
    /// again.
    pub(super) fn begin_leaving(&mut self, part: PartRow, cause: Refusal, reason: &str, command: Option<&CommandRow>) {
        let Some(refused) = self.refused(&part, Some(cause), reason) else { return };
        let id = part.id;
        self.ending.leaving.insert(id, Leaving { part, cause, reason: reason.to_owned(), command: command.cloned() });
        self.jobs.start(CopyJob { part: id }, move || refused.copy_into_error());
    }

    /// A copy of a waiting part's original is in the error folder, or could not be put there.
    async fn on_copied(&mut self, id: PartId, copied: Result<()>) -> Result<()> {
        if let Err(failure) = copied {
            self.on_not_copied(id, &failure);
            return Ok(());
        }
        let Some(Leaving { part, cause, reason, command }) = self.ending.leaving.remove(&id) else { return Ok(()) };
        let left = self.ledger.cancel(id, cause, &reason).await;
        if left.is_ok() {
            self.mark_decided(&part).await;
        }
        let Some(command) = command else { return Ok(left?) };
        match left {
            Ok(()) => {
                let done = format!("part {id} is cancelled");
                info!(part.id = %id, asked_by = %command.asked_by, "An order by hand: {done}.");
                self.ledger.answer(command.id, true, &done).await?;
            }
            Err(error @ (LedgerError::Sql(_) | LedgerError::ReadOnly)) => return Err(error.into()),
            Err(refused) => self.ledger.answer(command.id, false, &refused.to_string()).await?,
        }
        Ok(())
    }

    /// The order by hand stays open, and a search tries the part once more.
    fn on_not_copied(&mut self, id: PartId, failure: &anyhow::Error) {
        let Some(Leaving { part, command, .. }) = self.ending.leaving.remove(&id) else { return };
        if let Some(command) = command {
            let about = format!("order {}", command.id);
            self.trouble(Attention::StepFails, &command.profile, &about, failure);
            return self.schedule.steps.failed(about);
        }
        self.trouble(Attention::EndingFails, &part.profile, &part.name, failure);
        if let Some(station) = self.stations.get_mut(&part.profile) {
            station.open.forget_tried(self.schedule.time.instant());
        }
    }
}
