//! What a tick does because of the time alone: which of these tasks are due.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use crate::leases::lease_clock;

/// Interval of the heartbeats in the ledger.
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(5);
/// Interval of retrying claims that could not be completed.
const CLAIM_RETRY_INTERVAL: Duration = Duration::from_secs(20);
/// Interval of copying the files of another node.
const COPY_INTERVAL: Duration = Duration::from_secs(5);
/// Delay of the first housekeeping, so that it does not slow down the start.
const FIRST_TIDY_AFTER: Duration = Duration::from_secs(60);
/// Interval of the housekeeping.
const TIDY_INTERVAL: Duration = Duration::from_secs(3600);

/// A task of the tick, in the order of its tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum TimedTask {
    /// Renews the leases of all folders.
    RenewLeases,
    /// Writes a heartbeat into the ledger.
    WriteHeartbeat,
    /// Creates missing folders, compares folders with the ledger, and renews the watch.
    CheckFolders,
    /// Completes claims, and checks damaged files.
    RetryClaims,
    /// Copies the files of another node's parts.
    CopyFiles,
    /// Does the housekeeping.
    TidyUp,
}

/// When each task is due.
#[derive(Debug)]
pub(crate) struct TaskTimes {
    due_at: BTreeMap<TimedTask, Instant>,
}

impl TaskTimes {
    /// The times of a farm that starts now, which has just acquired its leases and compared its folders.
    pub(crate) fn starting_at(now: Instant, scan_secs: f64) -> Self {
        let first = [
            (TimedTask::WriteHeartbeat, Duration::ZERO),
            (TimedTask::CopyFiles, COPY_INTERVAL),
            (TimedTask::TidyUp, FIRST_TIDY_AFTER),
            (TimedTask::RenewLeases, interval_of(TimedTask::RenewLeases, scan_secs)),
            (TimedTask::CheckFolders, interval_of(TimedTask::CheckFolders, scan_secs)),
            (TimedTask::RetryClaims, interval_of(TimedTask::RetryClaims, scan_secs)),
        ];
        Self { due_at: first.into_iter().map(|(task, wait)| (task, now + wait)).collect() }
    }

    /// Whether a task is due.
    pub(crate) fn is_due(&self, task: TimedTask, now: Instant) -> bool {
        self.due_at.get(&task).is_none_or(|at| *at <= now)
    }

    /// The tasks that are due, in their order.
    pub(crate) fn due_tasks(&self, now: Instant) -> Vec<TimedTask> {
        self.due_at.iter().filter(|(_, at)| **at <= now).map(|(task, _)| *task).collect()
    }

    /// A task is done now: it is due again after its interval.
    pub(crate) fn record_done(&mut self, task: TimedTask, now: Instant, scan_secs: f64) {
        self.due_at.insert(task, now + interval_of(task, scan_secs));
    }

    /// A task is due at once.
    pub(crate) fn make_due(&mut self, task: TimedTask, now: Instant) {
        self.due_at.insert(task, now);
    }
}

/// The interval of a task. `scan_secs` is the interval of scans, seconds.
fn interval_of(task: TimedTask, scan_secs: f64) -> Duration {
    match task {
        TimedTask::RenewLeases => lease_clock::renewal_interval(),
        TimedTask::WriteHeartbeat => HEARTBEAT_INTERVAL,
        TimedTask::CheckFolders => Duration::from_secs_f64(scan_secs),
        TimedTask::RetryClaims => CLAIM_RETRY_INTERVAL,
        TimedTask::CopyFiles => COPY_INTERVAL,
        TimedTask::TidyUp => TIDY_INTERVAL,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_due_after_its_interval_and_in_its_order() {
        let start = Instant::now();
        let after = |secs: u64| start + Duration::from_secs(secs);
        let mut times = TaskTimes::starting_at(start, 5.0);
        assert_eq!(times.due_tasks(start), [TimedTask::WriteHeartbeat]);
        times.record_done(TimedTask::WriteHeartbeat, start, 5.0);
        assert_eq!(times.due_tasks(start), []);
        times.record_done(TimedTask::RenewLeases, after(59), 5.0);
        let late = times.due_tasks(after(60));
        assert_eq!(
            late,
            [
                TimedTask::WriteHeartbeat,
                TimedTask::CheckFolders,
                TimedTask::RetryClaims,
                TimedTask::CopyFiles,
                TimedTask::TidyUp
            ]
        );
        late.into_iter().for_each(|task| times.record_done(task, after(60), 5.0));
        assert!(!times.is_due(TimedTask::CheckFolders, after(64)) && times.is_due(TimedTask::CheckFolders, after(65)));
        assert!(!times.is_due(TimedTask::TidyUp, after(3600)) && times.is_due(TimedTask::TidyUp, after(3660)));
    }

    #[test]
    fn a_task_that_is_made_due_does_not_wait_for_its_interval() {
        let now = Instant::now();
        let mut times = TaskTimes::starting_at(now, 5.0);
        times.record_done(TimedTask::WriteHeartbeat, now, 5.0);
        times.make_due(TimedTask::WriteHeartbeat, now);
        assert_eq!(times.due_tasks(now), [TimedTask::WriteHeartbeat]);
    }
}
