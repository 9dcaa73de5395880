//! Causes of failures: the file, the store or the disk.

use std::{fmt, path::PathBuf};

use build_file::FileReadError;
use delivery::queue::QueueError;
use ledger::{PartId, PartRow, RefusalCause};

use crate::leases::folder_lease::LeaseError;

/// Why a file could not be read into meshes.
#[derive(Debug, thiserror::Error)]
pub enum PartReadError {
    /// The file cannot be read; whole sentences for the technician.
    #[error("{1}")]
    Refused(RefusalCause, String),
    /// The disk failed, not the file.
    #[error("{0}")]
    TryLater(String),
}

impl PartReadError {
    /// Converts a reader's error for a file.
    pub fn from_read_error(name: &str, error: &FileReadError) -> Self {
        match error.is_io() {
            true => Self::TryLater(error_chain(error)),
            // The error may quote bytes of the file, which are made printable.
            false => {
                let reason =
                    format!("{name}: {}. {}", build_file::escape_invisible(&error_chain(error)), error.remedy());
                match refusal_kind(error) {
                    RefusalCause::Format if intake::is_document(name) => Self::Refused(RefusalCause::Document, reason),
                    cause => Self::Refused(cause, reason),
                }
            }
        }
    }
}

/// The stored file of a part differs from the file that was dropped: only dropping the same file again helps.
#[derive(Debug, thiserror::Error)]
#[error(
    "the stored file of {name} {}",
    aside.as_ref().map_or("is not there".to_owned(), |aside| format!("was damaged and is set aside as {}", aside.display()))
)]
pub struct LostFileError {
    /// Name of the part.
    pub name: String,
    /// Hash of the lost content.
    pub content_hash: String,
    /// Where the damaged file is now; `None` = there was no file.
    pub aside: Option<PathBuf>,
}

impl LostFileError {
    /// The lost file that caused a failure, if any.
    pub fn find_in_chain(failure: &anyhow::Error) -> Option<&Self> {
        failure.chain().find_map(|cause| cause.downcast_ref())
    }
}

/// The file of a part was read in another size than the first time. It is not printed until a person says what is right.
#[derive(Debug, thiserror::Error)]
#[error("{name} was {told_mm:?} mm when it was first read, and is {found_mm:?} mm now")]
pub struct SizeDiffersError {
    /// The part.
    pub part: PartId,
    /// Its name.
    pub name: String,
    /// Its size when it was first read, mm.
    pub told_mm: [f64; 3],
    /// Its size now, mm.
    pub found_mm: [f64; 3],
}

/// The mesh of a part is not mended now as it was when it was first read. It is not printed until a person says so.
#[derive(Debug, thiserror::Error)]
#[error("the mesh of {name} is not mended now as it was when it was first read")]
pub struct MendDiffersError {
    /// The part.
    pub part: PartId,
    /// Its name.
    pub name: String,
}

/// A part in which a failure lies, not in what was done with it: it waits for a person, and everything else goes on without it.
#[derive(Debug)]
pub enum PartFault<'a> {
    /// Its stored file is lost.
    Lost(&'a LostFileError),
    /// It has another size.
    SizeDiffers(&'a SizeDiffersError),
    /// It is mended otherwise.
    MendDiffers(&'a MendDiffersError),
}

impl fmt::Display for PartFault<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost(lost) => lost.fmt(f),
            Self::SizeDiffers(differs) => differs.fmt(f),
            Self::MendDiffers(differs) => differs.fmt(f),
        }
    }
}

impl<'a> PartFault<'a> {
    /// The part that caused a failure, if one did.
    pub fn find_in_chain(failure: &'a anyhow::Error) -> Option<Self> {
        let lost = LostFileError::find_in_chain(failure).map(Self::Lost);
        lost.or_else(|| failure.chain().find_map(|cause| cause.downcast_ref()).map(Self::SizeDiffers))
            .or_else(|| failure.chain().find_map(|cause| cause.downcast_ref()).map(Self::MendDiffers))
    }

    /// Whether a part is meant.
    pub fn is_of(&self, part: &PartRow) -> bool {
        match self {
            Self::Lost(lost) => part.file.content_hash == lost.content_hash,
            Self::SizeDiffers(differs) => part.id == differs.part,
            Self::MendDiffers(differs) => part.id == differs.part,
        }
    }
}

/// Whether a disk or a share failed, not the operation itself: a retry helps once the disk works again.
pub fn is_disk_failure(failure: &anyhow::Error) -> bool {
    failure.chain().any(|cause| {
        let io = cause.downcast_ref::<std::io::Error>();
        let queue = cause.downcast_ref::<QueueError>();
        io.is_some_and(|e| e.raw_os_error().is_some() || e.kind() == std::io::ErrorKind::WriteZero)
            || matches!(cause.downcast_ref(), Some(PartReadError::TryLater(_)))
            || matches!(queue, Some(QueueError::Unavailable { .. }))
            || cause.is::<LeaseError>()
    })
}

/// The kind of refusal for a reader's error.
fn refusal_kind(error: &FileReadError) -> RefusalCause {
    match error {
        FileReadError::TooLarge { .. } => RefusalCause::Limit,
        FileReadError::NoSolid { .. } => RefusalCause::NotClosed,
        FileReadError::Io(_) => RefusalCause::Unreadable,
        // Unknown, truncated, invalid, unsupported.
        _ => RefusalCause::Format,
    }
}

/// An error and its sources on one line.
pub fn error_chain(error: &dyn std::error::Error) -> String {
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
        let write = delivery::queue::QueueError::Write { path: "x".into(), source: full.into() };
        assert!(is_disk_failure(&anyhow::Error::from(write).context("writing the build")));
        assert!(!is_disk_failure(&anyhow::anyhow!("the written build is not proved")));
    }
}
