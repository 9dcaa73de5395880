//! The line of waiting copies, in order of precedence.

use super::PartRow;

/// A waiting part with those of its copies that are in no build.
#[derive(Debug, Clone, PartialEq)]
pub struct WaitingPart {
    /// The part.
    pub part: PartRow,
    /// Its copies that wait, ascending, at least one.
    pub copies: Vec<u32>,
}
