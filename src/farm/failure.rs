//! Why a step failed, and whose fault it is: the file's, the store's or the disk's.

use std::path::PathBuf;

use build_file::ReadError;

use super::owner::OwnerError;
use crate::{ledger::Refusal, queue::QueueError};

/// Why a file gave no meshes.
#[derive(Debug, thiserror::Error)]
pub enum Unread {
    /// It cannot be read; whole sentences for the technician.
    #[error("{1}")]
    Refused(Refusal, String),
    /// The disk failed, not the file.
    #[error("{0}")]
    Later(String),
}

impl Unread {
    /// What a reader's error says of a file.
    pub fn of(name: &str, error: &ReadError) -> Self {
        match error.is_io() {
            true => Self::Later(chain(error)),
            // What it quotes of the file is for people.
            false => {
                let reason = format!("{name}: {}. {}", build_file::visible(&chain(error)), error.remedy());
                Self::Refused(kind_of(error), reason)
            }
        }
    }
}

/// The stored file of a part does not hold what was dropped: only the same file, dropped again, helps.
#[derive(Debug, thiserror::Error)]
#[error(
    "the stored file of {name} {}",
    aside.as_ref().map_or("is not there".to_owned(), |aside| format!("was damaged and is set aside as {}", aside.display()))
)]
pub struct Lost {
    /// Name of the part.
    pub name: String,
    /// Whose bytes are lost.
    pub content_hash: String,
    /// Where the damaged file is now; `None` = there was none.
    pub aside: Option<PathBuf>,
}

impl Lost {
    /// The lost file that a failure is about.
    pub fn of(failure: &anyhow::Error) -> Option<&Self> {
        failure.chain().find_map(|cause| cause.downcast_ref())
    }
}

/// Whether a disk or a share failed, not what was to be done on it: trying again will help once that is mended.
pub fn is_of_the_disk(failure: &anyhow::Error) -> bool {
    failure.chain().any(|cause| {
        let io = cause.downcast_ref::<std::io::Error>();
        let queue = cause.downcast_ref::<QueueError>();
        io.is_some_and(|e| e.raw_os_error().is_some() || e.kind() == std::io::ErrorKind::WriteZero)
            || matches!(cause.downcast_ref(), Some(Unread::Later(_)))
            || matches!(queue, Some(QueueError::Unavailable { .. }))
            || cause.is::<OwnerError>()
    })
}

/// What kind of reason it is that a file cannot be read.
fn kind_of(error: &ReadError) -> Refusal {
    match error {
        ReadError::TooLarge { .. } => Refusal::Limit,
        ReadError::NoSolid { .. } => Refusal::NotClosed,
        ReadError::Io(_) => Refusal::Unreadable,
        ReadError::Unknown { .. }
        | ReadError::Truncated(_)
        | ReadError::Invalid { .. }
        | ReadError::Unsupported { .. } => Refusal::Format,
    }
}

/// An error with its sources in one line.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text.push_str(&format!(": {error}"));
        source = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_of_the_disk_and_a_wrong_build_is_not() {
        let full = std::io::Error::from_raw_os_error(28);
        let write = crate::queue::QueueError::Write { path: "x".into(), source: full.into() };
        assert!(is_of_the_disk(&anyhow::Error::from(write).context("writing the build")));
        assert!(!is_of_the_disk(&anyhow::anyhow!("the written build is not proved")));
    }
}
