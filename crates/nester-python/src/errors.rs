//! Errors as Python exceptions. The classes are defined in Python (`nestd_nester._errors`).

use std::{error::Error, io, path::Path};

use build_file::{FileReadError, FileWriteError};
use pyo3::{PyErr, exceptions::PyOSError};
use serde::{
    Deserialize,
    de::{
        IntoDeserializer,
        value::{Error as WordError, StrDeserializer},
    },
};
use solids::MeshError;

mod imported {
    #![allow(missing_docs)] // the macro writes the documentation of the types, not of what it makes for them
    pyo3::import_exception!(nestd_nester._errors, InputError);
    pyo3::import_exception!(nestd_nester._errors, ProofError);
}
pub(crate) use imported::{InputError, ProofError};

/// `OSError` of a path; Python makes `FileNotFoundError` and the like of its number.
pub(crate) fn os_error(error: &io::Error, path: &Path) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            let text = error.to_string();
            let text = text.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((number, text, path.as_os_str().to_owned()))
        }
        None => io::Error::new(error.kind(), format!("{}: {error}", path.display())).into(),
    }
}

/// A part file that cannot be read.
pub(crate) fn read_error(error: &FileReadError, path: &Path) -> PyErr {
    let remedy = match error {
        FileReadError::Io(source) => return os_error(source, path),
        FileReadError::TooLarge { .. } => "Make it smaller, or split it into several files.".to_owned(),
        // The reader speaks to people who drop files into a folder.
        other => other.remedy().replace("drop", "give").replace("Drop", "Give").replace(" in a ticket", ""),
    };
    InputError::new_err(format!("{}: {}. {remedy}", path.display(), with_causes(error)).trim_end().to_owned())
}

/// A build file that cannot be written.
pub(crate) fn write_error(error: &FileWriteError, path: &Path) -> PyErr {
    match error {
        FileWriteError::Io(source) => os_error(source, path),
        other => InputError::new_err(format!("{}: {}.", path.display(), with_causes(other))),
    }
}

/// Arrays that are no solid; `name` is that of the part.
pub(crate) fn mesh_error(error: &MeshError, name: &str) -> PyErr {
    let remedy = match error {
        MeshError::Empty => "Give at least one triangle with an area.",
        MeshError::NotFinite { .. } => "Remove NaN and infinite coordinates.",
        MeshError::BadIndex { .. } => "Give faces as rows of three indices into the vertices, from 0.",
        MeshError::NoVolume => "A surface without thickness cannot be packed: give it a thickness.",
        _ => "Repair the mesh.",
    };
    InputError::new_err(format!("{name}: {error}. {remedy}"))
}

/// An error with all that has caused it.
pub(crate) fn with_causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

/// One of the words that serde reads for a type; `what` is the name of the argument.
pub(crate) fn parse_word<'de, T: Deserialize<'de>>(what: &str, word: &'de str) -> Result<T, PyErr> {
    let words: StrDeserializer<'de, WordError> = word.into_deserializer();
    T::deserialize(words).map_err(|error| InputError::new_err(format!("{what}={word:?}: {error}.")))
}
