//! Options of the build file, since printers differ.

use serde::{Deserialize, Serialize};

/// How copies of one mesh are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InstanceSharing {
    /// One object for all copies.
    #[default]
    Shared,
    /// One object per copy, for readers that handle shared objects wrongly.
    Expanded,
}

/// Whether a consumer may rearrange the placements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arrangement {
    /// One build item per placement.
    #[default]
    Items,
    /// One object made of components, which a consumer must not move relative to each other.
    Locked,
}
