//! Causes of refusals as an enum. Reasons are sentences for people and cannot be counted.

use serde::{Deserialize, Serialize};

use super::text_column::own_word;

/// The cause of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RefusalCause {
    /// The file is not STL or 3MF, or is truncated.
    Format,
    /// The mesh is not closed.
    NotClosed,
    /// The part does not fit into the machine.
    TooLarge,
    /// The file exceeds one of the `[limits]`.
    Limit,
    /// The ticket or list is invalid, or matches no part.
    Ticket,
    /// The machine refuses files that were dropped before.
    Duplicate,
    /// nestd may not read it, or it is not a file.
    Unreadable,
    /// nestd failed to process it.
    Failure,
    /// Somebody cancelled it.
    Cancelled,
    /// A newer revision took its place.
    Replaced,
    /// Any other cause.
    Other,
}

own_word!(RefusalCause);

impl RefusalCause {
    /// Whether a person wanted it so: nobody must see to it.
    pub fn is_intended(self) -> bool {
        matches!(self, Self::Cancelled | Self::Replaced)
    }

    /// All causes.
    pub const ALL: [Self; 11] = [
        Self::Format,
        Self::NotClosed,
        Self::TooLarge,
        Self::Limit,
        Self::Ticket,
        Self::Duplicate,
        Self::Unreadable,
        Self::Failure,
        Self::Cancelled,
        Self::Replaced,
        Self::Other,
    ];
}
