//! What a step may touch. The event loop makes a *desk* of the farm for each step and for the end of each job: a struct of
//! references with the parts of the farm that this kind of work owns, and no others.

use std::{collections::HashSet, time::Instant};

use jiff::Timestamp;
use jobs::JobRunner;
use ledger::Ledger;
use settings::Settings;

use super::{
    farm::Farm,
    machine_state::MachineStates,
    state::{CompletionState, DaemonLifecycle, DisplayState, HotFolderWatch, LoopSchedule, NestingState, ReadingState},
};
use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    files::mesh_source::MeshSource,
    nesting::running_searches::RunningSearches,
    records::{forgettable::ForgettingState, lost_ledger::ledger_alert},
};

/// What every step may use: it reads the settings and the life of the daemon, works in the ledger, and tells people and the loop.
pub(crate) struct Shared<'f> {
    pub(crate) settings: &'f Settings,
    pub(crate) ledger: &'f Ledger,
    pub(crate) lifecycle: &'f DaemonLifecycle,
    pub(crate) schedule: &'f mut LoopSchedule,
    pub(crate) alerts: &'f mut AlertRegistry,
}

impl Shared<'_> {
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
    pub(crate) fn looks_after(&self, machines: &MachineStates, machine: &str) -> bool {
        self.ledger.file().is_some() || machines.contains_key(machine)
    }

    /// Reports a failure that is retried. If the ledger is damaged, the farm halts instead.
    pub(crate) fn report_failure(&mut self, kind: AlertKind, machine: &str, about: &str, failure: &anyhow::Error) {
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
            Some((kind, detail)) => self.halt(kind, &detail),
            None => self.alerts.report_failure(kind, machine, about, &format!("{about}: {failure:#}")),
        }
    }

    /// Has the farm halt as soon as this step has ended.
    pub(crate) fn halt(&mut self, kind: AlertKind, why: &str) {
        self.schedule.halts_for.get_or_insert_with(|| (kind, why.to_owned()));
    }

    /// The same for a part of the step.
    pub(crate) fn lend(&mut self) -> Shared<'_> {
        Shared {
            settings: self.settings,
            ledger: self.ledger,
            lifecycle: self.lifecycle,
            schedule: self.schedule,
            alerts: self.alerts,
        }
    }
}

/// The machines as they are served: their folders, leases and printers.
pub(crate) struct Serving<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
}

/// The watch on the hot folders, beside the machines.
pub(crate) struct Watching<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) watch: &'f mut HotFolderWatch,
}

/// The status that people see, beside the machines.
pub(crate) struct Showing<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) display: &'f mut DisplayState,
}

/// The machines as they are configured.
pub(crate) struct SettingUp<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) meshes: &'f mut MeshSource,
    /// Maximum number of searches at once.
    pub(crate) search_slots: &'f mut usize,
}

/// The store, and what it forgets.
pub(crate) struct Storing<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) meshes: &'f mut MeshSource,
    pub(crate) forgetting: &'f mut ForgettingState,
}

/// Parts, from their drop until they wait or are refused, and what people change of them.
pub(crate) struct Receiving<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) meshes: &'f mut MeshSource,
    pub(crate) completion: &'f mut CompletionState,
    pub(crate) reading: &'f mut ReadingState,
}

/// Open builds that are searched further while they wait.
pub(crate) struct Searching<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) meshes: &'f mut MeshSource,
    /// The searches that run, of fired builds too.
    pub(crate) searches: &'f mut RunningSearches,
}

/// Builds, from their firing until they lie in a queue.
pub(crate) struct Building<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) meshes: &'f mut MeshSource,
    pub(crate) forgetting: &'f mut ForgettingState,
    /// Claims that this process has released.
    pub(crate) released: &'f HashSet<String>,
    pub(crate) nesting: &'f mut NestingState,
}

/// Waiting parts that become a build, or leave one: received ones, and what is fired.
pub(crate) struct Batching<'f> {
    pub(crate) shared: Shared<'f>,
    pub(crate) machines: &'f mut MachineStates,
    pub(crate) jobs: &'f mut JobRunner<Farm>,
    pub(crate) meshes: &'f mut MeshSource,
    pub(crate) completion: &'f mut CompletionState,
    pub(crate) reading: &'f mut ReadingState,
    pub(crate) nesting: &'f mut NestingState,
}

impl Batching<'_> {
    pub(crate) fn receiving(&mut self) -> Receiving<'_> {
        Receiving {
            shared: self.shared.lend(),
            machines: self.machines,
            jobs: self.jobs,
            meshes: self.meshes,
            completion: self.completion,
            reading: self.reading,
        }
    }
}

impl Receiving<'_> {
    pub(crate) fn serving(&mut self) -> Serving<'_> {
        Serving { shared: self.shared.lend(), machines: self.machines, jobs: self.jobs }
    }

    pub(crate) fn storing(&mut self) -> Storing<'_> {
        let forgetting = &mut self.completion.forgetting;
        Storing { shared: self.shared.lend(), jobs: self.jobs, meshes: self.meshes, forgetting }
    }
}

impl Building<'_> {
    pub(crate) fn storing(&mut self) -> Storing<'_> {
        let shared = self.shared.lend();
        Storing { shared, jobs: self.jobs, meshes: self.meshes, forgetting: self.forgetting }
    }
}

impl Watching<'_> {
    pub(crate) fn serving(&mut self) -> Serving<'_> {
        Serving { shared: self.shared.lend(), machines: self.machines, jobs: self.jobs }
    }
}
