//! Errors of a queue folder.

use std::{io, path::PathBuf};

use rustix::io::Errno;
use thiserror::Error;

/// Why an operation on a queue folder failed.
#[derive(Debug, Error)]
pub enum QueueError {
    /// The folder or its marker is missing, or the marker is another one: it was unmounted or replaced.
    #[error("the queue folder {} is unavailable: {why}", .dir.display())]
    Unavailable {
        /// The folder.
        dir: PathBuf,
        /// The reason in plain words.
        why: String,
    },
    /// Not a valid file name in the queue.
    #[error("{0:?} is not a valid name for a file in the queue")]
    InvalidName(String),
    /// Another file with that name is in the queue; nothing was overwritten.
    #[error("{} is another file and has the name of the build: take it out", .0.display())]
    NameTaken(PathBuf),
    /// The writer failed; no file is left behind.
    #[error("cannot write {}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the writer.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A system call failed.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// The operation.
        what: &'static str,
        /// The path.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

impl QueueError {
    /// Whether publishing failed in a way that certainly did not rename the build and will not do so later. A share
    /// that did not answer may still carry out the rename.
    pub fn is_certainly_unpublished(&self) -> bool {
        let refusals = [Errno::ACCESS, Errno::PERM, Errno::ROFS, Errno::NOSPC, Errno::DQUOT];
        match self {
            Self::Unavailable { .. } | Self::InvalidName(_) | Self::NameTaken(_) | Self::Write { .. } => true,
            Self::Io { what: "publish", source, .. } => {
                refusals.iter().any(|refusal| source.raw_os_error() == Some(refusal.raw_os_error()))
            }
            Self::Io { .. } => false,
        }
    }
}
