//! The file of a published build on its way out of a queue: the next step of it, from what the ledger has recorded. Runs on a job's
//! thread, since a queue may be a share that hangs.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use delivery::queue::{FileState, OpenQueue, PrinterQueue, TakeBackOutcome};
use ledger::{BuildRow, BuildState, FoundPlace, Ledger};
use tokio::runtime::Handle;

use super::staged_build::{has_hash, is_of_hash};
use crate::{
    leases::folder_leases::FolderLeases,
    records::build_record::note_withdrawn,
    scanning::queue_contents::{BuildFiles, SoughtFile, VisibleFile},
};

/// What a file is taken back for.
pub(super) enum TakeBackTarget {
    /// A word, which has its copies wait again.
    Waiting {
        /// The word was carried out: what was taken back is removed.
        is_carried_out: bool,
        /// The archive with its record.
        archive: PathBuf,
    },
    /// Another printer.
    Printer {
        /// Its queue.
        queue: OpenQueue,
        /// The printers that can be used.
        usable: Vec<String>,
        /// The queue that it was to go to before another one was chosen.
        abandoned: Option<OpenQueue>,
        /// Why it does not fit its machine any more; `None` = it does.
        misfit: Option<String>,
    },
}

/// How far a file has come.
#[derive(Debug)]
pub(crate) enum TakeBackStep {
    /// Its printer took it before it was taken back.
    Taken,
    /// What lies under its name is not the proved file.
    Altered,
    /// Its copies lie in a queue under another name, or a second time: where.
    Copied(String),
    /// It is at another printer than the ledger says, as after a backup was put back.
    Elsewhere(FoundPlace),
    /// It is out of the printer's reach: its copies are to wait again.
    TakenBack,
    /// It is in no queue any more.
    Removed,
    /// Nothing keeps it from going to this printer.
    Free(String),
    /// Second files of it lie in queues, or lay there: it goes nowhere before a person has looked, which the look into the queues tells.
    Held,
    /// All of it is in the queue of a printer, with this id: staged by nestd, or visible, where a person copied it there.
    Staged { printer: String, queue_id: String },
    /// It is visible at the other printer, or was.
    Published,
    /// Its outcome was told meanwhile, but the other printer has taken it.
    TakenThere,
}

/// A file that is taken back.
pub(super) struct TakenFile {
    pub(super) build: BuildRow,
    /// Where second files of it were seen.
    pub(super) second: Vec<String>,
    /// The queue where it was published.
    pub(super) source: OpenQueue,
    pub(super) target: TakeBackTarget,
    /// The open queues of its machine, by the names of its printers.
    pub(super) queues: Vec<(String, OpenQueue)>,
    pub(super) leases: FolderLeases,
    pub(super) ledger: Ledger,
    pub(super) runtime: Handle,
}

impl TakenFile {
    /// The next step.
    pub(super) fn go_on(&self) -> Result<TakeBackStep> {
        self.check_rights()?;
        let name = self.build.staged.file_name.as_deref().context("its row names no file")?;
        match &self.target {
            TakeBackTarget::Waiting { is_carried_out: false, .. } => match self.find_copies(name) {
                Some(places) => Ok(TakeBackStep::Copied(places)),
                None => Ok(self.take_back(name)?.unwrap_or(TakeBackStep::TakenBack)),
            },
            TakeBackTarget::Waiting { archive, .. } => {
                // Before nothing else tells any more that nobody printed it.
                if let Some(at) = self.build.place.withdrawn_at {
                    note_withdrawn(archive, name, at)?;
                }
                self.source.remove_taken_back(name)?;
                Ok(TakeBackStep::Removed)
            }
            TakeBackTarget::Printer { queue, usable, abandoned, misfit } => {
                match (self.build.place.move_queue_id.is_some(), self.build.state == BuildState::Published) {
                    (false, true) => self.move_to(name, (queue, usable), (abandoned.as_ref(), misfit.as_deref())),
                    (true, true) => self.publish(name, queue, misfit.as_deref()),
                    (_, false) => self.drop_file(name, queue),
                }
            }
        }
    }

    /// Fails unless this daemon still serves the ledger and the queues.
    fn check_rights(&self) -> Result<()> {
        self.ledger.ensure_served()?;
        self.leases.check_publishing(self.source.address())?;
        if let TakeBackTarget::Printer { queue, .. } = &self.target {
            self.leases.check_publishing(queue.address())?;
        }
        Ok(())
    }

    /// Takes the file back. `None` = it is out of the printer's reach; else how that ended.
    fn take_back(&self, name: &str) -> Result<Option<TakeBackStep>> {
        let proved = self.proved_hash()?;
        Ok(match self.source.take_back(name, &|file| is_of_hash(file, proved))? {
            TakeBackOutcome::TakenBack => None,
            TakeBackOutcome::Altered => Some(TakeBackStep::Altered),
            TakeBackOutcome::Gone => {
                Some(self.find_elsewhere(name).map_or(TakeBackStep::Taken, TakeBackStep::Elsewhere))
            }
        })
    }

    /// Where its copies could be printed from when its file is taken back. What was taken back before stays so: its word is carried out,
    /// and what came since is told of.
    fn find_copies(&self, name: &str) -> Option<String> {
        if self.source.holds_taken_back(name) {
            return None;
        }
        let others = BuildFiles::find(&self.queues, &self.sought(name)).other_places();
        (!others.is_empty()).then(|| others.join(", "))
    }

    fn sought<'f>(&'f self, name: &'f str) -> SoughtFile<'f> {
        SoughtFile { name, queue_id: Some(self.source.id()), second: &self.second }
    }

    fn proved_hash(&self) -> Result<&str> {
        self.build.staged.file_hash.as_deref().context("its row does not say what was proved")
    }

    fn find_elsewhere(&self, name: &str) -> Option<FoundPlace> {
        let BuildFiles { own, taken_back, .. } = BuildFiles::find_named(&self.queues, &self.sought(name));
        let (printer, queue) = own.map(|own| (own.printer, own.queue)).or(taken_back)?;
        Some(FoundPlace {
            printer,
            queue_id: queue.id().to_owned(),
            instead_of: self.build.staged.queue_id.clone(),
            is_taken_back: false,
        })
    }

    /// Takes the file back and stages it in the queue of the other printer. Where a person has copied it to a printer, that copy is the
    /// moved one.
    fn move_to(
        &self,
        name: &str,
        (target, usable): (&OpenQueue, &[String]),
        (abandoned, misfit): (Option<&OpenQueue>, Option<&str>),
    ) -> Result<TakeBackStep> {
        let files = BuildFiles::find(&self.queues, &SoughtFile { second: &[], ..self.sought(name) });
        let is_taken_back = self.source.holds_taken_back(name);
        let is_own = |file: &&VisibleFile| file.name == name && file.queue.id() == self.source.id() && !is_taken_back;
        let (own, others): (Vec<&VisibleFile>, Vec<_>) = files.own.iter().chain(&files.others).partition(is_own);
        let copied = match others[..] {
            // Its printer took it, or it is elsewhere.
            _ if own.is_empty() && !is_taken_back => None,
            [] if self.second.is_empty() => None,
            [file] if self.is_moved_by_hand(file, usable)? => Some(file),
            _ => return Ok(TakeBackStep::Held),
        };
        if let Some(file) = copied {
            self.runtime.block_on(self.ledger.record_second_file(self.build.id, &file.to_string()))?;
        }
        if self.build.place.move_to.is_none() {
            let printer = copied.map(|file| file.printer.clone()).or_else(|| self.printer_of(target));
            return Ok(printer.map_or(TakeBackStep::Held, TakeBackStep::Free));
        }
        match (self.take_back(name)?, copied) {
            (None, Some(file)) => {
                for queue in [Some(target), abandoned].into_iter().flatten() {
                    discard_staged(&**queue, name)?;
                }
                file.queue.discard(name)?;
                Ok(TakeBackStep::Staged { printer: file.printer.clone(), queue_id: file.queue.id().to_owned() })
            }
            (None, None) => self.stage(name, (target, abandoned, misfit)),
            // It was there a moment ago: that one was not moved by hand.
            (Some(TakeBackStep::Elsewhere(_)), Some(_)) => Ok(TakeBackStep::Taken),
            (Some(TakeBackStep::Altered), _) => bail!(self.not_proved_text()),
            (Some(step), _) => Ok(step),
        }
    }

    /// Whether a second file is the only one that was ever seen, is the proved one, and lies where it can be printed.
    fn is_moved_by_hand(&self, file: &VisibleFile, usable: &[String]) -> Result<bool> {
        let is_known = self.second.iter().all(|place| *place == file.to_string());
        Ok(is_known
            && Some(&file.name) == self.build.staged.file_name.as_ref()
            && usable.contains(&file.printer)
            && has_hash(&file.queue.file(&file.name, FileState::Visible)?, self.proved_hash()?)?)
    }

    fn printer_of(&self, queue: &OpenQueue) -> Option<String> {
        self.queues.iter().find(|(_, other)| other.id() == queue.id()).map(|(printer, _)| printer.clone())
    }

    /// Stages what was taken back in the queue of the other printer.
    fn stage(
        &self,
        name: &str,
        (target, abandoned, misfit): (&OpenQueue, Option<&OpenQueue>, Option<&str>),
    ) -> Result<TakeBackStep> {
        if let Some(why) = misfit {
            bail!(
                "it was taken back from a printer that is down and goes to no other one, for {why}. `nestd outcome {} failed` has its \
                 parts printed again for the machine as it is now",
                self.build.id
            );
        }
        if let Some(abandoned) = abandoned {
            discard_staged(&**abandoned, name)?;
        }
        if let Err(failure) = target.stage_taken_back(&*self.source, name) {
            target.discard(name)?;
            return Err(failure.into());
        }
        if !has_hash(&target.file(name, FileState::Staged)?, self.proved_hash()?)? {
            target.discard(name)?;
            bail!(self.not_proved_text());
        }
        let printer = self.printer_of(target).context("the queue is no printer's")?;
        Ok(TakeBackStep::Staged { printer, queue_id: target.id().to_owned() })
    }

    fn not_proved_text(&self) -> String {
        format!(
            "what lay in the queue folder {} is not the file that was proved; `nestd outcome {} failed` has its parts printed again",
            self.source.address(),
            self.build.id
        )
    }

    /// Makes what is staged visible at the other printer.
    fn publish(&self, name: &str, target: &OpenQueue, misfit: Option<&str>) -> Result<TakeBackStep> {
        if let Some(why) = misfit.filter(|_| matches!(target.state(name), Ok(FileState::Staged))) {
            bail!(
                "it was on its way to another printer and is not put into its queue, for {why}. Undo that change of the machine's file and \
                 reload nestd; then `nestd withdraw {}`, and change the file again",
                self.build.id
            );
        }
        if target.state(name)? == FileState::Staged && (target.stamp(name).is_some() || !self.second.is_empty()) {
            return Ok(TakeBackStep::Held);
        }
        // First, so that what was taken back is never there when it may be visible at the other printer.
        self.source.remove_taken_back(name)?;
        self.check_rights()?;
        // The share may have hung since the row was read.
        if !self.is_wanted()? {
            return self.drop_file(name, target);
        }
        target.publish(name)?;
        Ok(TakeBackStep::Published)
    }

    /// Whether its outcome is not told, as the ledger says at this moment.
    fn is_wanted(&self) -> Result<bool> {
        let now = self.runtime.block_on(self.ledger.find_build(self.build.id))?;
        Ok(now.is_some_and(|now| now.state == BuildState::Published))
    }

    /// Its outcome was told while it moved: the file goes out of both queues.
    fn drop_file(&self, name: &str, target: &OpenQueue) -> Result<TakeBackStep> {
        let may_be_visible = self.build.place.move_queue_id.is_some();
        let is_staged = target.state(name)? == FileState::Staged;
        if self.source.holds_taken_back(name) || may_be_visible && is_staged {
            self.runtime.block_on(self.ledger.record_dropped_move(self.build.id))?;
        }
        let step = if may_be_visible && !is_staged {
            match target.take_back(name, &|_| Ok(true))? {
                TakeBackOutcome::TakenBack => {
                    target.remove_taken_back(name)?;
                    TakeBackStep::Removed
                }
                TakeBackOutcome::Gone | TakeBackOutcome::Altered => TakeBackStep::TakenThere,
            }
        } else {
            discard_staged(&**target, name)?;
            TakeBackStep::Removed
        };
        self.source.remove_taken_back(name)?;
        Ok(step)
    }
}

/// Removes a copy that was not visible yet.
fn discard_staged(queue: &dyn PrinterQueue, name: &str) -> Result<()> {
    if queue.state(name)? == FileState::Staged {
        queue.discard(name)?;
    }
    Ok(())
}
