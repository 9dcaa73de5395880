//! The farm: its state, its event loop and its orderly stop. Every step looks into the ledger and onto the disk for its
//! work, so a beat after a restart is the same as any other beat.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    time::{Duration, Instant},
};

use anyhow::Result;
use jiff::Timestamp;
use tokio::sync::mpsc::UnboundedReceiver;
use tracing::{info, warn};

use super::{
    attention::Attention,
    back_off::BackOff,
    budget::Budget,
    clock::Clock,
    ending::Leaving,
    event::Event,
    jobs::{JobKey, Jobs},
    lock::Lock,
    lost_ledger::of_the_ledger,
    meshes::Meshes,
    nest::Best,
    notices::{Notices, Outside},
    owner::Owner,
    quiet::Quiet,
    sd,
    signals::{Signal, Signals},
    station::Station,
};
use crate::{
    intake::{Claim, Watcher},
    ledger::{BuildId, Ledger, PartId, Refusal},
    settings::{Settings, SettingsError},
};

/// Between two beats of the farm when nothing happens.
pub(super) const BEAT: Duration = Duration::from_millis(500);
/// Between two signs of life in the ledger.
const SIGN_OF_LIFE: Duration = Duration::from_secs(4);
/// How long an orderly stop waits for jobs; the service manager gives 10 s.
const STOP_WITHIN: Duration = Duration::from_secs(8);
/// Claims whose end failed are tried again after so long.
const CLAIMS_AGAIN: Duration = Duration::from_secs(20);
/// Events between two beats at most, so that orders and signals are heard in between.
const EVENTS_PER_BEAT: usize = 64;
/// While files are being read one after the other, all other steps look for work so often only: each of them asks the ledger,
/// and together they cost more than a small file.
const BEAT_WHILE_READING: Duration = Duration::from_millis(100);

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
    pub(super) jobs: Jobs,
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
    pub(super) events: UnboundedReceiver<Event>,
    pub(super) _lock: Lock,
}

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load, outside: Outside) -> Result<()> {
    let settings = load()?;
    let mut signals = Signals::listen()?;
    let Some(mut farm) = Farm::open_when_possible(load, settings, &mut signals).await? else { return Ok(()) };
    farm.outside = outside;
    farm.beat().await;
    farm.outside.set_open(!farm.is_halted);
    sd::ready(&farm.status_line);
    info!(profiles = farm.stations.len(), ledger = %farm.settings.ledger.display(), "The farm is open.");
    let result = farm.serve(&mut signals).await;
    sd::stopping();
    farm.stop().await;
    result
}

impl Farm {
    async fn serve(&mut self, signals: &mut Signals) -> Result<()> {
        let mut beat = tokio::time::interval(BEAT);
        beat.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut worked_at = Instant::now();
        loop {
            let mut only_read = false;
            tokio::select! {
                signal = signals.next() => match signal {
                    Signal::Stop => return Ok(()),
                    Signal::Reload => self.reload().await,
                },
                Some(event) = self.events.recv() => only_read = self.on_events(event).await,
                _ = beat.tick() => {}
            }
            if only_read && !self.is_halted && worked_at.elapsed() < BEAT_WHILE_READING {
                self.tell("reading", Self::read).await;
                if self.jobs.count(|key| matches!(key, JobKey::Read(_))) > 0 {
                    continue;
                }
            }
            self.beat().await;
            worked_at = Instant::now();
        }
    }

    /// One beat: every step does what there is to do. A step that fails is logged and tried again at the next beat.
    pub(super) async fn beat(&mut self) {
        sd::alive();
        self.tell_people();
        if !self.is_halted
            && let Err(replaced) = self.ledger.demand_in_place()
        {
            self.leave_ledger(&replaced).await;
        }
        if self.is_halted {
            return;
        }
        // Before anything else: while this process stood still, another farm may have taken folders and claims.
        let is_due = self.last_hold.elapsed() >= super::lease::beat_every();
        self.keep_holds(is_due);
        self.tell("looking at the clock", Self::look_at_clock).await;
        self.receive();
        if self.may_have_work() {
            self.work().await;
        }
        if self.sign_of_life.is_none_or(|at| at.elapsed() >= SIGN_OF_LIFE) {
            self.sign_of_life = Some(Instant::now());
            self.tell("sign of life", Self::sign_of_life).await;
        }
        if self.last_watch_check.elapsed().as_secs_f64() >= self.settings.scan_secs {
            self.last_watch_check = Instant::now();
            self.make_missing_folders();
            self.compare_folders();
            self.check_watch();
            self.look_for_stray_files();
        }
        if self.last_claims.elapsed() >= CLAIMS_AGAIN {
            self.last_claims = Instant::now();
            self.tell("settling claims", Self::settle_claims).await;
            self.tell("looking at damaged files", Self::look_at_damaged).await;
        }
        if Instant::now() >= self.tidy_at {
            self.tidy_at = Instant::now() + super::tidy::TIDY_EVERY;
            self.tell("tidying", Self::tidy).await;
        }
    }

    /// Every step that looks into the ledger.
    async fn work(&mut self) {
        let names: Vec<String> = self.stations.keys().cloned().collect();
        self.tell("orders", Self::orders).await;
        self.tell("reading", Self::read).await;
        // Fired builds come before open ones: they take the free slots first.
        self.tell("nesting", Self::nest).await;
        for name in names {
            self.tell(&format!("batching {name}"), async |farm| farm.batch_when_rested(&name).await).await;
        }
        self.tell("publishing", Self::publish).await;
        self.tell("status", Self::show_status).await;
    }

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

    /// Takes in an event and those that wait behind it: one beat serves them all. Returns whether all told of parts that were
    /// read.
    async fn on_events(&mut self, first: Event) -> bool {
        let mut only_read = matches!(first, Event::Read { .. });
        self.on_event(first).await;
        for _ in 0..EVENTS_PER_BEAT {
            let Ok(event) = self.events.try_recv() else { break };
            only_read &= matches!(event, Event::Read { .. });
            self.on_event(event).await;
        }
        only_read
    }

    async fn on_event(&mut self, event: Event) {
        if self.is_halted {
            if let Event::Told { profile } = event {
                self.jobs.ended(&JobKey::Tell(profile));
            }
            return;
        }
        let result = match event {
            Event::Look => {
                self.look_soon();
                Ok(())
            }
            Event::Received { profile, gate, received } => self.on_received(&profile, gate, received).await,
            Event::Read { part, outcome } => self.on_read(part, outcome).await,
            Event::Improved { profile, round, nested } => self.on_improved(&profile, round, nested).await,
            Event::Written { build, written } => self.on_written(build, written).await,
            Event::Published { build, step } => self.on_published(build, step).await,
            Event::Ended { part, ended } => {
                self.on_ended(&part, ended);
                Ok(())
            }
            Event::Copied { part, copied } => self.on_copied(part, copied).await,
            Event::Held { profile, holds } => self.on_held(&profile, *holds).await,
            Event::Compared { profile, compared } => {
                self.on_compared(&profile, compared);
                Ok(())
            }
            Event::NotStarted { key, why } => {
                self.on_not_started(key, &why);
                Ok(())
            }
            Event::Whole(hashes) => self.on_whole(&hashes).await,
            Event::Purged => {
                self.jobs.ended(&JobKey::Purge);
                Ok(())
            }
            Event::Stray(found) => {
                self.on_stray(&found);
                Ok(())
            }
            Event::Told { profile } => {
                self.jobs.ended(&JobKey::Tell(profile));
                Ok(())
            }
            Event::Panicked { key, message } => self.on_panicked(key, &message).await,
        };
        if let Err(failure) = result {
            self.trouble(Attention::StepFails, "", "taking in what a job has done", &failure);
        }
    }

    async fn on_panicked(&mut self, key: JobKey, message: &str) -> Result<()> {
        warn!("A job panicked ({key:?}): {message}.");
        self.jobs.ended(&key);
        match key {
            JobKey::Receive(name) => {
                self.new_gate(&name);
                Ok(())
            }
            JobKey::Read(part) => {
                let outcome = super::read::ReadOutcome::Refused(
                    Refusal::Failure,
                    format!(
                        "The reader failed on it: {message}. Export it again, as STL or 3MF; where that fails too, send it to \
                     nestd's makers."
                    ),
                );
                self.on_read(part, outcome).await
            }
            JobKey::Improve(name) => {
                let build = self.ledger.open_build(&name).await?;
                self.has_ended_well(&build).await?;
                self.on_search_panicked(&name, message).await
            }
            JobKey::Final(build) => self.on_final_panicked(build, message).await,
            JobKey::Publish(build) => self.on_published(build, Err(anyhow::anyhow!("panicked: {message}"))).await,
            JobKey::Copy(part) => self.on_copied(part, Err(anyhow::anyhow!("panicked: {message}"))).await,
            JobKey::End(_)
            | JobKey::Damaged
            | JobKey::Purge
            | JobKey::Hold(_)
            | JobKey::Compare(_)
            | JobKey::Stray
            | JobKey::Tell(_) => Ok(()),
        }
    }

    /// Ends searches with what they have found, waits for jobs a little, and keeps the open layouts.
    async fn stop(&mut self) {
        info!("The farm closes.");
        self.outside.set_open(false);
        self.stopping = true;
        let deadline = Instant::now() + STOP_WITHIN;
        self.finals.values().for_each(|(budget, _)| budget.cancel());
        self.stations.values().filter_map(|s| s.open.search.as_ref()).for_each(|search| search.budget.cancel());
        self.wait_for_jobs(deadline).await;
        if self.is_halted {
            self.say_farewell().await;
            // Nothing is written into a damaged ledger, and no seal vouches for it.
            self.end_holds();
            if self.ledger.demand_in_place().is_ok() {
                self.ledger.close().await;
            }
            return;
        }
        self.keep_layouts().await;
        self.say_farewell().await;
        self.end_holds();
        if let Err(failure) = self.ledger.farewell().await {
            warn!("The ledger could not be told of the stop: {failure}.");
        }
        match self.ledger.close_sealed().await {
            Ok(true) => {}
            Ok(false) => info!("The ledger has no seal; the next start looks through all of it."),
            Err(failure) => warn!("The ledger could not be closed in order: {failure}."),
        }
        info!("The farm is closed.");
    }

    /// Takes in what jobs have done until none runs, or until a moment.
    pub(super) async fn wait_for_jobs(&mut self, deadline: Instant) {
        while !self.jobs.is_idle() {
            let left = deadline.saturating_duration_since(Instant::now());
            match tokio::time::timeout(left, self.events.recv()).await {
                Ok(Some(event)) => self.on_event(event).await,
                _ => break,
            }
            sd::alive();
        }
    }

    /// What searches have found that did not end in time.
    async fn keep_layouts(&mut self) {
        for (build, (_, best)) in &self.finals {
            let found = best.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
            if let Some(layout) = found
                && let Err(failure) = self.save_layout(*build, &layout).await
            {
                warn!(build.id = %build, "Its layout could not be kept: {failure:#}.");
            }
        }
    }
}
