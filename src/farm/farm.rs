//! The farm: its state, its event loop and its orderly stop. Every step looks into the ledger and onto the disk for its
//! work, so a beat after a restart is the same as any other beat.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use jiff::Timestamp;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tracing::{error, info, warn};

use super::{
    budget::Budget,
    cache::DiskCache,
    event::Event,
    jobs::{JobKey, Jobs},
    lock::Lock,
    nest::{Best, Meshes},
    quiet::Quiet,
    sd,
    shelf::Shelf,
    signals::{Signal, Signals},
    station::Station,
};
use crate::{
    access,
    intake::{Claim, Store, Watcher},
    ledger::{BuildId, Ledger, PartId},
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
/// Different complaints remembered at most.
const MAX_COMPLAINTS: usize = 1000;
/// The same complaint is logged again after so long.
const COMPLAIN_AGAIN: Duration = Duration::from_secs(600);

/// Reads the configuration, at start and at each reload.
pub type Load = Box<dyn Fn() -> Result<Settings, SettingsError> + Send>;

/// The running farm.
pub struct Farm {
    pub(super) load: Load,
    pub(super) settings: Settings,
    pub(super) ledger: Ledger,
    pub(super) meshes: Meshes,
    pub(super) stations: BTreeMap<String, Station>,
    pub(super) jobs: Jobs,
    /// Searches that may run at once.
    pub(super) nest_slots: usize,
    /// Claims whose originals still lie in the hot folder's `.claimed`, by claim id.
    pub(super) claims: HashMap<String, Claim>,
    /// Parts whose reading failed for the disk's sake, and when to try again.
    pub(super) read_again: HashMap<PartId, Instant>,
    /// Builds fired by this process that have not been begun.
    pub(super) fresh_builds: HashSet<BuildId>,
    /// Final searches that run.
    pub(super) finals: HashMap<BuildId, (Budget, Best)>,
    /// How often the making of builds has failed in this run, and why last.
    pub(super) failures: HashMap<BuildId, (u32, String)>,
    /// Builds that failed are not touched before this time.
    pub(super) rest_until: HashMap<BuildId, Instant>,
    pub(super) stopping: bool,
    pub(super) quiet: Quiet,
    pub(super) started_at: Timestamp,
    pub(super) status_line: String,
    pub(super) shown_at: Option<Instant>,
    watcher: Option<Watcher>,
    sign_of_life: Option<Instant>,
    tidy_at: Instant,
    last_watch_check: Instant,
    last_claims: Instant,
    complaints: HashMap<String, (String, Instant)>,
    events: UnboundedReceiver<Event>,
    _lock: Lock,
}

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load) -> Result<()> {
    let settings = load()?;
    let mut signals = Signals::listen()?;
    let mut farm = Farm::open(load, settings).await?;
    farm.beat().await;
    sd::ready(&farm.status_line);
    info!(profiles = farm.stations.len(), ledger = %farm.settings.ledger.display(), "The farm is open.");
    let result = farm.serve(&mut signals).await;
    sd::stopping();
    farm.stop().await;
    result
}

impl Farm {
    async fn open(load: Load, settings: Settings) -> Result<Self> {
        settings.files.set();
        access::create_private_folders(&settings.state_dir)
            .with_context(|| format!("creating the state directory {}", settings.state_dir.display()))?;
        let lock = Lock::take(&settings.state_dir)?;
        let ledger = Ledger::open_whole(&settings.ledger).await?;
        let store = Store::open(settings.state_dir.join("store"))?;
        let (sender, events) = unbounded_channel();
        let mut farm = Self {
            load,
            ledger,
            meshes: Meshes { shelf: Shelf::default(), store, limits: settings.limits.clone(), cache: None },
            stations: BTreeMap::new(),
            jobs: Jobs::new(sender),
            nest_slots: 1,
            claims: HashMap::new(),
            read_again: HashMap::new(),
            fresh_builds: HashSet::new(),
            finals: HashMap::new(),
            failures: HashMap::new(),
            rest_until: HashMap::new(),
            stopping: false,
            quiet: Quiet::default(),
            started_at: Timestamp::now(),
            status_line: "opening".to_owned(),
            shown_at: None,
            watcher: None,
            sign_of_life: None,
            tidy_at: Instant::now() + super::tidy::FIRST_TIDY_AFTER,
            last_watch_check: Instant::now(),
            last_claims: Instant::now(),
            complaints: HashMap::new(),
            events,
            _lock: lock,
            settings,
        };
        farm.set_up_stations().await?;
        Ok(farm)
    }

    /// Makes stations and the watcher agree with the settings.
    pub(super) async fn set_up_stations(&mut self) -> Result<()> {
        self.meshes.limits = self.settings.limits.clone();
        self.meshes.cache = DiskCache::of_farm(&self.settings).map(Arc::new);
        self.nest_slots = nest_slots(&self.settings);
        let gone: Vec<String> =
            self.stations.keys().filter(|name| !self.settings.profiles.contains_key(*name)).cloned().collect();
        for name in gone {
            if let Some(mut station) = self.stations.remove(&name) {
                station.open.clear();
                info!(profile = %name, "The profile is no longer configured; its waiting parts stay in the ledger.");
            }
        }
        for (name, profile) in self.settings.profiles.clone() {
            // A share that is away must not keep the other machines from working.
            if let Err(failure) = make_folders(&profile) {
                self.complain(
                    &format!("folders of {name}"),
                    &format!("The folders of {name} cannot be made: {failure:#}"),
                );
            }
            match self.stations.get_mut(&name) {
                Some(station) if *station.profile == profile => {}
                Some(station) => {
                    // Another volume or clearance makes the layout worthless; another hot folder needs another gate.
                    let row = self.ledger.open_build(&name).await?;
                    let mut fresh = Station::new(Arc::new(profile), self.settings.orphan_ticket_secs, &row);
                    fresh.open.layout = Default::default();
                    station.open.clear();
                    fresh.paused = station.paused;
                    fresh.flush = std::mem::take(&mut station.flush);
                    *station = fresh;
                    info!(profile = %name, "The profile has changed.");
                }
                None => {
                    let row = self.ledger.open_build(&name).await?;
                    let station = Station::new(Arc::new(profile), self.settings.orphan_ticket_secs, &row);
                    self.stations.insert(name, station);
                }
            }
        }
        self.watch();
        Ok(())
    }

    fn watch(&mut self) {
        let inboxes = self.stations.values().map(|s| s.profile.folders.inbox.clone()).collect();
        let events = self.jobs.events();
        self.watcher = match Watcher::start(inboxes, move || drop(events.send(Event::Look))) {
            Ok(watcher) => Some(watcher),
            Err(failure) => {
                warn!("No file-system events; the periodic scan goes on without them: {failure}.");
                None
            }
        };
    }

    /// Watches hot folders that were made anew; where that cannot be, the periodic scan serves.
    fn check_watch(&mut self) {
        let unwatched = self.watcher.as_mut().map(Watcher::check).unwrap_or_default();
        for (path, why) in unwatched {
            tracing::debug!(inbox = %path.display(), "No file-system events from a hot folder: {why}.");
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
                Some(event) = self.events.recv() => self.on_event(event).await,
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
            self.check_watch();
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
            if let Err(failure) = self.batch(&name).await {
                self.complain(&format!("batching {name}"), &format!("Batching for {name} failed: {failure:#}"));
            }
        }
        self.tell("publishing", Self::publish).await;
        self.tell("status", Self::show_status).await;
    }

    async fn tell(&mut self, what: &str, step: impl AsyncFnOnce(&mut Self) -> Result<()>) {
        match step(self).await {
            Ok(()) => drop(self.complaints.remove(what)),
            Err(failure) => self.complain(what, &format!("The step {what} failed and is tried again: {failure:#}")),
        }
    }

    /// Logs an error once, and again only when it changes or lasts.
    pub(super) fn complain(&mut self, about: &str, text: &str) {
        let known = self.complaints.get(about);
        if known.is_some_and(|(said, at)| said == text && at.elapsed() < COMPLAIN_AGAIN) {
            return;
        }
        error!("{}.", text.trim_end_matches('.'));
        if self.complaints.len() >= MAX_COMPLAINTS {
            self.complaints.clear();
        }
        self.complaints.insert(about.to_owned(), (text.to_owned(), Instant::now()));
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
                if let Some(station) = self.stations.get_mut(&name) {
                    let gate = super::receive::Gate::new(&station.profile, self.settings.orphan_ticket_secs);
                    station.gate = Some(Box::new(gate));
                    station.look_at = Instant::now() + Duration::from_secs_f64(self.settings.scan_secs);
                }
                Ok(())
            }
            JobKey::Read(part) => {
                let outcome = super::read::ReadOutcome::Refused(format!("The reader failed on it: {message}."));
                self.on_read(part, outcome).await
            }
            JobKey::Improve(name) => self.on_search_panicked(&name, message).await,
            JobKey::Final(build) => self.on_final_panicked(build, message).await,
            JobKey::Publish(build) => self.on_published(build, Err(anyhow::anyhow!("panicked: {message}"))).await,
            JobKey::Purge => Ok(()),
        }
    }

    async fn reload(&mut self) {
        sd::reloading();
        match (self.load)() {
            Ok(settings)
                if settings.ledger != self.settings.ledger || settings.state_dir != self.settings.state_dir =>
            {
                error!(
                    "The state directory and the ledger cannot change while the daemon runs; the old configuration stays."
                );
            }
            Ok(settings) => {
                settings.files.set();
                self.settings = settings;
                match self.set_up_stations().await {
                    Ok(()) => info!(profiles = self.stations.len(), "The configuration was read again."),
                    Err(failure) => error!("The new configuration could not be set up: {failure:#}."),
                }
            }
            Err(failure) => error!("The new configuration is wrong; the old one stays: {failure:#}."),
        }
        sd::ready(&self.status_line);
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

/// Searches that may run at once: the threads of the farm over those of the greediest profile.
fn nest_slots(settings: &Settings) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all = if settings.threads == 0 { cores } else { settings.threads };
    let each = settings.profiles.values().map(|p| if p.nest.threads == 0 { all } else { p.nest.threads }).max();
    (all / each.unwrap_or(1).max(1)).max(1)
}

fn make_folders(profile: &crate::settings::Profile) -> Result<()> {
    let folders = &profile.folders;
    for folder in [&folders.inbox, &folders.queue, &folders.error, &folders.archive] {
        access::create_folders(folder).with_context(|| format!("creating {}", folder.display()))?;
    }
    Ok(())
}
