//! One printer queue folder.

use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;

/// A printer queue folder of ours, known by its marker file.
#[derive(Debug, Clone)]
pub struct Queue {
    dir: PathBuf,
    id: String,
}

/// Where a build file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StagedState {
    /// Under its dot-name: not yet published.
    Staged,
    /// Under its own name: published, not yet taken by the printer.
    Published,
    /// Neither: published and taken, if it had been staged whole.
    Gone,
}

/// What publishing found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Published {
    /// The file appeared now.
    Now,
    /// The dot-file was gone: it had been published before.
    Before,
}

/// Why the queue folder did not do it.
#[derive(Debug, Error)]
pub enum QueueError {
    /// The folder is not there, or its marker is missing or another one: unmounted or replaced.
    #[error("the queue folder {} is unavailable: {why}", .dir.display())]
    Unavailable {
        /// The folder.
        dir: PathBuf,
        /// In plain words.
        why: String,
    },
    /// Not a name for a file in the queue.
    #[error("{0:?} is no name for a file in the queue")]
    BadName(String),
    /// Another file of that name is in the queue; nothing was overwritten.
    #[error("{} is in the queue already and is another file", .0.display())]
    NameTaken(PathBuf),
    /// The writer failed; nothing is left behind.
    #[error("cannot write {}", .path.display())]
    Write {
        /// What was being written.
        path: PathBuf,
        /// What the writer said.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The system said no.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

impl Queue {
    /// Opens the folder, creating it and its marker `.nestd-queue` if they are not there.
    pub fn open(dir: impl Into<PathBuf>) -> Result<Self, QueueError> {
        Ok(Self { dir: dir.into(), id: String::new() })
    }

    /// The random id in its marker: goes into the build's row, so that a replaced folder is noticed.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Where it is.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Where a file stands while it is staged: `.<name>.part`.
    pub fn staged_path(&self, name: &str) -> PathBuf {
        self.dir.join(format!(".{name}.part"))
    }

    /// Where a file stands once it is published.
    pub fn published_path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    /// Writes a file under its dot-name and fsyncs it and the folder. Sidecars of a build (same stem, another suffix)
    /// are staged likewise, and published with it. Replaces what was staged under that name; never touches what is
    /// published. Returns the path of the dot-file.
    pub fn stage<E>(&self, name: &str, _write: impl FnOnce(&mut File) -> Result<(), E>) -> Result<PathBuf, QueueError>
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        Ok(self.staged_path(name))
    }

    /// Publishes a staged build by one rename that overwrites nothing, after its sidecars; on disk when it returns.
    /// Safe to repeat.
    pub fn publish(&self, _build_name: &str) -> Result<Published, QueueError> {
        Ok(Published::Before)
    }

    /// Where a build file is, for recovery.
    pub fn state(&self, _build_name: &str) -> Result<StagedState, QueueError> {
        Ok(StagedState::Gone)
    }

    /// Removes a staged build and its sidecars, published ones too if the build itself is not. A published build is
    /// left alone. Returns whether there was a staged build.
    pub fn discard(&self, _build_name: &str) -> Result<bool, QueueError> {
        Ok(false)
    }

    /// Removes dot-files of our pattern whose build is not in `keep`. Returns their names.
    pub fn sweep(&self, _keep: &[String]) -> Result<Vec<String>, QueueError> {
        Ok(Vec::new())
    }
}
