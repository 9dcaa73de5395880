//! Errors of reading and writing files. The farm writes these sentences into `<name>.reason.txt`.

use std::io;

use solids::MeshError;
use thiserror::Error;

use super::{
    file_name::{MESH_FORMATS, cad_formats},
    limits::ReadLimits,
};

/// Why a dropped file or a build file cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileReadError {
    /// The disk failed, not the file: another try may succeed.
    #[error("cannot read the file")]
    Io(#[from] io::Error),
    /// None of the formats that are read.
    #[error("is no {MESH_FORMATS} file: {what}")]
    Unknown {
        /// What the file looks like.
        what: String,
        /// How to get a readable file; a sentence.
        remedy: &'static str,
    },
    /// The file ends before its content does.
    #[error("the file is truncated: {0}")]
    Truncated(String),
    /// A rule of the file format is broken; names the place.
    #[error("is not valid {format}: {reason}")]
    Invalid {
        /// As people call it: `STL`, `3MF`.
        format: &'static str,
        /// What is wrong and where.
        reason: String,
    },
    /// Valid, but it needs a feature that is not supported.
    #[error("{what}")]
    Unsupported {
        /// The feature.
        what: String,
        /// How to get a readable file; a sentence.
        remedy: &'static str,
    },
    /// A limit is exceeded.
    #[error("{what}; at most {limit} are allowed (limits.{key})")]
    TooLarge {
        /// What was counted.
        what: String,
        /// The value of the exceeded limit in [`crate::ReadLimits`].
        limit: u64,
        /// Its name in the configuration.
        key: &'static str,
    },
    /// A surface that is not a solid.
    #[error("{name} is no solid")]
    NoSolid {
        /// Name of the object or solid.
        name: String,
        /// Why.
        #[source]
        source: MeshError,
    },
}

impl FileReadError {
    /// Whether the disk failed rather than the file: another try may succeed.
    pub fn is_io(&self) -> bool {
        matches!(self, Self::Io(_))
    }

    /// The remedy, as a sentence; empty if the person who dropped the file can do nothing.
    pub fn remedy(&self) -> String {
        let text = match self {
            Self::Io(_) => "",
            Self::Unknown { remedy, .. } | Self::Unsupported { remedy, .. } => remedy,
            Self::Truncated(_) => {
                "Copy the whole file once more; where the original is cut off too, export it from the CAD program again."
            }
            Self::Invalid { .. } => concat!("Export it again from the CAD program, as binary ", cad_formats!(), "."),
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
            Self::NoSolid { .. } => concat!("Export it again from the CAD program, as binary ", cad_formats!(), "."),
        };
        text.to_owned()
    }

    pub(crate) fn invalid_stl(reason: impl Into<String>) -> Self {
        Self::Invalid { format: "STL", reason: reason.into() }
    }

    /// More triangles than `limits` has.
    pub(crate) fn too_many_triangles(limits: &ReadLimits) -> Self {
        let what = "it has too many triangles".to_owned();
        Self::TooLarge { what, limit: limits.max_triangles, key: "max_triangles" }
    }

    pub(crate) fn invalid_threemf(reason: impl Into<String>) -> Self {
        Self::Invalid { format: "3MF", reason: reason.into() }
    }
}

/// Why a file could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileWriteError {
    /// The disk failed.
    #[error("cannot write")]
    Io(#[from] io::Error),
    /// The package could not be put together.
    #[error("cannot write the package: {0}")]
    Package(String),
    /// The build description is inconsistent.
    #[error("the build description is invalid: {0}")]
    Build(String),
}
