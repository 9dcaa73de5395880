//! Why a queue folder did not do what it was asked.

use std::{io, path::PathBuf};

use rustix::io::Errno;
use thiserror::Error;

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

impl QueueError {
    /// Whether publishing failed so that the build was certainly not renamed, and will not be: a share whose answer was lost
    /// may still do what it was asked.
    pub fn is_certainly_unpublished(&self) -> bool {
        let refusals = [Errno::ACCESS, Errno::PERM, Errno::ROFS, Errno::NOSPC, Errno::DQUOT];
        match self {
            Self::Unavailable { .. } | Self::BadName(_) | Self::NameTaken(_) | Self::Write { .. } => true,
            Self::Io { what: "publish", source, .. } => {
                refusals.iter().any(|refusal| source.raw_os_error() == Some(refusal.raw_os_error()))
            }
            Self::Io { .. } => false,
        }
    }
}
