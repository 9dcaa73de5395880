//! Kinds of events as an enum: what counts, notifies or checks events goes by these words.

use serde::{Deserialize, Serialize};

use super::text_column::{own_word, parse_word};
use crate::{BuildState, PartState};

/// The kind of an event.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A part was claimed, or taken back.
    Claimed,
    /// A part waits.
    Waiting,
    /// All copies of a part are in builds.
    Batched,
    /// All copies of a part are in published builds.
    Built,
    /// A part was refused or cancelled, or a file was refused before it became a part.
    Refused,
    /// A build collects parts.
    Open,
    /// A build was fired.
    Nesting,
    /// A build was proved.
    Verified,
    /// A build was put into the queue.
    Published,
    /// A machine prints a build.
    Printing,
    /// A build was printed.
    Complete,
    /// The print of a build stopped before its end.
    Interrupted,
    /// A build or its print failed.
    Failed,
    /// A machine was paused.
    Paused,
    /// A machine was resumed.
    Resumed,
    /// A machine became unavailable.
    Unavailable,
    /// A machine became available.
    Available,
    /// A machine was given to another node.
    Adopted,
    /// The stored file of a part was found damaged.
    Damaged,
    /// The file of a part was read in another size than the first time.
    SizeDiffers,
    /// The damaged file of a part was dropped again.
    Healed,
    /// The due date of parts is at risk.
    AtRisk,
    /// An attempt to make a build failed.
    AttemptFailed,
    /// A written build could not be proved.
    ProofFailed,
    /// Parts of a build are locked into each other.
    Locked,
    /// Copies that stood in the open build were put out of it.
    PutOut,
    /// Copies of the highest priority find no room in the next build.
    NoRoom,
    /// The clock was set.
    ClockSet,
    /// Messages to a receiver were dropped.
    MessagesDropped,
    /// Copies that were printed badly wait again.
    PutBack,
    /// Copies of a part are not wanted any more.
    CopiesCancelled,
    /// More copies of a part are wanted.
    CopiesWanted,
    /// What was asked with a part was changed.
    Edited,
    /// A part was moved to another machine.
    Moved,
    /// A person said that a part is to be printed as it is.
    Confirmed,
    /// A finishing step of a part was told to be done, or not to be.
    Finishing,
    /// A part replaced an earlier revision.
    Revised,
    /// A person has seen to a failed print.
    Seen,
    /// A build was issued once more.
    Requeued,
    /// A person took a printer out of use.
    PrinterDown,
    /// A person put a printer into use again.
    PrinterUp,
    /// A material was loaded in a machine.
    Loaded,
    /// The file of a published build was moved to another printer.
    Relocated,
    /// The file of a published build was found where the ledger did not have it.
    Found,
    /// A second file of a published build lay in a queue folder.
    SecondFile,
    /// A person said that a proved build may be published.
    Released,
    /// The file of a published build was taken back out of the queue, or its printer was first.
    Withdrawn,
    /// Every copy of an order was printed well.
    OrderComplete,
    /// An order ended with fewer copies than were wanted.
    OrderShort,
    /// Something needs a person; the cause is the word of its alert.
    Alert,
    /// A person closed an order as it was, or its refused part with it.
    OrderClosed,
    /// Who may sign in was changed.
    Person,
    /// A kind that another version of nestd wrote.
    #[serde(untagged)]
    Unknown(String),
}

own_word!(EventKind);

impl EventKind {
    /// The kind that a word stands for.
    pub fn from_word(word: &str) -> Self {
        parse_word(word).unwrap_or_else(|_| Self::Unknown(word.to_owned()))
    }
}

impl From<PartState> for EventKind {
    fn from(state: PartState) -> Self {
        match state {
            PartState::Claimed => Self::Claimed,
            PartState::Waiting => Self::Waiting,
            PartState::Batched => Self::Batched,
            PartState::Built => Self::Built,
            PartState::Refused => Self::Refused,
        }
    }
}

impl From<BuildState> for EventKind {
    fn from(state: BuildState) -> Self {
        match state {
            BuildState::Open => Self::Open,
            BuildState::Nesting => Self::Nesting,
            BuildState::Verified => Self::Verified,
            BuildState::Published => Self::Published,
            BuildState::Printing => Self::Printing,
            BuildState::Complete => Self::Complete,
            BuildState::Interrupted => Self::Interrupted,
            BuildState::Failed => Self::Failed,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, fs, path::Path};

    use super::*;

    /// The words in quotes after each of these starts of a condition.
    fn quoted_words(text: &str, starts: &[&str]) -> BTreeSet<String> {
        let mut words = BTreeSet::new();
        for start in starts {
            for (at, _) in text.match_indices(start) {
                let condition = &text[at + start.len()..];
                let condition =
                    if start.ends_with('(') { condition.split(')').next() } else { condition.split(' ').next() };
                let quoted = condition.unwrap_or_default().split('\'').skip(1).step_by(2);
                words.extend(quoted.map(ToOwned::to_owned));
            }
        }
        words
    }

    #[test]
    fn the_words_of_kinds_in_queries_and_migrations_are_kinds_of_the_enum() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut words = BTreeSet::new();
        for folder in ["crates/ledger/src", "src/metrics", "migrations"] {
            for entry in fs::read_dir(root.join(folder)).unwrap() {
                let path = entry.unwrap().path();
                let text = if path.is_file() { fs::read_to_string(&path).unwrap() } else { String::new() };
                // The kinds of commands have a CHECK constraint of their own.
                let text = text.replace("CHECK (kind IN (", "");
                words.extend(quoted_words(&text, &["kind = ", "kind IN ("]));
            }
        }
        // The word of refused before schema 40, which rewrites it.
        words.remove("rejected");
        assert!(words.contains("refused") && words.contains("proof_failed"), "{words:?}");
        for word in words {
            assert!(!matches!(EventKind::from_word(&word), EventKind::Unknown(_)), "no event is of the kind {word}");
        }
    }

    #[test]
    fn a_state_that_was_entered_has_its_own_word_and_other_words_are_kept() {
        for state in PartState::ALL {
            assert_eq!(EventKind::from(state).to_string(), state.to_string());
        }
        for state in BuildState::ALL {
            assert_eq!(EventKind::from(state).to_string(), state.to_string());
        }
        assert_eq!(EventKind::from_word("clock_set"), EventKind::ClockSet);
        let unknown = EventKind::from_word("improved");
        assert_eq!((unknown.to_string().as_str(), unknown), ("improved", EventKind::Unknown("improved".to_owned())));
    }
}
