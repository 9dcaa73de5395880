//! The farm: its state, and what all steps share. It depends on no step.

use std::time::{Duration, Instant};

use anyhow::Result;
use jiff::Timestamp;
use jobs::JobRunner;
use ledger::Ledger;

use super::{
    machine_state::MachineStates,
    state::{CompletionState, DaemonLifecycle, DisplayState, LoopSchedule, NestingState, ReadingState},
};
use crate::{
    farm::{
        alerts::{
            alert::{AlertKind, FarmAlert},
            alert_registry::{AlertRegistry, ServicePhase},
        },
        files::mesh_source::MeshSource,
        process::systemd,
        records::lost_ledger::ledger_alert,
    },
    settings::Settings,
};

/// Interval of the ticks when nothing happens.
pub(crate) const TICK_INTERVAL: Duration = Duration::from_millis(500);

/// The status line of a farm that has halted, if one of its alerts makes it halt.
pub fn halt_summary(alerts: &[FarmAlert]) -> Option<String> {
    let mut of_farm = alerts.iter().filter(|alert| alert.profile.is_empty());
    Some(format!("halted: the ledger {}", of_farm.find_map(|alert| alert.kind.ledger_fault())?))
}

/// The running farm.
pub struct Farm {
    pub(crate) settings: Settings,
    pub(crate) ledger: Ledger,
    pub(crate) meshes: MeshSource,
    pub(crate) machines: MachineStates,
    pub(crate) jobs: JobRunner<Farm>,
    pub(crate) completion: CompletionState,
    pub(crate) reading: ReadingState,
    pub(crate) nesting: NestingState,
    pub(crate) display: DisplayState,
    pub(crate) schedule: LoopSchedule,
    pub(crate) lifecycle: DaemonLifecycle,
    /// Alerts: what a person must act on.
    pub(crate) alerts: AlertRegistry,
}

impl Farm {
    /// Now, by the clock that only passes.
    pub(crate) fn now(&self) -> Instant {
        self.schedule.time.instant()
    }

    /// Now, by the clock that people set.
    pub(crate) fn date(&self) -> Timestamp {
        self.schedule.time.date()
    }

    /// Whether this node looks after the parts of a machine. The one node of a file looks after all, also after those of a machine that
    /// is not configured any more.
    pub(crate) fn looks_after(&self, profile: &str) -> bool {
        self.ledger.file().is_some() || self.machines.contains_key(profile)
    }

    /// Runs a step. A step that fails is logged, waits, and is retried.
    pub(crate) async fn run_step(&mut self, what: &str, step: impl AsyncFnOnce(&mut Self) -> Result<()>) {
        if self.schedule.step_backoff.is_waiting(&what.to_owned()) {
            return;
        }
        let done = step(self).await;
        // Each step ends in time, also while all changes wait for another one's.
        systemd::notify_watchdog();
        match done {
            Ok(()) => {
                self.schedule.step_backoff.record_success(&what.to_owned());
                self.alerts.clear(AlertKind::StepFails, "", what);
            }
            Err(failure) => {
                self.schedule.step_backoff.record_failure(what.to_owned());
                self.report_failure(AlertKind::StepFails, "", what, &failure);
            }
        }
    }

    /// Reports a failure that is retried. If the ledger is damaged, the farm halts instead.
    pub(crate) fn report_failure(&mut self, kind: AlertKind, profile: &str, about: &str, failure: &anyhow::Error) {
        let ledger_alert = ledger_alert(failure);
        self.schedule.is_cut_off |= ledger_alert.as_ref().is_some_and(|(kind, _)| kind.cuts_ledger_off());
        match ledger_alert {
            // The next tick detects it and saves what is known.
            Some((AlertKind::LedgerReplaced, _)) => {}
            // The next tick sees it, and what failed is done again when the lock is free.
            Some((AlertKind::LedgerLocked, _)) => {}
            // What failed is done again when the server is back.
            Some((AlertKind::LedgerUnreachable, why)) => self.ledger.doubt_service(&why),
            // What failed is done again when it is its turn.
            Some((kind @ AlertKind::ChangesWait, holder)) => self.alerts.raise(kind, "", "", &holder),
            // The next tick sees it.
            Some((AlertKind::RepairDue, _)) => {}
            Some((kind, detail)) => self.halt_farm(kind, &detail),
            None => self.alerts.report_failure(kind, profile, about, &format!("{about}: {failure:#}")),
        }
    }

    /// Halts the farm, since the ledger cannot be relied on: files could be claimed and builds published without being
    /// recorded.
    pub(crate) fn halt_farm(&mut self, kind: AlertKind, why: &str) {
        if !self.lifecycle.is_halted {
            self.lifecycle.is_halted = true;
            self.nesting.searches.stop_all();
            self.machines.values_mut().for_each(|machine| machine.open.reset());
            self.alerts.raise(kind, "", "", why);
            let active: Vec<FarmAlert> = self.alerts.active_alerts().collect();
            let alert = active.iter().find(|alert| alert.kind == kind).map(FarmAlert::alert_text).unwrap_or_default();
            self.lifecycle
                .services
                .set_phase(ServicePhase::Halted(format!("{alert} {}", kind.remedy().trim_end_matches('.'))));
            self.display.status_line = halt_summary(&active).unwrap_or_else(|| "halted".to_owned());
            systemd::notify_status(&self.display.status_line);
        }
    }
}
