//! What each step remembers between two beats. All of it may be lost: after a restart the steps find their work in the ledger
//! and on the disk.

use std::{
    collections::{HashMap, HashSet},
    path::PathBuf,
    time::{Duration, Instant},
};

use jiff::Timestamp;
use nester::SearchBudget;

use super::{
    back_off::BackOff, clock::Clock, forgettable::ForgettingState, lock::Lock, nest_order::Best, notices::Outside,
    owner::Owner, quiet::Quiet, standing_claim::StandingClaim, time_source::TimeSource,
};
use crate::{
    intake::Watcher,
    ledger::{BuildId, CommandRow, PartId, PartRow, Refusal},
    settings::{Settings, SettingsError},
};

/// A waiting part that is refused once a copy of its original is in the error folder. Until then it is not batched.
#[derive(Debug)]
pub(super) struct Leaving {
    /// Which.
    pub(super) part: PartRow,
    /// Why.
    pub(super) cause: Refusal,
    /// The same in whole sentences.
    pub(super) reason: String,
    /// The order by hand that asked for it.
    pub(super) command: Option<CommandRow>,
}

/// Of dropped files whose end is near.
#[derive(Debug, Default)]
pub(super) struct EndingState {
    /// Claims whose originals still lie in the hot folder's `.claimed`, by claim id.
    pub(super) claims: HashMap<String, StandingClaim>,
    /// Waiting parts that are refused once their originals are copied.
    pub(super) leaving: HashMap<PartId, Leaving>,
    /// Claims that this process has let go.
    pub(super) let_go: HashSet<String>,
    /// What the store does not need any more.
    pub(super) forgetting: ForgettingState,
}

/// Of the reading of parts.
#[derive(Debug, Default)]
pub(super) struct ReadingState {
    /// Parts whose reading failed for the disk's sake.
    pub(super) again: BackOff<PartId>,
    /// Parts whose first reading was counted with their claim and is not begun yet.
    pub(super) counted: HashSet<PartId>,
    /// Times that parts were looked for to read.
    pub(super) begun: usize,
    /// Whether the file that is read now has ended the process before.
    pub(super) is_alone: bool,
}

/// Of fired builds, until they are published.
#[derive(Debug, Default)]
pub(super) struct NestingState {
    /// Searches that may run at once.
    pub(super) slots: usize,
    /// Builds fired by this process that have not been begun.
    pub(super) fresh: HashSet<BuildId>,
    /// Final searches that run.
    pub(super) finals: HashMap<BuildId, (SearchBudget, Best)>,
    /// How often the making of builds has failed in this run, and why last.
    pub(super) failures: HashMap<BuildId, (u32, String)>,
    /// Builds that failed and rest.
    pub(super) resting: BackOff<BuildId>,
    /// Builds of which the ledger was told just now that the first rename is tried.
    pub(super) untried: HashSet<BuildId>,
}

impl ReadingState {
    /// Nothing is read yet; these clocks measure how long what failed rests.
    pub(super) fn by(time: TimeSource) -> Self {
        Self { again: BackOff::by(time), ..Self::default() }
    }
}

impl NestingState {
    /// Nothing is nested yet; these clocks measure how long what failed rests.
    pub(super) fn by(time: TimeSource) -> Self {
        Self { slots: 1, resting: BackOff::by(time), ..Self::default() }
    }
}

/// Of what is shown to people.
#[derive(Debug, Default)]
pub(super) struct ShownState {
    /// The line for the service manager.
    pub(super) line: String,
    /// When all that is shown was last brought up to date.
    pub(super) shown_at: Option<Instant>,
    /// When the last sign of life was written into the ledger.
    pub(super) sign_of_life: Option<Instant>,
}

/// The watch on the hot folders of all machines.
#[derive(Debug)]
pub(super) struct WatchedInboxes {
    pub(super) watcher: Watcher,
    pub(super) inboxes: Vec<PathBuf>,
}

/// When the loop looks for what.
pub(super) struct Schedule {
    pub(super) time: TimeSource,
    pub(super) clock: Clock,
    pub(super) quiet: Quiet,
    pub(super) watched: Option<WatchedInboxes>,
    /// That hot folders tell nothing was told.
    pub(super) is_unwatched: bool,
    /// Steps that failed and rest, by name.
    pub(super) steps: BackOff<String>,
    pub(super) tidy_at: Instant,
    pub(super) last_watch_check: Instant,
    pub(super) last_claims: Instant,
    pub(super) last_hold: Instant,
}

impl Schedule {
    /// Of a farm that opens now.
    pub(super) fn starting_now(first_tidy_after: Duration, time: TimeSource) -> Self {
        let now = time.instant();
        Self {
            clock: Clock::reading(time.clone()),
            quiet: Quiet::default(),
            watched: None,
            is_unwatched: false,
            steps: BackOff::by(time.clone()),
            tidy_at: now + first_tidy_after,
            last_watch_check: now,
            last_claims: now,
            last_hold: now,
            time,
        }
    }
}

/// Reads the configuration, at start and at each reload.
pub type Load = Box<dyn Fn() -> Result<Settings, SettingsError> + Send>;

/// Of the life of the daemon.
pub(super) struct Lifecycle {
    /// Reads the configuration.
    pub(super) load: Load,
    /// This daemon, as the folders that it serves name it.
    pub(super) owner: Owner,
    pub(super) started_at: Timestamp,
    /// It was told to stop.
    pub(super) stopping: bool,
    /// The ledger is damaged: nothing is done any more but telling so.
    pub(super) is_halted: bool,
    /// What others of this process tell.
    pub(super) outside: Outside,
    pub(super) _lock: Lock,
}
