//! A refused part: its file, and how it comes into the error folder.

use std::path::PathBuf;

use anyhow::{Context, Result};
use language::Language;
use ledger::{PartRow, PartState, RefusalCause};

use crate::{
    alerts::failure::LostFileError,
    core::desks::Receiving,
    files::{
        error_folder::{find_refused_files, reason_text},
        mesh_source::MeshSource,
        standing_claim::StandingClaim,
    },
    leases::folder_leases::FolderLeases,
};

/// A refused part whose file must be moved into the error folder.
pub(crate) struct RefusedPart {
    part: PartRow,
    /// That of the settings: people read the reason in the folder.
    language: Language,
    text: String,
    inbox: PathBuf,
    error_dir: PathBuf,
    meshes: MeshSource,
    leases: FolderLeases,
    claim: Option<StandingClaim>,
}

/// Result of completing a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ClaimOutcome {
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
    pub(super) fn move_to_error_folder(&self) -> Result<ClaimOutcome> {
        self.leases.check_error_folder()?;
        if let Some(claim) = &self.claim {
            // The stored file is needed if somebody takes the part back.
            claim.ensure_stored(&self.meshes.store, &self.part.file.content_hash)?;
            if self.is_copied()? && claim.claim.part.exists() {
                intake::release_claim(&claim.claim, &self.part.file.content_hash)?;
                return Ok(ClaimOutcome::Done);
            }
            self.language.within(|| intake::refuse_claim(&claim.claim, &self.error_dir, &self.text))?;
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
    pub(crate) fn copy_to_error_folder(&self) -> Result<()> {
        self.leases.check_error_folder()?;
        let (row, error_dir, text) = (&self.part, &self.error_dir, &self.text);
        let folder = self.copy_folder();
        match find_refused_files(error_dir, row)?.first() {
            Some((_, known)) => intake::rewrite_reason(known, text),
            None => match self.meshes.verified_file(row) {
                Ok(stored) => intake::copy_to_error_folder(Some(&stored), error_dir, &folder, &row.name, text),
                Err(failure) if LostFileError::find_in_chain(&failure).is_some() => {
                    let why = format!("The file is not here, for nestd does not have it whole any more: {failure:#}.");
                    let text = format!("{text}\n{}\n", self.language.within(|| language::told(&why)));
                    intake::copy_to_error_folder(None, error_dir, &folder, &row.name, &text)
                }
                Err(failure) => return Err(failure),
            },
        }
        .with_context(|| format!("copying {} into the error folder", row.name))
    }
}

/// A refused part with all that a job needs to copy or move its file; `None` = its machine is gone.
pub(super) fn describe_refused_part(
    desk: &Receiving<'_>,
    part: &PartRow,
    cause: Option<RefusalCause>,
    reason: &str,
) -> Option<RefusedPart> {
    let machine = desk.machines.get(&part.machine)?;
    let (folders, language) = (&machine.profile.folders, desk.shared.settings.language);
    Some(RefusedPart {
        part: part.clone(),
        language,
        text: language.within(|| reason_text(part, cause, reason)),
        inbox: folders.inbox.clone(),
        error_dir: folders.error.clone(),
        meshes: desk.meshes.clone(),
        leases: machine.leases.clone(),
        claim: desk.completion.claims.get(&part.file.claim).cloned(),
    })
}
