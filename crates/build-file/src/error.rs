//! Why a file cannot be read or written. The farm puts these sentences into `<name>.reason.txt`.

use std::io;

use solids::MeshError;
use thiserror::Error;

/// Why a dropped file or a build file cannot be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The disk failed, not the file: worth another try.
    #[error("cannot read the file")]
    Io(#[from] io::Error),
    /// Neither STL nor 3MF.
    #[error("is no STL or 3MF file: {what}")]
    Unknown {
        /// What it looks like.
        what: String,
        /// What gives a file that can be read; a sentence.
        remedy: &'static str,
    },
    /// The file ends before its content does.
    #[error("the file is truncated: {0}")]
    Truncated(String),
    /// A rule of the file format is broken; says where.
    #[error("is not valid {format}: {reason}")]
    Invalid {
        /// `STL` or `3MF`.
        format: &'static str,
        /// What is wrong and where.
        reason: String,
    },
    /// Valid, but it asks for something that is not supported.
    #[error("{what}")]
    Unsupported {
        /// What it asks for.
        what: String,
        /// What gives a file that can be read; a sentence.
        remedy: &'static str,
    },
    /// A limit is passed.
    #[error("{what}; at most {limit} are taken (limits.{key})")]
    TooLarge {
        /// What was counted.
        what: String,
        /// The limit of [`super::Limits`] that it passes.
        limit: u64,
        /// Its name in the configuration.
        key: &'static str,
    },
    /// A surface that is no solid.
    #[error("{name} is no solid")]
    NoSolid {
        /// Object or solid.
        name: String,
        /// Why.
        #[source]
        source: MeshError,
    },
}

impl ReadError {
    /// Whether the disk failed rather than the file: a second try may help.
    pub fn is_io(&self) -> bool {
        matches!(self, Self::Io(_))
    }

    /// What to do about it; a sentence, "" where it is not for the one who dropped the file.
    pub fn remedy(&self) -> String {
        let text = match self {
            Self::Io(_) => "",
            Self::Unknown { remedy, .. } | Self::Unsupported { remedy, .. } => remedy,
            Self::Truncated(_) => {
                "Copy the whole file once more; where the original is cut off too, export it from the CAD program again."
            }
            Self::Invalid { .. } => "Export it again from the CAD program, as binary STL or 3MF.",
            Self::TooLarge { key, .. } => {
                return format!(
                    "Make it smaller, or drop it in several files; or raise limits.{key} in the configuration, reload nestd \
                     and drop the file again."
                );
            }
            Self::NoSolid { source: MeshError::Empty, .. } => {
                "There is nothing to print in it: export the part itself, as a solid or closed mesh."
            }
            Self::NoSolid { source: MeshError::NoVolume, .. } => {
                "A surface without thickness cannot be printed: give it a thickness in the CAD program and export it again."
            }
            Self::NoSolid { .. } => "Export it again from the CAD program, as binary STL or 3MF.",
        };
        text.to_owned()
    }

    pub(super) fn stl(reason: impl Into<String>) -> Self {
        Self::Invalid { format: "STL", reason: reason.into() }
    }

    pub(super) fn threemf(reason: impl Into<String>) -> Self {
        Self::Invalid { format: "3MF", reason: reason.into() }
    }
}

/// Why a file could not be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The disk failed.
    #[error("cannot write")]
    Io(#[from] io::Error),
    /// The package could not be put together.
    #[error("cannot write the package: {0}")]
    Package(String),
    /// The description makes no sense.
    #[error("the build makes no sense: {0}")]
    Build(String),
}
