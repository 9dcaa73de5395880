//! Why a material cannot be loaded, or a part cannot be made of it.

use thiserror::Error;

use crate::PartId;

/// Why a material cannot be loaded, or a part cannot be made of it.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum MaterialError {
    /// The settings name the materials of the farm, and not this one.
    #[error(
        "[materials] in nestd.toml does not name '{word}', only {known}: use one of these, or add it there and reload nestd"
    )]
    Unknown {
        /// The word that was used.
        word: String,
        /// The materials that are named there.
        known: String,
    },
    /// There is no such machine.
    #[error("there is no machine '{0}' here")]
    NoMachine(String),
    /// The machine has another material loaded, or none.
    #[error(
        "part {part} is of {material}, which is not loaded on {machine}; `nestd machine load {machine} '{material}'` says that it is"
    )]
    NotLoaded {
        /// The part.
        part: PartId,
        /// Its material.
        material: String,
        /// Its machine.
        machine: String,
    },
}
