//! Opening the farm: what must be there and whole before anything is taken.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use tracing::warn;

use super::{
    attention::Attention,
    back_off::BackOff,
    current::demand_current,
    failure::is_of_the_disk,
    farm::{BEAT, Farm},
    jobs::Jobs,
    lock::Lock,
    lost_ledger::{Lost, lost, of_the_ledger},
    meshes::Meshes,
    notices::{Notices, Outside},
    owner::{Owner, OwnerError},
    sd,
    shelf::Shelf,
    signals::{Signal, Signals},
    state::{EndingState, Lifecycle, Load, NestingState, ReadingState, Schedule, ShownState},
    time_source::TimeSource,
};
use crate::{
    access,
    intake::{self, Store},
    ledger::{self, Ledger, LedgerError},
    settings::Settings,
};

impl Farm {
    /// Opens the farm; while the disk of the state folder is full or away, waits for it instead of ending again and again.
    /// `None` = told to stop meanwhile.
    pub(super) async fn open_when_possible(
        load: Load,
        settings: Settings,
        signals: &mut Signals,
    ) -> Result<Option<Self>> {
        let (mut load, mut settings, mut waits, mut notices) = (load, settings, BackOff::default(), Notices::default());
        loop {
            let (back, known, failure) = match Self::open(load, settings, TimeSource::of_this_machine()).await {
                Ok(farm) => return Ok(Some(farm)),
                Err(kept) => kept,
            };
            (load, settings) = (back, known);
            if let Some((kind, detail)) = of_the_ledger(&failure) {
                tell_that_it_does_not_run(&settings, kind, &detail);
            }
            if !may_pass(&failure) {
                return Err(failure);
            }
            let text = format!("the farm cannot be opened now and is tried again: {failure:#}");
            notices.trouble(Attention::StepFails, "", "opening", &text);
            notices.keep(&settings.state_dir);
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
    pub(super) async fn open(
        load: Load,
        settings: Settings,
        time: TimeSource,
    ) -> Result<Self, (Load, Settings, anyhow::Error)> {
        match Parts::open(&settings, &time).await {
            Ok(parts) => {
                let mut farm = Self::new(load, settings, parts, time);
                match farm.open_stations().await {
                    Ok(()) => Ok(farm),
                    Err(failure) => {
                        farm.ledger.close().await;
                        Err((farm.life.load, farm.settings, failure))
                    }
                }
            }
            Err(failure) => Err((load, settings, failure)),
        }
    }

    async fn open_stations(&mut self) -> Result<()> {
        self.compare_clock_with_ledger().await?;
        self.set_up_stations().await?;
        self.make_folders_at_start();
        self.watch();
        self.compare_folders();
        self.hold_folders_at_start()
    }

    fn new(load: Load, settings: Settings, parts: Parts, time: TimeSource) -> Self {
        Self {
            ledger: parts.ledger,
            meshes: Meshes {
                shelf: Shelf::default(),
                store: parts.store,
                limits: settings.limits.clone(),
                prepared: Default::default(),
                cache: None,
                unreadable: Default::default(),
            },
            stations: BTreeMap::new(),
            jobs: Jobs::default(),
            ending: EndingState::default(),
            reading: ReadingState::by(time.clone()),
            nesting: NestingState::by(time.clone()),
            shown: ShownState { line: "opening".to_owned(), ..ShownState::default() },
            life: Lifecycle {
                load,
                owner: parts.owner,
                started_at: time.date(),
                stopping: false,
                is_halted: false,
                outside: Outside::default(),
                _lock: parts.lock,
            },
            notices: Notices::by(time.clone()),
            schedule: Schedule::starting_now(super::tidy::FIRST_TIDY_AFTER, time),
            settings,
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
    async fn open(settings: &Settings, time: &TimeSource) -> Result<Self> {
        let since = time.date();
        settings.files.set();
        access::create_private_folders(&settings.state_dir)
            .with_context(|| format!("creating the state directory {}", settings.state_dir.display()))?;
        let lock = Lock::take(&settings.state_dir, since)?;
        ledger::clear_unfinished(&settings.ledger)?;
        sd::status("looking through the ledger");
        let clock = time.clone();
        let ledger = open_ledger(settings).await?.with_clock(move || clock.date());
        // After the ledger: a farm with a number has had one.
        let owner = Owner::of_this_process(&settings.state_dir, since)
            .with_context(|| format!("reading the farm's number in {}", settings.state_dir.display()))?;
        let store = Store::open(settings.state_dir.join("store"))?;
        Ok(Self { lock, owner, ledger, store })
    }
}

/// Whether what hinders the start may pass by itself: a full disk, a share that hangs.
fn may_pass(failure: &anyhow::Error) -> bool {
    // Another daemon that serves a folder is not waited for: whoever started this one must know.
    let is_served = |cause: &OwnerError| matches!(cause, OwnerError::Other { .. });
    if failure.chain().any(|cause| cause.downcast_ref().is_some_and(is_served)) {
        return false;
    }
    is_of_the_disk(failure)
        || failure.chain().any(|cause| cause.downcast_ref::<LedgerError>().is_some_and(LedgerError::is_of_the_disk))
}

/// The ledger, when it is whole and is this farm's.
async fn open_ledger(settings: &Settings) -> Result<Ledger> {
    let path = &settings.ledger;
    if let Some(detail) = lost(settings) {
        return Err(Lost { detail }.into());
    }
    let ledger = Ledger::open_whole(path).await?;
    if let Err(failure) = demand_current(settings, &ledger).await {
        ledger.close().await;
        return Err(failure);
    }
    Ok(ledger)
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
