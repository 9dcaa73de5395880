//! The pose of one copy.

use serde::{Deserialize, Serialize};
use solids::Pose;

/// One copy of an item at a pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ItemPlacement {
    /// Index into the instance's items.
    pub item: usize,
    /// Copy number, from 0.
    pub copy: u32,
    /// Pose: mesh frame -> build frame.
    pub pose: Pose,
}
