//! Orders by hand to the daemon, which answers in the row; so they work from another server too.

use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{CommandId, PartId, Utc, word::own_word};

/// What is ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandKind {
    /// Publish what waits in a profile now.
    Flush,
    /// Fire no batch in a profile until it is resumed.
    Pause,
    /// Let a profile fire again.
    Resume,
    /// Take a rejected part back.
    Retry,
    /// Reject a waiting part.
    Cancel,
    /// Look into the hot folders now.
    Scan,
}

own_word!(CommandKind);

/// Where an order stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandState {
    /// Not answered yet.
    Asked,
    /// Done.
    Done,
    /// Refused; the answer says why.
    Refused,
}

own_word!(CommandState);

/// An order to give.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewCommand {
    /// What.
    pub kind: CommandKind,
    /// Machine profile of flush, pause and resume, "" otherwise.
    pub profile: String,
    /// Part of retry and cancel.
    pub part: Option<PartId>,
    /// user@host.
    pub asked_by: String,
}

/// An order as it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct CommandRow {
    /// Its number.
    pub id: CommandId,
    /// What.
    pub kind: CommandKind,
    /// Machine profile, "" = none.
    pub profile: String,
    /// Part of retry and cancel.
    pub part_id: Option<PartId>,
    /// user@host.
    pub asked_by: String,
    /// When.
    pub asked_at: Utc,
    /// Where it stands.
    pub state: CommandState,
    /// What the daemon answered.
    pub answer: String,
    /// When it answered.
    pub answered_at: Option<Utc>,
}
