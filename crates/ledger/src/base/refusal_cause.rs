//! Causes of refusals as an enum. Reasons are sentences for people and cannot be counted.

use language::say;
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
    /// The mesh is not closed, and could be mended if somebody says so.
    Mendable,
    /// The part does not fit into the machine.
    TooLarge,
    /// The file exceeds one of the `[limits]`.
    Limit,
    /// The ticket or list is invalid, or matches no part.
    Ticket,
    /// It is a document or a picture, which comes with parts and is none.
    Document,
    /// A list names it, and its file never came.
    Missing,
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

    /// The cause in a few words, in the language that is current.
    pub fn text(self) -> String {
        match self {
            Self::Format => say!("cause-format"),
            Self::NotClosed => say!("cause-not-closed"),
            Self::Mendable => say!("cause-mendable"),
            Self::TooLarge => say!("cause-too-large"),
            Self::Limit => say!("cause-limit"),
            Self::Ticket => say!("cause-ticket"),
            Self::Document => say!("cause-document"),
            Self::Missing => say!("cause-missing"),
            Self::Duplicate => say!("cause-duplicate"),
            Self::Unreadable => say!("cause-unreadable"),
            Self::Failure => say!("cause-failure"),
            Self::Cancelled => say!("cause-cancelled"),
            Self::Replaced => say!("cause-replaced"),
            Self::Other => say!("cause-other"),
        }
    }

    /// A reason in the language that is current. One that the catalogs do not know is English, and has its cause before it.
    pub fn introduce(cause: Option<Self>, reason: &str) -> String {
        match (language::retold(reason), cause) {
            (Some(told), _) => told,
            (None, Some(cause)) => say!("cause-and-reason", cause = cause.text(), reason = reason),
            (None, None) => reason.to_owned(),
        }
    }

    /// All causes.
    pub const ALL: [Self; 14] = [
        Self::Format,
        Self::NotClosed,
        Self::Mendable,
        Self::TooLarge,
        Self::Limit,
        Self::Ticket,
        Self::Document,
        Self::Missing,
        Self::Duplicate,
        Self::Unreadable,
        Self::Failure,
        Self::Cancelled,
        Self::Replaced,
        Self::Other,
    ];
}
