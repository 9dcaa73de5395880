//! The farm: its state, its event loop and its orderly stop. Every step looks into the ledger and onto the disk for its
//! work, so a beat after a restart is the same as any other beat.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use jiff::Timestamp;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tracing::{error, info, warn};

use super::{
    back_off::{BackOff, is_of_the_disk},
    budget::Budget,
    complaints::Complaints,
    event::Event,
    jobs::{JobKey, Jobs},
    lock::Lock,
    nest::{Best, Meshes},
    owner::Owner,
    quiet::Quiet,
    sd,
    shelf::Shelf,
    signals::{Signal, Signals},
    station::Station,
};
use crate::{
    intake::{Claim, Store, Watcher},
    ledger::{BuildId, Ledger, LedgerError, PartId},
    settings::{Settings, SettingsError},
};

/// Between two beats of the farm when nothing happens.
const BEAT: Duration = Duration::from_millis(500);
/// Between two signs of life in the ledger.
const SIGN_OF_LIFE: Duration = Duration::from_secs(4);
/// How long an orderly stop waits for jobs; the service manager gives 10 s.
const STOP_WITHIN: Duration = Duration::from_secs(8);
/// Claims whose end failed are tried again after so long.
const CLAIMS_AGAIN: Duration = Duration::from_secs(20);
/// Events between two beats at most, so that orders and signals are heard in between.
const EVENTS_PER_BEAT: usize = 64;

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
    /// Parts whose reading failed for the disk's sake.
    pub(super) read_again: BackOff<PartId>,
    /// Times that parts were looked for to read.
    pub(super) reads_begun: usize,
    /// Builds fired by this process that have not been begun.
    pub(super) fresh_builds: HashSet<BuildId>,
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
    pub(super) started_at: Timestamp,
    pub(super) status_line: String,
    pub(super) shown_at: Option<Instant>,
    pub(super) watcher: Option<Watcher>,
    sign_of_life: Option<Instant>,
    tidy_at: Instant,
    last_watch_check: Instant,
    last_claims: Instant,
    last_hold: Instant,
    pub(super) complaints: Complaints,
    events: UnboundedReceiver<Event>,
    _lock: Lock,
}

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load) -> Result<()> {
    let settings = load()?;
    let mut signals = Signals::listen()?;
    let Some(mut farm) = Farm::open_when_possible(load, settings, &mut signals).await? else { return Ok(()) };
    farm.beat().await;
    sd::ready(&farm.status_line);
    info!(profiles = farm.stations.len(), ledger = %farm.settings.ledger.display(), "The farm is open.");
    let result = farm.serve(&mut signals).await;
    sd::stopping();
    farm.stop().await;
    result
}

impl Farm {
    /// Opens the farm; while the disk of the state folder is full or away, waits for it instead of ending again and again.
    /// `None` = told to stop meanwhile.
    async fn open_when_possible(load: Load, settings: Settings, signals: &mut Signals) -> Result<Option<Self>> {
        let (mut load, mut settings, mut waits, mut complaints) =
            (load, settings, BackOff::default(), Complaints::default());
        loop {
            let (back, known, failure) = match Self::open(load, settings).await {
                Ok(farm) => return Ok(Some(farm)),
                Err(kept) => kept,
            };
            (load, settings) = (back, known);
            if !may_pass(&failure) {
                return Err(failure);
            }
            let text = format!("The farm cannot be opened now and is tried again: {failure:#}");
            complaints.note("opening", &text);
            sd::waiting(&text);
            waits.failed(());
            while waits.rests(&()) {
                tokio::select! {
                    signal = signals.next() => if matches!(signal, Signal::Stop) { return Ok(None) },
                    () = tokio::time::sleep(BEAT) => {}
                }
            }
        }
    }

    /// On failure, what is needed for another try comes back.
    async fn open(load: Load, settings: Settings) -> Result<Self, (Load, Settings, anyhow::Error)> {
        let since = Timestamp::now();
        match Parts::open(&settings, since).await {
            Ok(parts) => {
                let mut farm = Self::new(load, settings, parts, since);
                match farm.open_stations().await {
                    Ok(()) => Ok(farm),
                    Err(failure) => {
                        farm.ledger.close().await;
                        Err((farm.load, farm.settings, failure))
                    }
                }
            }
            Err(failure) => Err((load, settings, failure)),
        }
    }

    async fn open_stations(&mut self) -> Result<()> {
        self.set_up_stations().await?;
        self.hold_folders_at_start()
    }

    fn new(load: Load, settings: Settings, parts: Parts, since: Timestamp) -> Self {
        let (sender, events) = unbounded_channel();
        Self {
            load,
            owner: parts.owner,
            ledger: parts.ledger,
            meshes: Meshes {
                shelf: Shelf::default(),
                store: parts.store,
                limits: settings.limits.clone(),
                cache: None,
            },
            stations: BTreeMap::new(),
            jobs: Jobs::new(sender),
            nest_slots: 1,
            claims: HashMap::new(),
            read_again: BackOff::default(),
            reads_begun: 0,
            fresh_builds: HashSet::new(),
            finals: HashMap::new(),
            failures: HashMap::new(),
            resting: BackOff::default(),
            steps: BackOff::default(),
            stopping: false,
            quiet: Quiet::default(),
            started_at: since,
            status_line: "opening".to_owned(),
            shown_at: None,
            watcher: None,
            sign_of_life: None,
            tidy_at: Instant::now() + super::tidy::FIRST_TIDY_AFTER,
            last_watch_check: Instant::now(),
            last_claims: Instant::now(),
            complaints: Complaints::default(),
            events,
            _lock: parts.lock,
            last_hold: Instant::now(),
            settings,
        }
    }

    async fn serve(&mut self, signals: &mut Signals) -> Result<()> {
        let mut beat = tokio::time::interval(BEAT);
        beat.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                signal = signals.next() => match signal {
                    Signal::Stop => return Ok(()),
                    Signal::Reload => self.reload().await,
                },
                Some(event) = self.events.recv() => self.on_events(event).await,
                _ = beat.tick() => {}
            }
            self.beat().await;
        }
    }

    /// One beat: every step does what there is to do. A step that fails is logged and tried again at the next beat.
    pub(super) async fn beat(&mut self) {
        sd::alive();
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
            self.check_watch();
        }
        if self.last_hold.elapsed() >= super::owner::BEAT_EVERY {
            self.last_hold = Instant::now();
            self.keep_holds();
        }
        if self.last_claims.elapsed() >= CLAIMS_AGAIN {
            self.last_claims = Instant::now();
            self.tell("settling claims", Self::settle_claims).await;
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

    async fn tell(&mut self, what: &str, step: impl AsyncFnOnce(&mut Self) -> Result<()>) {
        if self.steps.rests(&what.to_owned()) {
            return;
        }
        match step(self).await {
            Ok(()) => {
                self.steps.done(&what.to_owned());
                self.complaints.settled(what);
            }
            Err(failure) => {
                self.steps.failed(what.to_owned());
                self.complain(what, &format!("The step {what} failed and is tried again: {failure:#}"));
            }
        }
    }

    /// Logs an error once, and again only when it changes or lasts.
    pub(super) fn complain(&mut self, about: &str, text: &str) {
        self.complaints.note(about, text);
    }

    /// Takes in an event and those that wait behind it: one beat serves them all.
    async fn on_events(&mut self, first: Event) {
        self.on_event(first).await;
        for _ in 0..EVENTS_PER_BEAT {
            let Ok(event) = self.events.try_recv() else { return };
            self.on_event(event).await;
        }
    }

    async fn on_event(&mut self, event: Event) {
        let result = match event {
            Event::Look => {
                self.look_soon();
                Ok(())
            }
            Event::Received { profile, gate, received } => self.on_received(&profile, gate, received).await,
            Event::Read { part, outcome } => self.on_read(part, outcome).await,
            Event::Improved { profile, round, nested } => self.on_improved(&profile, round, nested).await,
            Event::Written { build, written } => self.on_written(build, written).await,
            Event::Published { build, published } => self.on_published(build, published).await,
            Event::Held { profile, holds } => {
                self.on_held(&profile, *holds);
                Ok(())
            }
            Event::NotStarted { key, why } => {
                self.on_not_started(key, &why);
                Ok(())
            }
            Event::Purged => {
                self.jobs.ended(&JobKey::Purge);
                Ok(())
            }
            Event::Panicked { key, message } => self.on_panicked(key, &message).await,
        };
        if let Err(failure) = result {
            error!("An event could not be taken in; its step finds the work again: {failure:#}.");
        }
    }

    async fn on_panicked(&mut self, key: JobKey, message: &str) -> Result<()> {
        error!("A job panicked ({key:?}): {message}.");
        self.jobs.ended(&key);
        match key {
            JobKey::Receive(name) => {
                self.new_gate(&name);
                Ok(())
            }
            JobKey::Read(part) => {
                let outcome = super::read::ReadOutcome::Refused(format!("The reader failed on it: {message}."));
                self.on_read(part, outcome).await
            }
            JobKey::Improve(name) => self.on_search_panicked(&name, message).await,
            JobKey::Final(build) => self.on_final_panicked(build, message).await,
            JobKey::Publish(build) => self.on_published(build, Err(anyhow::anyhow!("panicked: {message}"))).await,
            JobKey::Purge | JobKey::Hold(_) => Ok(()),
        }
    }

    /// Ends searches with what they have found, waits for jobs a little, and keeps the open layouts.
    async fn stop(&mut self) {
        info!("The farm closes.");
        self.stopping = true;
        let deadline = Instant::now() + STOP_WITHIN;
        self.finals.values().for_each(|(budget, _)| budget.cancel());
        self.stations.values().filter_map(|s| s.open.search.as_ref()).for_each(|search| search.budget.cancel());
        while !self.jobs.is_idle() {
            let left = deadline.saturating_duration_since(Instant::now());
            match tokio::time::timeout(left, self.events.recv()).await {
                Ok(Some(event)) => self.on_event(event).await,
                _ => break,
            }
            sd::alive();
        }
        self.keep_layouts().await;
        self.end_holds();
        if let Err(failure) = self.ledger.farewell().await {
            warn!("The ledger could not be told of the stop: {failure}.");
        }
        self.ledger.close().await;
        info!("The farm is closed.");
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

/// What is opened in the state directory.
struct Parts {
    lock: Lock,
    owner: Owner,
    ledger: Ledger,
    store: Store,
}

impl Parts {
    async fn open(settings: &Settings, since: Timestamp) -> Result<Self> {
        std::fs::create_dir_all(&settings.state_dir)
            .with_context(|| format!("creating the state directory {}", settings.state_dir.display()))?;
        let lock = Lock::take(&settings.state_dir, since)?;
        let owner = Owner::of_this_process(&settings.state_dir, since)
            .with_context(|| format!("reading the farm's number in {}", settings.state_dir.display()))?;
        let ledger = Ledger::open(&settings.ledger).await?;
        let store = Store::open(settings.state_dir.join("store"))?;
        Ok(Self { lock, owner, ledger, store })
    }
}

/// Whether what hinders the start may pass by itself: a full disk, a share that hangs.
fn may_pass(failure: &anyhow::Error) -> bool {
    is_of_the_disk(failure)
        || failure.chain().any(|cause| cause.downcast_ref::<LedgerError>().is_some_and(LedgerError::is_of_the_disk))
}
