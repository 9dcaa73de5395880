//! Runs a step of the farm, and halts the farm where a step has found that its ledger cannot be relied on.

use anyhow::Result;

use super::{desks::Shared, farm::Farm};
use crate::{alerts::alert::AlertKind, process::systemd};

impl Farm {
    /// What a step may touch.
    pub(crate) fn desk<'f, D: From<&'f mut Self>>(&'f mut self) -> D {
        self.into()
    }

    /// Runs a step. A step that fails is logged, waits, and is retried.
    pub(crate) async fn run_step(&mut self, what: &str, step: impl AsyncFnOnce(&mut Self) -> Result<()>) {
        // While the ledger cannot be reached, each step would wait for it in vain.
        if self.schedule.step_backoff.is_waiting(&what.to_owned()) || self.ledger.is_out_of_reach() {
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
        self.halt_if_asked();
    }

    /// Reports a failure that is retried, see [`Shared::report_failure`].
    pub(crate) fn report_failure(&mut self, kind: AlertKind, machine: &str, about: &str, failure: &anyhow::Error) {
        self.desk::<Shared<'_>>().report_failure(kind, machine, about, failure);
    }

    /// Halts the farm if a step has asked for that.
    pub(crate) fn halt_if_asked(&mut self) {
        if let Some((kind, why)) = self.schedule.halts_for.take() {
            self.halt_farm(kind, &why);
        }
    }
}
