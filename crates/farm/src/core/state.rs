//! The data that each step keeps between two ticks. All of it may be lost: after a restart, the steps find their work
//! in the ledger and on the disk.

use std::{
    collections::{HashMap, HashSet},
    path::PathBuf,
    time::{Duration, Instant},
};

use intake::InboxWatcher;
use jiff::Timestamp;
use ledger::{BuildId, CommandRow, PartId, PartRow, RefusalCause};
use settings::{InterfaceSettings, Settings, SettingsError};

use crate::{
    alerts::{alert::AlertKind, service_bridge::ServiceBridge},
    files::standing_claim::StandingClaim,
    leases::{lease_holder::LeaseHolder, state_lock::StateDirLock},
    nesting::running_searches::RunningSearches,
    planning::DateRisk,
    process::{
        ledger_changes::LedgerChangeDetector, retry_backoff::RetryBackoff, tick_tasks::TaskTimes,
        time_source::TimeSource, wall_clock::WallClockMonitor,
    },
    records::forgettable::ForgettingState,
};

/// A waiting part that is refused once a copy of its original is in the error folder. Until then no batch takes it.
#[derive(Debug)]
pub(crate) struct DeferredRefusal {
    /// The part.
    pub(crate) part: PartRow,
    /// The kind of refusal.
    pub(crate) cause: RefusalCause,
    /// The reason in whole sentences.
    pub(crate) reason: String,
    /// The command that asked for it, if any.
    pub(crate) command: Option<CommandRow>,
}

/// State of completing claims.
#[derive(Debug, Default)]
pub(crate) struct CompletionState {
    /// Claims whose originals are still in the hot folder's `.claimed`, by claim id.
    pub(crate) claims: HashMap<String, StandingClaim>,
    /// Waiting parts that are refused once their originals are copied.
    pub(crate) deferred_refusals: HashMap<PartId, DeferredRefusal>,
    /// Claims that this process has released.
    pub(crate) released: HashSet<String>,
    /// Data that the store does not need any more.
    pub(crate) forgetting: ForgettingState,
}

/// State of reading parts.
#[derive(Debug, Default)]
pub(crate) struct ReadingState {
    /// Parts that could not be read because the disk failed.
    pub(crate) backoff: RetryBackoff<PartId>,
    /// Parts whose next read is counted already: the first when they were recorded, another one when the ledger did not take in its end.
    pub(crate) counted_reads: HashSet<PartId>,
    /// Number of times that the step looked for parts to read.
    pub(crate) rounds: usize,
    /// Whether the file being read now has ended the process before.
    pub(crate) reads_alone: bool,
}

/// State of fired builds, until they are published.
#[derive(Debug, Default)]
pub(crate) struct NestingState {
    /// The searches that run.
    pub(crate) searches: RunningSearches,
    /// Builds fired by this process that have not been started.
    pub(crate) just_fired: HashSet<BuildId>,
    /// Number of failed attempts to make each build in this run, and the last reason.
    pub(crate) failures: HashMap<BuildId, (u32, String)>,
    /// Builds that failed and wait for a retry.
    pub(crate) backoff: RetryBackoff<BuildId>,
    /// Builds whose first rename was just recorded in the ledger and not tried yet.
    pub(crate) rename_untried: HashSet<BuildId>,
}

impl ReadingState {
    /// The state before the first read. The clocks of `time` measure the wait before a failed read is retried.
    pub(crate) fn by(time: TimeSource) -> Self {
        Self { backoff: RetryBackoff::by(time), ..Self::default() }
    }
}

impl NestingState {
    /// The state before the first build is nested. The clocks of `time` measure the wait before a failed build is
    /// retried.
    pub(crate) fn by(time: TimeSource) -> Self {
        Self { searches: RunningSearches::of_slots(1), backoff: RetryBackoff::by(time), ..Self::default() }
    }
}

/// State of the status shown to people.
#[derive(Debug, Default)]
pub(crate) struct DisplayState {
    /// The status line for the service manager.
    pub(crate) status_line: String,
    /// When the status was last updated.
    pub(crate) updated_at: Option<Instant>,
    /// Whether the ledger has news since then.
    pub(crate) is_behind: bool,
    /// Whether builds are made, or files read, for the machines of this node, which may go on without news of the ledger.
    pub(crate) is_work_under_way: bool,
    /// What is late, or at risk to be, according to the last plans.
    pub(crate) dates: PlannedDates,
}

/// What is late, or at risk to be, according to plans that were made a moment ago.
#[derive(Debug, Default)]
pub(crate) struct PlannedDates {
    pub(crate) risks: Vec<DateRisk>,
    /// When the plans were made, after which event, and how long that took.
    made: Option<(Instant, i64, Duration)>,
}

impl PlannedDates {
    /// Plans are made anew after this time although nothing happened.
    const INTERVAL: Duration = Duration::from_secs(60);
    /// Where things happen, plans are made anew after so many times the time that this takes.
    const REST: u32 = 50;

    /// Whether plans are to be made anew, now that this is the last event.
    pub(crate) fn is_due(&self, event: i64, now: Instant) -> bool {
        self.made.is_none_or(|(at, seen, took)| {
            let rest = if seen == event { Self::INTERVAL } else { (Self::REST * took).min(Self::INTERVAL) };
            now.saturating_duration_since(at) >= rest
        })
    }

    /// Takes in what new plans say.
    pub(crate) fn take_in(&mut self, risks: Vec<DateRisk>, event: i64, now: Instant, took: Duration) {
        (self.risks, self.made) = (risks, Some((now, event, took)));
    }
}

/// The watch on the hot folders of all machines.
#[derive(Debug, Default)]
pub(crate) struct HotFolderWatch {
    /// What is watched; `None` = nothing is, or a job has it.
    pub(crate) watched: Option<WatchedInboxes>,
    /// The warning that the hot folders send no file-system events was logged.
    pub(crate) is_unwatched: bool,
}

/// The hot folders that are watched.
#[derive(Debug)]
pub(crate) struct WatchedInboxes {
    pub(crate) watcher: InboxWatcher,
    pub(crate) inboxes: Vec<PathBuf>,
}

/// The times at which the loop runs its steps.
pub(crate) struct LoopSchedule {
    pub(crate) time: TimeSource,
    pub(crate) clock: WallClockMonitor,
    pub(crate) ledger_changes: LedgerChangeDetector,
    /// Steps that failed and wait for a retry, by name.
    pub(crate) step_backoff: RetryBackoff<String>,
    /// Whether anything has failed, or was not begun, because the ledger could not be reached or changed.
    pub(crate) is_cut_off: bool,
    /// What makes the farm halt, as soon as the step that has found it has ended.
    pub(crate) halts_for: Option<(AlertKind, String)>,
    /// When each task of the tick is due.
    pub(crate) tasks: TaskTimes,
    /// What was looked at for second copies.
    pub(crate) copies: SecondCopyLook,
}

/// What was looked at last for the second copies of another node's files.
#[derive(Debug, Default)]
pub(crate) struct SecondCopyLook {
    pub(crate) changes: LedgerChangeDetector,
    /// The node whose files are copied.
    pub(crate) node: String,
    /// The newest part.
    pub(crate) newest: Option<PartId>,
    /// When all live parts were looked at, and not the newer ones alone.
    pub(crate) all_at: Option<Instant>,
}

impl LoopSchedule {
    /// The schedule of a farm that starts now.
    pub(crate) fn starting_now(scan_secs: f64, time: TimeSource) -> Self {
        Self {
            clock: WallClockMonitor::with_reader(time.clone()),
            ledger_changes: LedgerChangeDetector::default(),
            step_backoff: RetryBackoff::by(time.clone()),
            is_cut_off: false,
            halts_for: None,
            tasks: TaskTimes::starting_at(time.instant(), scan_secs),
            copies: SecondCopyLook::default(),
            time,
        }
    }
}

/// Reads the configuration at the start and at each reload.
pub type Load = Box<dyn Fn() -> Result<Settings, SettingsError> + Send>;

/// The life cycle of the daemon.
pub(crate) struct DaemonLifecycle {
    /// Reads the configuration.
    pub(crate) load: Load,
    /// This daemon, as named in the leases of its folders.
    pub(crate) holder: LeaseHolder,
    pub(crate) started_at: Timestamp,
    /// The daemon was asked to stop.
    pub(crate) is_stopping: bool,
    /// The ledger is damaged: the farm does nothing but report that.
    pub(crate) is_halted: bool,
    /// Connection to the other services of this process.
    pub(crate) services: ServiceBridge,
    /// What people and programs were given to see at the start. Pages and log keep it.
    pub(crate) started_with: InterfaceSettings,
    /// A configuration that was read again and is not in force yet.
    pub(crate) next_settings: Option<Settings>,
    pub(crate) _lock: StateDirLock,
}
