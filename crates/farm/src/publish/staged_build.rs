//! A staged, proved build on its way into the queue: checks that it is still what was proved, and renames it once. Runs
//! on a job's thread, since a queue folder may be a share that hangs.

use std::{
    io,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use delivery::queue::{FileState, OpenQueue, PublishOutcome, QueueError};
use ledger::{BuildRow, Ledger};

use crate::{
    leases::{folder_lease::LeaseError, folder_leases::FolderLeases},
    records::build_record,
};

/// The progress of a build on its way into the queue.
#[derive(Debug)]
pub enum PublishStep {
    /// Nothing was tried yet: the ledger must record the attempt before the first rename.
    Ready,
    /// The build is in the queue, or was.
    Done(PublishOutcome),
    /// The build is not published and must be made again: the staged file is not the one that was proved, or does not fit the machine
    /// any more; why.
    MadeAgain(String),
    /// The first rename was not done for this reason, and will certainly not be done later.
    NotRenamed(anyhow::Error),
    /// It was certainly never published: it may be made again, for another printer.
    NeverPublished,
}

/// A build in the state verified.
#[derive(Debug)]
pub struct StagedBuild {
    /// The queue that is there now.
    pub queue: OpenQueue,
    /// Its row.
    pub build: BuildRow,
    /// Why it does not fit its machine any more; `None` = it does.
    pub misfit: Option<String>,
    /// The archive with its record.
    pub archive: PathBuf,
    /// The leases on its folders.
    pub leases: FolderLeases,
    /// The ledger that its row is in.
    pub ledger: Ledger,
}

/// The build was staged in another queue folder, and its file is not in the current one.
#[derive(Debug, thiserror::Error)]
#[error("{name} was staged in the queue folder whose .nestd-queue says {was}, and is not in the one that is there now")]
pub struct QueueReplacedError {
    name: String,
    was: String,
}

impl StagedBuild {
    fn file_name(&self) -> Result<&str> {
        self.build.staged.file_name.as_deref().context("its row names no file")
    }

    /// Fails unless this daemon still serves the folders and the ledger.
    fn check_rights(&self) -> Result<()> {
        self.ledger.ensure_served()?;
        Ok(self.check_folders()?)
    }

    /// Fails unless this farm still holds the queue folder and the archive.
    pub fn check_folders(&self) -> Result<(), LeaseError> {
        self.leases.check_publishing(self.queue.address())
    }

    /// Where its file is. If the queue folder is not the one that it was staged in, "gone" says nothing: a person must
    /// check.
    fn staged_state(&self) -> Result<FileState> {
        let (name, was) = (self.file_name()?, self.build.staged.queue_id.as_deref());
        match self.queue.state(name)? {
            FileState::Gone | FileState::TakenBack if was != Some(self.queue.id()) => {
                Err(QueueReplacedError { name: name.to_owned(), was: was.unwrap_or_default().to_owned() }.into())
            }
            state => Ok(state),
        }
    }

    /// Checks the build before the first attempt. If the file is gone, somebody removed it, unless its record shows
    /// that a restored ledger has forgotten the attempt.
    pub fn check_before_publishing(&self) -> Result<PublishStep> {
        let name = self.file_name()?;
        Ok(match self.staged_state()? {
            FileState::Staged => self.misfit.clone().map_or(PublishStep::Ready, PublishStep::MadeAgain),
            _ if build_record::has_record(&self.archive, name)? => PublishStep::Ready,
            FileState::Visible => {
                let visible = self.queue.file(name, FileState::Visible)?;
                match self.is_proved(&visible)? {
                    // Somebody renamed it by hand: the printer has it, or will take it.
                    true => PublishStep::Ready,
                    false => return Err(QueueError::NameTaken(visible).into()),
                }
            }
            FileState::Gone | FileState::TakenBack => PublishStep::MadeAgain("its staged file was removed".to_owned()),
        })
    }

    /// Whether a build whose printer is down may be made again, for another one. Where its record or its folder shows that a
    /// restored ledger may have forgotten the attempt, it is taken for published as by [`Self::check_before_publishing`].
    pub fn check_before_remaking(&self) -> Result<PublishStep> {
        if build_record::has_record(&self.archive, self.file_name()?)? {
            return self.check_before_publishing();
        }
        match self.staged_state() {
            Ok(FileState::Staged) => Ok(PublishStep::NeverPublished),
            // Another folder is there now. Without a record, nothing was renamed in the one that was.
            Err(failure) if failure.is::<QueueReplacedError>() => Ok(PublishStep::NeverPublished),
            Ok(_) => self.check_before_publishing(),
            Err(failure) => Err(failure),
        }
    }

    /// Publishes the build, after the ledger has recorded the attempt. `is_first` = nothing was ever tried before.
    pub fn try_publish(&self, record: &str, is_first: bool) -> Result<PublishStep> {
        if self.staged_state()? != FileState::Staged {
            self.check_rights()?;
            return Ok(PublishStep::Done(self.queue.publish(self.file_name()?)?));
        }
        let why = match &self.misfit {
            Some(misfit) => Some(misfit.clone()),
            None => self.find_damage()?,
        };
        if let Some(why) = why {
            // The file is still staged, so it was never renamed.
            build_record::remove_record(&self.archive, self.file_name()?)?;
            return Ok(PublishStep::MadeAgain(why));
        }
        let tried = build_record::write_record(&self.archive, &self.build, record).and_then(|()| {
            // Checked once more: comparing the bytes and writing the record may have taken long.
            self.check_rights()?;
            Ok(self.queue.publish(self.file_name()?)?)
        });
        match tried {
            Ok(published) => Ok(PublishStep::Done(published)),
            Err(failure) if is_first && self.is_certainly_unpublished(&failure) => {
                build_record::remove_record(&self.archive, self.file_name()?)?;
                Ok(PublishStep::NotRenamed(failure))
            }
            Err(failure) => Err(failure),
        }
    }

    fn is_certainly_unpublished(&self, failure: &anyhow::Error) -> bool {
        let queue = failure.downcast_ref::<QueueError>();
        queue.is_none_or(QueueError::is_certainly_unpublished)
    }

    /// Why the staged file is not the one that was proved, if so: bytes rot, a crash tears files, people delete them.
    fn find_damage(&self) -> Result<Option<String>> {
        let name = self.file_name()?;
        if !self.is_proved(&self.queue.file(name, FileState::Staged)?)? {
            return Ok(Some("its staged file is not the one that was proved".to_owned()));
        }
        for (sidecar, hash) in self.build.sidecar_hashes() {
            let is_whole_as = |state| has_hash(&self.queue.file(&sidecar, state)?, &hash);
            if !is_whole_as(FileState::Staged)? && !is_whole_as(FileState::Visible)? {
                return Ok(Some(format!("what was staged beside it as {sidecar} is not whole any more")));
            }
        }
        Ok(None)
    }

    fn is_proved(&self, file: &Path) -> Result<bool> {
        has_hash(file, self.build.staged.file_hash.as_deref().context("its row does not say what was proved")?)
    }
}

/// Same as [`StagedBuild::check_before_remaking`], while the queue folder of the printer is away.
pub(crate) fn check_record_of_away(archive: &Path, build: &BuildRow, leases: &FolderLeases) -> Result<PublishStep> {
    leases.archive.check_held()?;
    let name = build.staged.file_name.as_deref().context("its row names no file")?;
    ensure!(
        !build_record::has_record(archive, name)?,
        "its record in the archive shows that it may be published, and the queue folder of its printer is not available"
    );
    Ok(PublishStep::NeverPublished)
}

/// Whether a file has this hash; a missing file does not.
pub(crate) fn has_hash(file: &Path, hash: &str) -> Result<bool> {
    is_of_hash(file, hash).with_context(|| format!("reading {}", file.display()))
}

/// Same as [`has_hash`], for who names the file in the error.
pub(crate) fn is_of_hash(file: &Path, hash: &str) -> io::Result<bool> {
    match intake::hash_file(file) {
        Ok(found) => Ok(found == hash),
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::InvalidInput) => Ok(false),
        Err(error) => Err(error),
    }
}
