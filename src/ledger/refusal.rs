//! Why something is refused, as one of few words: reasons are sentences for people, and nothing can be counted by them.

use serde::{Deserialize, Serialize};

use super::word::own_word;

/// A kind of reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// It is no STL or 3MF file, or a torn one.
    Format,
    /// Its surface is no solid.
    NotClosed,
    /// It does not fit into the machine.
    TooLarge,
    /// It is beyond one of the `[limits]`.
    Limit,
    /// What is said about it cannot be understood, or speaks of no part.
    Ticket,
    /// The profile takes no file twice.
    Duplicate,
    /// nestd may not read it, or it is no file.
    Unreadable,
    /// nestd failed on it.
    Failure,
    /// Somebody has taken it out of the farm.
    Cancelled,
    /// A reason of its own.
    Other,
}

own_word!(Refusal);

impl Refusal {
    /// Every kind.
    pub const ALL: [Self; 10] = [
        Self::Format,
        Self::NotClosed,
        Self::TooLarge,
        Self::Limit,
        Self::Ticket,
        Self::Duplicate,
        Self::Unreadable,
        Self::Failure,
        Self::Cancelled,
        Self::Other,
    ];
}
