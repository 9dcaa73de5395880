//! Which rotations a part may have, as people say it.

use serde::{Deserialize, Serialize};

/// Which rotations a part may have. A hard rule, checked again on the written file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OrientationRule {
    /// Any rotation.
    #[default]
    Free,
    /// Rotations about z only: what was up stays up.
    Upright,
    /// The 24 rotations that map axes onto axes.
    Axis,
    /// As dropped; translations only.
    Fixed,
}
