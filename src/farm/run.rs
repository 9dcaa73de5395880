//! The event loop: it waits, lets every step look for its work, takes in what jobs have done, and stops in order. Every step
//! looks into the ledger and onto the disk, so a beat after a restart is the same as any other beat.

use std::time::{Duration, Instant};

use anyhow::Result;
use tracing::{info, warn};

use super::{
    attention::Attention,
    claimed::ReadJob,
    farm::{BEAT, Farm},
    jobs::Event,
    lease,
    notices::Outside,
    sd,
    signals::{Signal, Signals},
    state::Load,
    tidy::TIDY_EVERY,
};

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

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load, outside: Outside) -> Result<()> {
    let settings = load()?;
    let mut signals = Signals::listen()?;
    let Some(mut farm) = Farm::open_when_possible(load, settings, &mut signals).await? else { return Ok(()) };
    farm.life.outside = outside;
    farm.beat().await;
    farm.life.outside.set_open(!farm.life.is_halted);
    sd::ready(&farm.shown.line);
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
                Some(event) = self.jobs.next() => only_read = self.on_events(event).await,
                _ = beat.tick() => {}
            }
            if only_read && !self.life.is_halted && worked_at.elapsed() < BEAT_WHILE_READING {
                self.tell("reading", Self::read).await;
                if self.jobs.running::<ReadJob>().next().is_some() {
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
        let (time, now) = (self.schedule.time.clone(), self.now());
        self.tell_people();
        if !self.life.is_halted
            && let Err(replaced) = self.ledger.demand_in_place()
        {
            self.leave_ledger(&replaced).await;
        }
        if self.life.is_halted {
            return;
        }
        // Before anything else: while this process stood still, another farm may have taken folders and claims.
        let is_due = time.passed_since(self.schedule.last_hold) >= lease::beat_every();
        self.keep_holds(is_due);
        self.tell("looking at the clock", Self::look_at_clock).await;
        self.receive();
        if self.may_have_work() {
            self.work().await;
        }
        if self.shown.sign_of_life.is_none_or(|at| time.passed_since(at) >= SIGN_OF_LIFE) {
            self.shown.sign_of_life = Some(now);
            self.tell("sign of life", Self::sign_of_life).await;
        }
        if time.passed_since(self.schedule.last_watch_check).as_secs_f64() >= self.settings.scan_secs {
            self.schedule.last_watch_check = now;
            self.make_missing_folders();
            self.compare_folders();
            self.watch();
            self.look_for_stray_files();
        }
        if time.passed_since(self.schedule.last_claims) >= CLAIMS_AGAIN {
            self.schedule.last_claims = now;
            self.tell("settling claims", Self::settle_claims).await;
            self.tell("looking at damaged files", Self::look_at_damaged).await;
        }
        if now >= self.schedule.tidy_at {
            self.schedule.tidy_at = now + TIDY_EVERY;
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

    /// Whether a step may find work: something runs or is not settled, or the ledger has news.
    fn may_have_work(&mut self) -> bool {
        let is_busy = !self.jobs.is_idle() || !self.nesting.fresh.is_empty();
        let is_settled = self.stations.values().all(|station| station.is_settled && station.flush.is_empty());
        let now = self.now();
        let news = self.schedule.quiet.has_news(&self.settings.ledger, now);
        is_busy || !is_settled || news
    }

    /// Takes in an event and those that wait behind it: one beat serves them all. Returns whether all told of parts that were
    /// read.
    async fn on_events(&mut self, first: Event<Self>) -> bool {
        let mut only_read = first.is_of::<ReadJob>();
        self.on_event(first).await;
        for _ in 0..EVENTS_PER_BEAT {
            let Some(event) = self.jobs.next_now() else { break };
            only_read &= event.is_of::<ReadJob>();
            self.on_event(event).await;
        }
        only_read
    }

    async fn on_event(&mut self, event: Event<Self>) {
        if self.life.is_halted {
            return;
        }
        if let Err(failure) = event.take_in(self).await {
            self.trouble(Attention::StepFails, "", "taking in what a job has done", &failure);
        }
    }

    /// Ends searches with what they have found, waits for jobs a little, and keeps the open layouts.
    pub(super) async fn stop(&mut self) {
        info!("The farm closes.");
        self.life.outside.set_open(false);
        self.life.stopping = true;
        let deadline = Instant::now() + STOP_WITHIN;
        self.nesting.finals.values().for_each(|(budget, _)| budget.cancel());
        self.stations.values().filter_map(|s| s.open.search.as_ref()).for_each(|search| search.budget.cancel());
        self.wait_for_jobs(deadline).await;
        if self.life.is_halted {
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
            match tokio::time::timeout(left, self.jobs.next()).await {
                Ok(Some(event)) => self.on_event(event).await,
                _ => break,
            }
            sd::alive();
        }
    }

    /// What searches have found that did not end in time.
    async fn keep_layouts(&mut self) {
        for (build, (_, best)) in &self.nesting.finals {
            let found = best.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
            if let Some(layout) = found
                && let Err(failure) = self.save_layout(*build, &layout).await
            {
                warn!(build.id = %build, "Its layout could not be kept: {failure:#}.");
            }
        }
    }
}
