//! What recording a claim has made of it.

use crate::PartId;

/// Result of recording a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedPart {
    /// The part.
    pub id: PartId,
    /// What the claim is.
    pub outcome: RecordedAs,
}

/// What a claim is that was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedAs {
    /// A new part, which is read next.
    New,
    /// A new part that took the place of earlier ones, with what was asked with them. It is read next.
    Revision,
    /// A new part whose line was cancelled before: it is refused.
    NewAndCancelled,
    /// A part that was recorded before.
    Known,
    /// The file of a part that was asked for once more. It is no order.
    Replacement,
}

impl RecordedPart {
    /// Whether the claim was new.
    pub fn is_new(&self) -> bool {
        matches!(self.outcome, RecordedAs::New | RecordedAs::Revision | RecordedAs::NewAndCancelled)
    }
}
