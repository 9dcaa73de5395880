//! The farm: its state, and how it halts. It depends on no step; what each step may touch of it is in `desks`.

use std::time::{Duration, Instant};

use jobs::JobRunner;
use language::say;
use ledger::Ledger;
use settings::Settings;

use super::{
    machine_state::MachineStates,
    state::{CompletionState, DaemonLifecycle, DisplayState, HotFolderWatch, LoopSchedule, NestingState, ReadingState},
};
use crate::{
    alerts::{
        alert::{AlertKind, FarmAlert},
        alert_registry::AlertRegistry,
        service_bridge::ServicePhase,
    },
    files::mesh_source::MeshSource,
    process::systemd,
};

/// Interval of the ticks when nothing happens.
pub(crate) const TICK_INTERVAL: Duration = Duration::from_millis(500);

/// The status line of a farm that has halted, if one of its alerts makes it halt.
pub fn halt_summary(alerts: &[FarmAlert]) -> Option<String> {
    let mut of_farm = alerts.iter().filter(|alert| alert.machine.is_empty() && alert.node.is_empty());
    Some(say!("halted", fault = of_farm.find_map(|alert| alert.kind.ledger_fault())?))
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
    pub(crate) watch: HotFolderWatch,
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
