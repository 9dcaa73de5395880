//! Kinds of events that are sent to receivers.

use serde::{Deserialize, Serialize};

/// A kind of event that can be sent to receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotificationKind {
    /// A build is in the queue.
    Published,
    /// A part or a file was refused.
    Refused,
    /// A machine is unavailable, or available again.
    Unavailable,
    /// A due date will not be met, or is near and its machine is unavailable or paused.
    AtRisk,
    /// Every copy of an order was printed well.
    OrderComplete,
    /// An order ended with fewer copies than were wanted.
    OrderShort,
    /// Copies left the open build for others that go first.
    PutOut,
    /// Copies of the highest priority find no place in the next build.
    NoRoom,
    /// Something needs a person.
    Alert,
}

impl NotificationKind {
    /// Every kind.
    pub const ALL: [Self; 9] = [
        Self::Published,
        Self::Refused,
        Self::Unavailable,
        Self::AtRisk,
        Self::OrderComplete,
        Self::OrderShort,
        Self::PutOut,
        Self::NoRoom,
        Self::Alert,
    ];
}
