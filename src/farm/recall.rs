//! Files that were taken after the backup was made: what their notes say is known again. What may have been printed or refused
//! since is not printed but told.

use std::{collections::HashSet, path::PathBuf};

use anyhow::{Context, Result};

use super::{
    error_folder::{COPIES_UNKNOWN, REASON, reason_text},
    reconciled::{DECIDED_SINCE, Later, Reconciled, Refused, UNKNOWN, put_into_error},
    taken::{Forgotten, Taken},
};
use crate::{
    ledger::{Ledger, PartRow, Refusal},
    settings::Settings,
};

/// Takes forgotten files into a ledger.
pub(super) struct Recall<'a> {
    pub settings: &'a Settings,
    pub ledger: &'a Ledger,
    pub refused: &'a Refused,
    /// Contents that may be printed.
    pub unclear: &'a HashSet<String>,
    pub found: &'a mut Reconciled,
}

impl Recall<'_> {
    /// One of them.
    pub(super) async fn take(&mut self, one: Forgotten) -> Result<()> {
        let name = one.name();
        match &one.taken {
            Some(taken) if one.is_stored => self.take_known(&one, taken).await,
            Some(_) => {
                self.found.doubts.push(format!("{name} was taken after the backup was made, and its file is gone from the store: drop it again if it is needed"));
                self.set_aside(&one);
                Ok(())
            }
            None => {
                let known = (self.settings.profiles.keys()).find(|p| !self.refused.of(p, &one.hash).is_empty());
                let place = self.settings.state_dir.join(UNKNOWN).join(&one.hash);
                let (place, told) = (
                    place.display(),
                    match known {
                        Some(profile) => {
                            format!("it was refused or cancelled, and lies in the error folder of {profile}")
                        }
                        None => "look at it, and drop it again with its copies".to_owned(),
                    },
                );
                let text = format!(
                    "{name} was taken after the backup was made and nothing is noted of it; it is kept as {place}: {told}"
                );
                self.found.doubts.push(text);
                self.set_aside(&one);
                Ok(())
            }
        }
    }

    fn set_aside(&mut self, one: &Forgotten) {
        let step = Later::SetFileAside(one.hash.clone());
        if !self.found.later.contains(&step) {
            self.found.later.push(step);
        }
    }

    async fn take_known(&mut self, one: &Forgotten, taken: &Taken) -> Result<()> {
        let (part, name) = (&taken.part, one.name());
        let id = self.ledger.record_claim(part).await?.id;
        let lies = self.refused.of(&part.profile, &one.hash).first().cloned();
        let (cause, why) = match (&taken.unclear, &lies) {
            (_, Some(_)) => (
                Refusal::Other,
                "It lies in the error folder: it was refused or cancelled after the backup was made.".to_owned(),
            ),
            (Some(why), None) => {
                (Refusal::Ticket, format!("{why}. {COPIES_UNKNOWN}: mend the ticket and drop both again."))
            }
            (None, None) if self.unclear.contains(&one.hash) => (
                Refusal::Other,
                "A build file in the queue holds the same file, so it may be printed already.".to_owned(),
            ),
            (None, None) if one.decisions > 0 => (Refusal::Other, format!("{DECIDED_SINCE}.")),
            (None, None) => {
                let copies = if part.copies == 1 { "1 copy".to_owned() } else { format!("{} copies", part.copies) };
                self.found.done.push(format!(
                    "part {id} ({name}, {copies}, for {}) was taken after the backup was made; it is taken in and waits",
                    part.profile
                ));
                return Ok(());
            }
        };
        self.ledger.reject(id, cause, &why).await?;
        self.ledger.raise_decisions(&part.claim, one.decisions).await?;
        let row = self.ledger.part(id).await?.context("a part that was recorded has no row")?;
        self.show_refused(&row, lies)?;
        self.found.doubts.push(format!("part {id} ({name}) is not printed. {why}"));
        Ok(())
    }

    /// The file of a part that is not printed lies in the error folder, with a reason that names it.
    fn show_refused(&mut self, row: &PartRow, lies: Option<PathBuf>) -> Result<()> {
        match (lies, self.settings.profiles.get(&row.profile)) {
            (Some(file), _) => {
                let mut reason = file.into_os_string();
                reason.push(REASON);
                if PathBuf::from(&reason).is_file() {
                    self.found.later.push(Later::Rename(reason.into(), reason_text(row, row.refusal, &row.reason)));
                }
                Ok(())
            }
            (None, Some(profile)) => put_into_error(self.settings, profile, row),
            (None, None) => Ok(()),
        }
    }
}
