//! The farm: its state, and what all of its steps share. It knows no step.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use anyhow::Result;
use jiff::Timestamp;

use super::{
    attention::Attention,
    jobs::Jobs,
    lost_ledger::of_the_ledger,
    meshes::Meshes,
    notices::Notices,
    state::{EndingState, Lifecycle, NestingState, ReadingState, Schedule, ShownState},
    station::Station,
};
use crate::{ledger::Ledger, settings::Settings};

/// Between two beats of the farm when nothing happens.
pub(super) const BEAT: Duration = Duration::from_millis(500);

/// The running farm.
pub struct Farm {
    pub(super) settings: Settings,
    pub(super) ledger: Ledger,
    pub(super) meshes: Meshes,
    pub(super) stations: BTreeMap<String, Station>,
    pub(super) jobs: Jobs<Farm>,
    pub(super) ending: EndingState,
    pub(super) reading: ReadingState,
    pub(super) nesting: NestingState,
    pub(super) shown: ShownState,
    pub(super) schedule: Schedule,
    pub(super) life: Lifecycle,
    /// What a person must see to.
    pub(super) notices: Notices,
}

impl Farm {
    /// Now, by the clock that only passes.
    pub(super) fn now(&self) -> Instant {
        self.schedule.time.instant()
    }

    /// Now, by the clock that people set.
    pub(super) fn date(&self) -> Timestamp {
        self.schedule.time.date()
    }

    /// Does a step; one that fails is logged, rests, and is tried again.
    pub(super) async fn tell(&mut self, what: &str, step: impl AsyncFnOnce(&mut Self) -> Result<()>) {
        if self.schedule.steps.rests(&what.to_owned()) {
            return;
        }
        match step(self).await {
            Ok(()) => {
                self.schedule.steps.done(&what.to_owned());
                self.notices.clear(Attention::StepFails, "", what);
            }
            Err(failure) => {
                self.schedule.steps.failed(what.to_owned());
                self.trouble(Attention::StepFails, "", what, &failure);
            }
        }
    }

    /// Something failed and is tried again, unless the ledger is damaged: then nothing is.
    pub(super) fn trouble(&mut self, kind: Attention, profile: &str, about: &str, failure: &anyhow::Error) {
        match of_the_ledger(failure) {
            // The next beat sees it and saves what is known.
            Some((Attention::LedgerReplaced, _)) => {}
            Some((kind, detail)) => self.halt(kind, &detail),
            None => self.notices.trouble(kind, profile, about, &format!("{about}: {failure:#}")),
        }
    }
}
