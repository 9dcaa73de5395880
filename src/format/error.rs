//! Why a file cannot be read or written. The farm puts these sentences into `<name>.reason.txt`.

use std::io;

use thiserror::Error;

use crate::geometry::MeshError;

/// Why a dropped file or a build file cannot be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The disk failed, not the file: worth another try.
    #[error("cannot read the file")]
    Io(#[from] io::Error),
    /// Neither STL nor 3MF; says what it looks like.
    #[error("is no STL or 3MF file: {0}")]
    Unknown(String),
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
    #[error("{0}")]
    Unsupported(String),
    /// A limit is passed.
    #[error("too large: {what} is more than {limit}")]
    TooLarge {
        /// What was counted.
        what: String,
        /// The limit of [`super::Limits`] that it passes.
        limit: u64,
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
