//! Recovers files that were claimed after the backup was made, from their notes. Files that may have been printed or
//! refused since are not printed, but reported.

use std::{collections::HashSet, path::PathBuf};

use anyhow::{Context, Result};
use ledger::{Ledger, NewPartRow, PartId, PartRow, PartState, RefusalCause};
use settings::Settings;

use super::{
    newer_decisions::{how_to_take_back, wanted_then},
    reconcile_report::{
        DECIDED_SINCE, DeferredFolderStep, ErrorFolderIndex, ReconcileReport, UNKNOWN_FILES_DIR, copy_to_error_folder,
    },
};
use crate::files::{
    claim_note::{ClaimNote, ForgottenFile},
    error_folder::{ASKED_UNCLEARLY, find_refused_files, reason_text},
};

/// Records forgotten files in a ledger.
pub(crate) struct ForgottenFileRecovery<'a> {
    pub settings: &'a Settings,
    pub ledger: &'a Ledger,
    pub refused: &'a ErrorFolderIndex,
    /// Contents that may be printed already.
    pub possibly_printed: &'a HashSet<String>,
    pub report: &'a mut ReconcileReport,
    /// Files of the error folders that belong to parts which were recovered before.
    pub assigned: HashSet<PathBuf>,
}

impl ForgottenFileRecovery<'_> {
    /// Recovers one of them.
    pub(super) async fn recover_file(&mut self, one: ForgottenFile) -> Result<()> {
        let name = one.display_name();
        match &one.note {
            Some(taken) if one.is_stored || one.is_in_work => self.recover_noted_file(&one, taken).await,
            Some(_) => {
                self.report.doubts.push(format!("{name} was taken after the backup was made, and its file is gone from the store: drop it again if it is needed"));
                self.schedule_set_aside(&one);
                Ok(())
            }
            None => {
                let known =
                    (self.settings.profiles.keys()).find(|p| !self.refused.files_with_content(p, &one.hash).is_empty());
                let place = self.settings.state_dir.join(UNKNOWN_FILES_DIR).join(&one.hash);
                let (place, told) = (
                    place.display(),
                    match known {
                        Some(machine) => {
                            format!("it was refused or cancelled, and lies in the error folder of {machine}")
                        }
                        None => "look at it, and drop it again with its copies".to_owned(),
                    },
                );
                let text = format!(
                    "{name} was taken after the backup was made and nothing is noted of it; it is kept as {place}: {told}"
                );
                self.report.doubts.push(text);
                self.schedule_set_aside(&one);
                Ok(())
            }
        }
    }

    fn schedule_set_aside(&mut self, one: &ForgottenFile) {
        let step = DeferredFolderStep::SetFileAside(one.hash.clone());
        if !self.report.folder_steps.contains(&step) {
            self.report.folder_steps.push(step);
        }
    }

    async fn recover_noted_file(&mut self, one: &ForgottenFile, taken: &ClaimNote) -> Result<()> {
        let (part, name) = (&taken.row_as_asked(one.decisions), one.display_name());
        let id = self.ledger.record_claim(part).await?.id;
        let lies = self.find_refused_copy(id, part, &one.hash).await?;
        let wanted = match taken.wanted.values().collect::<Vec<_>>()[..] {
            [&wanted] if wanted != part.copies => Some(wanted),
            _ => None,
        };
        let (cause, why) = match (&taken.unclear, &lies) {
            (_, Some(_)) => (
                RefusalCause::Other,
                "It lies in the error folder: it was refused or cancelled after the backup was made.".to_owned(),
            ),
            (Some(why), None) => {
                (RefusalCause::Ticket, format!("{why}. {ASKED_UNCLEARLY}: mend the ticket and drop both again."))
            }
            (None, None) if self.possibly_printed.contains(&one.hash) => (
                RefusalCause::Other,
                "A build file in the queue holds the same file, so it may be printed already.".to_owned(),
            ),
            (None, None) if one.decisions > 0 => {
                (RefusalCause::Other, format!("{DECIDED_SINCE}{}.", wanted_then(wanted)))
            }
            (None, None) => {
                let copies = if part.copies == 1 { "1 copy".to_owned() } else { format!("{} copies", part.copies) };
                self.report.done.push(format!(
                    "part {id} ({name}, {copies}, for {}) was taken after the backup was made; it is taken in and waits",
                    part.machine
                ));
                return Ok(());
            }
        };
        self.ledger.refuse_claim(id, cause, &why).await?;
        self.ledger.raise_decision_count(&part.claim, one.decisions).await?;
        let row = self.ledger.find_part(id).await?.context("a part that was recorded has no row")?;
        if !one.is_in_work || lies.is_some() {
            self.show_in_error_folder(&row, lies)?;
        }
        let told = match one.decisions {
            0 => why.trim_end_matches('.').to_owned(),
            _ => format!("{why} {}", how_to_take_back(id, wanted)),
        };
        self.report.doubts.push(format!("part {id} ({name}) is not printed. {told}"));
        Ok(())
    }

    /// The file in the error folder with a content, that is of no other part.
    async fn find_refused_copy(&mut self, id: PartId, part: &NewPartRow, hash: &str) -> Result<Option<PathBuf>> {
        let Some(profile) = self.settings.profiles.get(&part.machine) else { return Ok(None) };
        let mut lying = self.refused.files_with_content(&part.machine, hash).to_vec();
        if lying.is_empty() {
            return Ok(None);
        }
        let others = self.ledger.parts_with_content(hash).await?.into_iter();
        let is_refused =
            |other: &PartRow| other.id != id && other.state == PartState::Refused && other.machine == part.machine;
        for other in others.filter(is_refused) {
            let of_other = find_refused_files(&profile.folders.error, &other)?;
            lying.retain(|file| !of_other.iter().any(|(known, _)| known == file));
        }
        let lies = lying.into_iter().find(|file| !self.assigned.contains(file));
        self.assigned.extend(lies.clone());
        Ok(lies)
    }

    /// Puts the file of a part that is not printed into the error folder, with a reason that names the part.
    fn show_in_error_folder(&mut self, row: &PartRow, lies: Option<PathBuf>) -> Result<()> {
        match (lies, self.settings.profiles.get(&row.machine)) {
            (Some(file), _) => {
                let mut reason = file.into_os_string();
                reason.push(intake::REASON_SUFFIX);
                if PathBuf::from(&reason).is_file() {
                    let (cause, why, language) = (row.refused.refusal, &row.refused.reason, self.settings.language);
                    let text = language.within(|| reason_text(row, cause, why));
                    self.report.folder_steps.push(DeferredFolderStep::RewriteReason(reason.into(), text));
                }
                Ok(())
            }
            (None, Some(profile)) => copy_to_error_folder(self.settings, profile, row),
            (None, None) => Ok(()),
        }
    }
}
