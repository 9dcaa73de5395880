//! The two state machines of the farm. Each state is an enum, changed by one function. The `CHECK` constraints of the
//! schema list the same words; a test compares both.
//!
//! A new state is a variant and its moves here, an [`EventKind`](crate::EventKind), a migration of the `CHECK`, its words in the catalogs of
//! `language`, and its place in the diagram of ARCHITECTURE.md. The compiler finds each `match`; what names states in SQL does not
//! tell: look for `state IN`, `state =` and `matches!`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{id::BuildId, text_column::own_word};

/// State of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PartState {
    /// Taken from the hot folder, not read yet.
    Claimed,
    /// Read; at least one copy is in no build.
    Waiting,
    /// Every copy is in a build; not all of these builds are published.
    Batched,
    /// Every copy is in a published build.
    Built,
    /// Refused or cancelled, with a reason. It can be retried.
    Refused,
}

/// State of a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BuildState {
    /// Collects the waiting parts of its machine. Its layout is a forecast and reserves no copy.
    Open,
    /// Its copies are taken; the final search runs.
    Nesting,
    /// The build file is written and proved; it is not in the queue yet.
    Verified,
    /// The build file has been put into the printer's queue.
    Published,
    /// The machine prints it.
    Printing,
    /// Printed.
    Complete,
    /// The machine stopped before the end.
    Interrupted,
    /// Nesting failed (never published), or somebody reported that the print failed (published).
    Failed,
}

/// A transition that the state machine does not allow.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("a {thing} that is {from} cannot become {to}")]
pub struct IllegalMove {
    /// "part" or "build".
    pub thing: &'static str,
    /// Current state.
    pub from: String,
    /// Requested state.
    pub to: String,
}

impl PartState {
    /// All states, in the order of a part's life.
    pub const ALL: [Self; 5] = [Self::Claimed, Self::Waiting, Self::Batched, Self::Built, Self::Refused];

    /// The only function that changes the state of a part.
    pub fn move_to(self, next: Self) -> Result<Self, IllegalMove> {
        use PartState::*;
        match (self, next) {
            (Claimed, Waiting | Refused) => Ok(next),
            (Waiting, Batched | Refused) => Ok(next),
            // A unit that was said later, or another machine, has it read again.
            (Waiting, Claimed) => Ok(next),
            (Batched, Waiting | Built) => Ok(next),
            // Copies of it were printed badly, or more are wanted.
            (Built, Waiting) => Ok(next),
            (Refused, Claimed) => Ok(next),
            _ => Err(IllegalMove { thing: "part", from: self.to_string(), to: next.to_string() }),
        }
    }

    /// Whether the part still needs its stored file.
    pub fn is_live(self) -> bool {
        matches!(self, Self::Claimed | Self::Waiting | Self::Batched)
    }
}

impl BuildState {
    /// All states, in the order of a build's life.
    pub const ALL: [Self; 8] = [
        Self::Open,
        Self::Nesting,
        Self::Verified,
        Self::Published,
        Self::Printing,
        Self::Complete,
        Self::Interrupted,
        Self::Failed,
    ];

    /// What is answered to an outcome of a build in this state, whose outcome was told before.
    pub(crate) fn told_already(self, asked: Self, build: BuildId) -> String {
        let recorded = format!("the outcome of build {build} is recorded as {self} already");
        match self {
            Self::Failed | Self::Printing if self == asked => format!("{recorded}, so nothing was changed"),
            _ if self == asked => format!(
                "{recorded}, so nothing was changed; if other copies of it are bad, say `nestd outcome {build} {asked} --correct --bad PART=N`"
            ),
            _ => format!("{recorded}; if that is wrong, say `nestd outcome {build} {asked} --correct`"),
        }
    }

    /// Whether its search is over, so that it stands in the history.
    pub fn is_past_nesting(self) -> bool {
        !matches!(self, Self::Open | Self::Nesting)
    }

    /// The only function that changes the state of a build.
    pub fn move_to(self, next: Self) -> Result<Self, IllegalMove> {
        use BuildState::*;
        match (self, next) {
            (Open, Nesting) => Ok(next),
            (Nesting, Verified | Failed) => Ok(next),
            // The staged file is not the proved one any more.
            (Verified, Published | Nesting) => Ok(next),
            (Published, Printing) => Ok(next),
            // Its file was taken back out of the queue.
            (Published, Failed) => Ok(next),
            (Printing, Complete | Interrupted | Failed) => Ok(next),
            // What was told of a print is corrected.
            (Complete, Interrupted | Failed) | (Interrupted, Complete | Failed) => Ok(next),
            (Failed, Complete | Interrupted) => Ok(next),
            _ => Err(IllegalMove { thing: "build", from: self.to_string(), to: next.to_string() }),
        }
    }
}

own_word!(PartState);
own_word!(BuildState);
