//! The event loop: it waits, lets every step look for work, takes in the results of jobs, and stops in order. Every
//! step reads the ledger and the disk, so the first tick after a restart is like any other.

use std::time::{Duration, Instant};

use anyhow::Result;
use tracing::{info, warn};

use super::{
    alert::AlertKind,
    alert_registry::ServiceBridge,
    farm::{Farm, TICK_INTERVAL},
    intake_jobs::PartReadJob,
    jobs::LoopEvent,
    lease_clock,
    signals::{DaemonSignal, SignalListener},
    state::Load,
    systemd,
    tidy::TIDY_EVERY,
};

/// Interval of the heartbeats in the ledger.
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(4);
/// How long an orderly stop waits for jobs; the service manager allows 10 s.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(8);
/// Interval of retrying claims that could not be completed.
const CLAIM_RETRY_INTERVAL: Duration = Duration::from_secs(20);
/// Maximum number of events between two ticks, so that commands and signals are handled in between.
const MAX_EVENTS_PER_TICK: usize = 64;
/// While files are read one after the other, the other steps run only at this interval: each of them queries the
/// ledger, and together they cost more than a small file.
const TICK_INTERVAL_WHILE_READING: Duration = Duration::from_millis(100);

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load, outside: ServiceBridge) -> Result<()> {
    let settings = load()?;
    let mut signals = SignalListener::listen()?;
    let Some(mut farm) = Farm::open_with_retry(load, settings, &mut signals).await? else { return Ok(()) };
    farm.lifecycle.services = outside;
    farm.run_tick().await;
    farm.lifecycle.services.set_open(!farm.lifecycle.is_halted);
    systemd::notify_ready(&farm.display.status_line);
    info!(profiles = farm.machines.len(), ledger = %farm.settings.ledger.display(), "The farm is open.");
    let result = farm.run_event_loop(&mut signals).await;
    systemd::notify_stopping();
    farm.shut_down().await;
    result
}

impl Farm {
    async fn run_event_loop(&mut self, signals: &mut SignalListener) -> Result<()> {
        let mut beat = tokio::time::interval(TICK_INTERVAL);
        beat.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut worked_at = Instant::now();
        loop {
            let mut only_read = false;
            tokio::select! {
                signal = signals.next_signal() => match signal {
                    DaemonSignal::Stop => return Ok(()),
                    DaemonSignal::Reload => self.reload_configuration().await,
                },
                Some(event) = self.jobs.next_event() => only_read = self.handle_events(event).await,
                _ = beat.tick() => {}
            }
            if only_read && !self.lifecycle.is_halted && worked_at.elapsed() < TICK_INTERVAL_WHILE_READING {
                self.run_step("reading", Self::start_reading).await;
                if self.jobs.running_subjects::<PartReadJob>().next().is_some() {
                    continue;
                }
            }
            self.run_tick().await;
            worked_at = Instant::now();
        }
    }

    /// One tick: every step does its work. A step that fails is logged and retried at a later tick.
    pub(super) async fn run_tick(&mut self) {
        systemd::notify_watchdog();
        let (time, now) = (self.schedule.time.clone(), self.now());
        self.publish_alerts();
        if !self.lifecycle.is_halted
            && let Err(replaced) = self.ledger.ensure_files_in_place()
        {
            self.abandon_replaced_ledger(&replaced).await;
        }
        if self.lifecycle.is_halted {
            return;
        }
        // This comes first: while this process was suspended, another farm may have taken folders and claims.
        let is_due = time.passed_since(self.schedule.last_renewal) >= lease_clock::renewal_interval();
        self.renew_leases(is_due);
        self.run_step("looking at the clock", Self::handle_clock_change).await;
        self.start_scans();
        if self.may_have_work() {
            self.run_ledger_steps().await;
        }
        if self.display.heartbeat_at.is_none_or(|at| time.passed_since(at) >= HEARTBEAT_INTERVAL) {
            self.display.heartbeat_at = Some(now);
            self.run_step("sign of life", Self::write_heartbeat).await;
        }
        if time.passed_since(self.schedule.last_watch_check).as_secs_f64() >= self.settings.scan_secs {
            self.schedule.last_watch_check = now;
            self.create_missing_folders();
            self.start_folder_comparison();
            self.start_watcher();
            self.start_misplaced_file_search();
        }
        if time.passed_since(self.schedule.last_claim_retry) >= CLAIM_RETRY_INTERVAL {
            self.schedule.last_claim_retry = now;
            self.run_step("settling claims", Self::complete_claims).await;
            self.run_step("looking at damaged files", Self::check_damaged_files).await;
        }
        if now >= self.schedule.tidy_at {
            self.schedule.tidy_at = now + TIDY_EVERY;
            self.run_step("tidying", Self::tidy_up).await;
        }
    }

    /// Runs every step that queries the ledger.
    async fn run_ledger_steps(&mut self) {
        let names: Vec<String> = self.machines.keys().cloned().collect();
        self.run_step("orders", Self::process_commands).await;
        self.run_step("reading", Self::start_reading).await;
        // Fired builds come before open ones, so that they get the free slots first.
        self.run_step("nesting", Self::nest_fired_builds).await;
        for name in names {
            self.run_step(&format!("batching {name}"), async |farm| farm.batch_if_rested(&name).await).await;
        }
        self.run_step("publishing", Self::publish_verified_builds).await;
        self.run_step("status", Self::update_status).await;
    }

    /// Whether a step may find work: a job runs, a machine is not idle, or the ledger has changed.
    fn may_have_work(&mut self) -> bool {
        let is_busy = !self.jobs.is_idle() || !self.nesting.just_fired.is_empty();
        let is_settled = self.machines.values().all(|station| station.is_idle && station.pending_flushes.is_empty());
        let now = self.now();
        let news = self.schedule.ledger_changes.has_changed(&self.settings.ledger, now);
        is_busy || !is_settled || news
    }

    /// Takes in an event and those queued behind it, so that one tick serves them all. Returns whether all of them were
    /// ends of part reads.
    async fn handle_events(&mut self, first: LoopEvent<Self>) -> bool {
        let mut only_read = first.is_end_of::<PartReadJob>();
        self.handle_event(first).await;
        for _ in 0..MAX_EVENTS_PER_TICK {
            let Some(event) = self.jobs.try_next_event() else { break };
            only_read &= event.is_end_of::<PartReadJob>();
            self.handle_event(event).await;
        }
        only_read
    }

    async fn handle_event(&mut self, event: LoopEvent<Self>) {
        if self.lifecycle.is_halted {
            return;
        }
        if let Err(failure) = event.apply_to(self).await {
            self.report_failure(AlertKind::StepFails, "", "taking in what a job has done", &failure);
        }
    }

    /// Ends running searches, waits a short time for jobs, and stores the layouts found so far.
    pub(super) async fn shut_down(&mut self) {
        info!("The farm closes.");
        self.lifecycle.services.set_open(false);
        self.lifecycle.is_stopping = true;
        let deadline = Instant::now() + SHUTDOWN_TIMEOUT;
        self.nesting.final_searches.values().for_each(|(budget, _)| budget.cancel());
        self.machines.values().filter_map(|s| s.open.search.as_ref()).for_each(|search| search.budget.cancel());
        self.wait_for_jobs(deadline).await;
        if self.lifecycle.is_halted {
            self.write_stopped_status().await;
            // Nothing is written into a damaged ledger, and it gets no checksum.
            self.release_leases();
            if self.ledger.ensure_files_in_place().is_ok() {
                self.ledger.close().await;
            }
            return;
        }
        self.save_found_layouts().await;
        self.write_stopped_status().await;
        self.release_leases();
        if let Err(failure) = self.ledger.record_shutdown().await {
            warn!("The stop could not be recorded in the ledger: {failure}.");
        }
        match self.ledger.close_with_checksum().await {
            Ok(true) => {}
            Ok(false) => info!("The ledger has no checksum; the next start checks all of it."),
            Err(failure) => warn!("The ledger could not be closed in order: {failure}."),
        }
        info!("The farm is closed.");
    }

    /// Takes in the results of jobs until none runs, or until the deadline.
    pub(super) async fn wait_for_jobs(&mut self, deadline: Instant) {
        while !self.jobs.is_idle() {
            let left = deadline.saturating_duration_since(Instant::now());
            match tokio::time::timeout(left, self.jobs.next_event()).await {
                Ok(Some(event)) => self.handle_event(event).await,
                _ => break,
            }
            systemd::notify_watchdog();
        }
    }

    /// Stores the layouts of searches that did not end in time.
    async fn save_found_layouts(&mut self) {
        for (build, (_, best)) in &self.nesting.final_searches {
            let found = best.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
            if let Some(layout) = found
                && let Err(failure) = self.save_layout(*build, &layout).await
            {
                warn!(build.id = %build, "The layout of build {build} could not be stored: {failure:#}.");
            }
        }
    }
}
