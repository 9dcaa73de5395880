//! Which rotations a part may have, in the words that settings and tickets use.

use serde::{Deserialize, Serialize};

/// Which rotations a part may have. A hard rule, checked again on the written file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OrientationRule {
    /// Any rotation.
    #[default]
    Free,
    /// Rotations about z only: the part's up direction stays up.
    Upright,
    /// The 24 rotations that map axes onto axes.
    Axis,
    /// Orientation as in the dropped file; translations only.
    Fixed,
}
