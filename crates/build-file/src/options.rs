//! Choices for the build file that printers differ in.

use serde::{Deserialize, Serialize};

/// How copies of one mesh are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Instances {
    /// One object for all copies.
    #[default]
    Shared,
    /// One object per copy, for readers that get shared objects wrong.
    Expanded,
}

/// Whether a consumer may re-arrange the placements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arrangement {
    /// One build item per placement.
    #[default]
    Items,
    /// One object made of components, which nobody may move against each other.
    Locked,
}
