//! Opening the farm: what must be there and whole before anything is taken, and stations for the machines.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    sync::Arc,
    time::Instant,
};

use anyhow::{Context, Result};
use jiff::Timestamp;
use tokio::sync::mpsc::unbounded_channel;
use tracing::{info, warn};

use super::{
    attention::Attention,
    cache::DiskCache,
    clock::Clock,
    event::Event,
    farm::{Farm, Load},
    jobs::Jobs,
    lock::Lock,
    nest::Meshes,
    notices::Notices,
    quiet::Quiet,
    reconcile::{Behind, demand_current},
    sd,
    shelf::Shelf,
    station::Station,
};
use crate::{
    access,
    intake::{self, Store, Watcher},
    ledger::{Ledger, LedgerError},
    settings::{Profile, Settings},
};

impl Farm {
    /// Opens the farm: lock, ledger, store, stations. A farm that cannot be opened for its ledger's sake says so where
    /// people look.
    pub(super) async fn open(load: Load, settings: Settings) -> Result<Self> {
        settings.files.set();
        access::create_private_folders(&settings.state_dir)
            .with_context(|| format!("creating the state directory {}", settings.state_dir.display()))?;
        let lock = Lock::take(&settings.state_dir)?;
        sd::status("looking through the ledger");
        let ledger = match open_ledger(&settings).await {
            Ok(ledger) => ledger,
            Err(failure) => {
                if let Some((kind, detail)) = of_the_ledger(&failure) {
                    tell_that_it_does_not_run(&settings, kind, &detail);
                }
                return Err(failure);
            }
        };
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
            clock: Clock::of_this_machine(),
            started_at: Timestamp::now(),
            status_line: "opening".to_owned(),
            shown_at: None,
            watcher: None,
            sign_of_life: None,
            tidy_at: Instant::now() + super::tidy::FIRST_TIDY_AFTER,
            last_watch_check: Instant::now(),
            last_claims: Instant::now(),
            notices: Notices::default(),
            is_halted: false,
            events,
            _lock: lock,
            settings,
        };
        farm.compare_clock_with_ledger().await?;
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
                self.notices.forget_machine(&name);
                info!(profile = %name, "The profile is no longer configured; its waiting parts stay in the ledger.");
            }
        }
        for (name, profile) in self.settings.profiles.clone() {
            // A share that is away must not keep the other machines from working.
            match make_folders(&profile) {
                Ok(()) => self.notices.clear(Attention::FoldersMissing, &name, ""),
                Err(failure) => self.notices.raise(Attention::FoldersMissing, &name, "", &format!("{failure:#}")),
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
    pub(super) fn check_watch(&mut self) {
        let unwatched = self.watcher.as_mut().map(Watcher::check).unwrap_or_default();
        for (path, why) in unwatched {
            tracing::debug!(inbox = %path.display(), "No file-system events from a hot folder: {why}.");
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

fn make_folders(profile: &Profile) -> Result<()> {
    let folders = &profile.folders;
    for folder in [&folders.inbox, &folders.queue, &folders.error, &folders.archive] {
        access::create_folders(folder).with_context(|| format!("creating {}", folder.display()))?;
    }
    Ok(())
}

/// The ledger is gone, and its farm is not.
#[derive(Debug, thiserror::Error)]
#[error("{detail}. {}", Attention::LedgerLost.remedy())]
struct Lost {
    detail: String,
}

/// The ledger, when it is whole and is this farm's.
async fn open_ledger(settings: &Settings) -> Result<Ledger> {
    let path = &settings.ledger;
    if !std::fs::metadata(path).is_ok_and(|meta| meta.len() > 0) && holds_files(&settings.state_dir.join("store")) {
        let detail = format!("there is no ledger at {}, but files that were taken are in the store", path.display());
        return Err(Lost { detail }.into());
    }
    let ledger = Ledger::open_whole(path).await?;
    if let Err(failure) = demand_current(settings, &ledger).await {
        ledger.close().await;
        return Err(failure);
    }
    Ok(ledger)
}

/// What a failure is to people, if it is the ledger's: the kind of notice, and what was found.
pub fn of_the_ledger(failure: &anyhow::Error) -> Option<(Attention, String)> {
    if let Some(Lost { detail }) = failure.downcast_ref() {
        return Some((Attention::LedgerLost, detail.clone()));
    }
    if let Some(Behind { detail }) = failure.downcast_ref() {
        return Some((Attention::LedgerBehind, detail.clone()));
    }
    failure.chain().find_map(|error| match error.downcast_ref()? {
        LedgerError::Damaged { path, what } => Some((Attention::LedgerDamaged, format!("{}: {what}", path.display()))),
        LedgerError::Corrupt(what) => Some((Attention::LedgerDamaged, what.clone())),
        _ => None,
    })
}

fn holds_files(folder: &std::path::Path) -> bool {
    intake::files_below(folder).is_ok_and(|files| !files.is_empty())
}

/// Tells in the journal, for `nestd status` and in every hot folder that the daemon does not run, and why.
fn tell_that_it_does_not_run(settings: &Settings, kind: Attention, detail: &str) {
    let mut notices = Notices::default();
    notices.raise(kind, "", "", detail);
    notices.keep(&settings.state_dir);
    for (name, profile) in &settings.profiles {
        let text = format!("{name}: nestd does not run; what is dropped here waits.\n{}", notices.text_for(name));
        let json = serde_json::json!({ "profile": name, "runs": false, "attention": notices.json_for(name) });
        if let Err(error) = intake::write_status(&profile.folders.inbox, &text, &format!("{json:#}\n")) {
            warn!("{} could not be told: {error}.", profile.folders.inbox.display());
        }
    }
}
