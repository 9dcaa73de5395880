//! What can be told to others.

use serde::{Deserialize, Serialize};

/// What can be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Told {
    /// A build is in the queue.
    Published,
    /// A part or a file was refused.
    Refused,
    /// A machine is unavailable, or available again.
    Unavailable,
    /// A due date will not be met, or is near and its machine is unavailable or paused.
    AtRisk,
}
