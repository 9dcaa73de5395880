//! The farm: its state, and what all of its steps share. It knows no step.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    time::{Duration, Instant},
};

use anyhow::Result;
use jiff::Timestamp;
use tokio::sync::mpsc::UnboundedReceiver;

use super::{
    attention::Attention,
    back_off::BackOff,
    budget::Budget,
    clock::Clock,
    jobs::{Event, Jobs},
    leaving::Leaving,
    lock::Lock,
    lost_ledger::of_the_ledger,
    meshes::Meshes,
    nest_order::Best,
    notices::{Notices, Outside},
    owner::Owner,
    quiet::Quiet,
    station::Station,
};
use crate::{
    intake::{Claim, Watcher},
    ledger::{BuildId, Ledger, PartId},
    settings::{Settings, SettingsError},
};

/// Between two beats of the farm when nothing happens.
pub(super) const BEAT: Duration = Duration::from_millis(500);

/// Reads the configuration, at start and at each reload.
pub type Load = Box<dyn Fn() -> Result<Settings, SettingsError> + Send>;

/// The running farm.
pub struct Farm {
    pub(super) load: Load,
    pub(super) settings: Settings,
    /// This daemon, as the folders that it serves name it.
    pub(super) owner: Owner,
    pub(super) ledger: Ledger,
    pub(super) meshes: Meshes,
    pub(super) stations: BTreeMap<String, Station>,
    pub(super) jobs: Jobs<Farm>,
    /// Searches that may run at once.
    pub(super) nest_slots: usize,
    /// Claims whose originals still lie in the hot folder's `.claimed`, by claim id.
    pub(super) claims: HashMap<String, Claim>,
    /// Waiting parts that are refused once their originals are copied.
    pub(super) leaving: HashMap<PartId, Leaving>,
    /// Claims that this process has let go.
    pub(super) let_go: HashSet<String>,
    /// Parts whose reading failed for the disk's sake.
    pub(super) read_again: BackOff<PartId>,
    /// Parts whose first reading was counted with their claim and is not begun yet.
    pub(super) counted_reads: HashSet<PartId>,
    /// Times that parts were looked for to read.
    pub(super) reads_begun: usize,
    /// Whether the file that is read now has ended the process before.
    pub(super) is_reading_alone: bool,
    /// Builds fired by this process that have not been begun.
    pub(super) fresh_builds: HashSet<BuildId>,
    /// Builds of which the ledger was told just now that the first rename is tried.
    pub(super) untried: HashSet<BuildId>,
    /// Final searches that run.
    pub(super) finals: HashMap<BuildId, (Budget, Best)>,
    /// How often the making of builds has failed in this run, and why last.
    pub(super) failures: HashMap<BuildId, (u32, String)>,
    /// Builds that failed and rest.
    pub(super) resting: BackOff<BuildId>,
    /// Steps that failed and rest, by name.
    pub(super) steps: BackOff<String>,
    pub(super) stopping: bool,
    pub(super) quiet: Quiet,
    pub(super) clock: Clock,
    pub(super) started_at: Timestamp,
    pub(super) status_line: String,
    pub(super) shown_at: Option<Instant>,
    pub(super) watcher: Option<Watcher>,
    pub(super) sign_of_life: Option<Instant>,
    pub(super) tidy_at: Instant,
    pub(super) last_watch_check: Instant,
    pub(super) last_claims: Instant,
    pub(super) last_hold: Instant,
    /// What a person must see to.
    pub(super) notices: Notices,
    /// What others of this process tell.
    pub(super) outside: Outside,
    /// The ledger is damaged: nothing is done any more but telling so.
    pub(super) is_halted: bool,
    pub(super) events: UnboundedReceiver<Event<Farm>>,
    pub(super) _lock: Lock,
}

impl Farm {
    /// Does a step; one that fails is logged, rests, and is tried again.
    pub(super) async fn tell(&mut self, what: &str, step: impl AsyncFnOnce(&mut Self) -> Result<()>) {
        if self.steps.rests(&what.to_owned()) {
            return;
        }
        match step(self).await {
            Ok(()) => {
                self.steps.done(&what.to_owned());
                self.notices.clear(Attention::StepFails, "", what);
            }
            Err(failure) => {
                self.steps.failed(what.to_owned());
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
