//! Where one copy stands.

use serde::{Deserialize, Serialize};
use solids::Pose;

/// One copy of an item at a pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Index into the instance's items.
    pub item: usize,
    /// Copy number, from 0.
    pub copy: u32,
    /// Where it stands: mesh frame -> build frame.
    pub pose: Pose,
}
