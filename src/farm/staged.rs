//! A proved build that is staged, on its way into the queue: what is there, whether it is what was proved, and the one rename.
//! Runs on a job's thread, for a queue folder may be a share that hangs.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::{holds::Holds, record};
use crate::{
    intake,
    ledger::BuildRow,
    queue::{Published, Queue, QueueError, StagedState},
};

/// How far a build came on its way into the queue.
#[derive(Debug)]
pub enum Step {
    /// Nothing was tried yet: before the first rename, the ledger is told.
    Ready,
    /// It is in the queue, or was.
    Done(Published),
    /// It is not published, and what is staged is not what was proved; why.
    Spoilt(String),
    /// The first rename was not done for this reason, and certainly will not be by itself.
    Untried(anyhow::Error),
}

/// A build that the ledger calls verified.
#[derive(Debug)]
pub struct Staged {
    /// The queue folder that is there now.
    pub queue: Queue,
    /// Its row.
    pub build: BuildRow,
    /// Where its record is kept.
    pub archive: PathBuf,
    /// The hold on its folders.
    pub holds: Holds,
}

/// The queue folder is another one than the build was staged in, and the file is not in it.
#[derive(Debug, thiserror::Error)]
#[error("{name} was staged in the queue folder whose .nestd-queue says {was}, and is not in the one that is there now")]
pub struct Replaced {
    name: String,
    was: String,
}

impl Staged {
    fn name(&self) -> Result<&str> {
        self.build.staged.file_name.as_deref().context("its row names no file")
    }

    /// Where its file is. In another folder than it was staged in, "gone" says nothing: a person must look.
    fn state(&self) -> Result<StagedState> {
        let (name, was) = (self.name()?, self.build.staged.queue_id.as_deref());
        match self.queue.state(name)? {
            StagedState::Gone if was != Some(self.queue.id()) => {
                Err(Replaced { name: name.to_owned(), was: was.unwrap_or_default().to_owned() }.into())
            }
            state => Ok(state),
        }
    }

    /// Looks before anything was tried. A file that is gone now was removed by somebody, unless its record tells that a
    /// ledger has forgotten it.
    pub fn look(&self) -> Result<Step> {
        let name = self.name()?;
        Ok(match self.state()? {
            StagedState::Staged => Step::Ready,
            _ if record::is_kept(&self.archive, name)? => Step::Ready,
            StagedState::Published => {
                let visible = self.queue.published_path(name);
                match self.is_proved(&visible)? {
                    // Somebody gave it its name by hand: the printer has it, or will.
                    true => Step::Ready,
                    false => return Err(QueueError::NameTaken(visible).into()),
                }
            }
            StagedState::Gone => Step::Spoilt("its staged file was removed".to_owned()),
        })
    }

    /// Publishes, after the ledger was told. `is_first` = nothing was ever tried before.
    pub fn publish(&self, record: &str, is_first: bool) -> Result<Step> {
        if self.state()? != StagedState::Staged {
            self.holds.demand_published()?;
            return Ok(Step::Done(self.queue.publish(self.name()?)?));
        }
        if let Some(why) = self.spoilt()? {
            // It is still staged, so that it was never renamed.
            record::forget(&self.archive, self.name()?)?;
            return Ok(Step::Spoilt(why));
        }
        let tried = record::keep(&self.archive, &self.build, record).and_then(|()| {
            // Looked at once more, freshly: comparing the bytes and writing the record may have taken long.
            self.holds.demand_published()?;
            Ok(self.queue.publish(self.name()?)?)
        });
        match tried {
            Ok(published) => Ok(Step::Done(published)),
            Err(failure) if is_first && self.is_certainly_unpublished(&failure) => {
                record::forget(&self.archive, self.name()?)?;
                Ok(Step::Untried(failure))
            }
            Err(failure) => Err(failure),
        }
    }

    fn is_certainly_unpublished(&self, failure: &anyhow::Error) -> bool {
        let queue = failure.downcast_ref::<QueueError>();
        queue.is_none_or(QueueError::is_certainly_unpublished)
    }

    /// Why what is staged is not what was proved: bytes rot, a crash of the machine tears, people tidy up.
    fn spoilt(&self) -> Result<Option<String>> {
        let name = self.name()?;
        if !self.is_proved(&self.queue.staged_path(name))? {
            return Ok(Some("its staged file is not the one that was proved".to_owned()));
        }
        for (sidecar, hash) in self.build.sidecars() {
            let places = [self.queue.staged_path(&sidecar), self.queue.published_path(&sidecar)];
            let is_whole = places.iter().map(|place| has_hash(place, &hash)).collect::<Result<Vec<bool>>>()?;
            if !is_whole.contains(&true) {
                return Ok(Some(format!("what was staged beside it as {sidecar} is not whole any more")));
            }
        }
        Ok(None)
    }

    fn is_proved(&self, file: &Path) -> Result<bool> {
        has_hash(file, self.build.staged.file_hash.as_deref().context("its row does not say what was proved")?)
    }
}

/// Whether a file holds these bytes; one that is not there does not.
fn has_hash(file: &Path, hash: &str) -> Result<bool> {
    match intake::hash_file(file) {
        Ok(found) => Ok(found == hash),
        Err(error) if matches!(error.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::InvalidInput) => {
            Ok(false)
        }
        Err(error) => Err(error).with_context(|| format!("reading {}", file.display())),
    }
}
