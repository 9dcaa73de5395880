//! The event loop: it waits, lets every step look for work, takes in the results of jobs, and stops in order. Every
//! step reads the ledger and the disk, so the first tick after a restart is like any other.

use std::time::{Duration, Instant};

use anyhow::Result;
use jobs::LoopEvent;
use ledger::{Ledger, LedgerError};
use tokio::time::timeout;
use tracing::{info, warn};

use super::{machine_setup, open, status, tidy};
use crate::farm::{
    again::{fetch_originals, revisions, second_copies},
    alerts::alert_registry::{ServiceBridge, ServicePhase},
    core::{
        clock_changes,
        farm::{Farm, TICK_INTERVAL},
        job_events,
        state::Load,
    },
    nodes::{folder_comparison, lease_renewal, watching},
    open_build::{
        batch, nest,
        night_search::{self, NightSearchJob},
    },
    operate::commands,
    process::{
        ledger_changes::LedgerFingerprint,
        signals::{DaemonSignal, SignalListener},
        systemd,
        tick_tasks::TimedTask,
    },
    publish::{build_move, publish, queue_look, withdrawal},
    receive::{
        claim_completion, damaged_files, hurried_scans,
        intake_jobs::{self, PartReadJob},
        scan_jobs,
    },
    recover::ledger_service,
};

/// How long an orderly stop waits for jobs; the service manager allows 15 s.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(8);
/// How long it then waits for its last changes, and again to close the ledger. Another process may hold that.
const LAST_CHANGES_TIMEOUT: Duration = Duration::from_secs(2);
/// Maximum number of events between two ticks, so that commands and signals are handled in between.
const MAX_EVENTS_PER_TICK: usize = 64;
/// While files are read one after the other, the other steps run only at this interval: each of them queries the
/// ledger, and together they cost more than a small file.
const TICK_INTERVAL_WHILE_READING: Duration = Duration::from_millis(100);

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load, outside: ServiceBridge) -> Result<()> {
    let settings = load()?;
    let mut signals = SignalListener::listen()?;
    let Some(mut farm) = open::open_with_retry(load, settings, &mut signals).await? else { return Ok(()) };
    farm.lifecycle.services = outside;
    let ledger = farm.ledger.clone();
    if show_life(&ledger, &mut signals, run_tick(&mut farm)).await.is_some() {
        if !farm.lifecycle.is_halted {
            farm.lifecycle.services.set_phase(ServicePhase::Open);
        }
        systemd::notify_ready(&farm.display.status_line);
        info!(profiles = farm.machines.len(), ledger = %farm.settings.ledger, "The farm is open.");
        run_event_loop(&mut farm, &mut signals).await;
    }
    systemd::notify_stopping();
    shut_down(&mut farm).await;
    Ok(())
}

/// Runs until the daemon is told to stop.
async fn run_event_loop(farm: &mut Farm, signals: &mut SignalListener) {
    let mut ticks = tokio::time::interval(TICK_INTERVAL);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let (ledger, mut worked_at) = (farm.ledger.clone(), Instant::now());
    loop {
        let mut only_read = false;
        tokio::select! {
            signal = signals.next_signal() => match signal {
                DaemonSignal::Stop => return,
                DaemonSignal::Reload => {
                    let reload = machine_setup::reload_configuration(farm);
                    let Some(()) = show_life(&ledger, signals, reload).await else { return };
                }
            },
            Some(event) = farm.jobs.next_event() => {
                let Some(read) = show_life(&ledger, signals, handle_events(farm, event)).await else { return };
                only_read = read;
            }
            _ = ticks.tick() => {}
        }
        if only_read && !farm.lifecycle.is_halted && worked_at.elapsed() < TICK_INTERVAL_WHILE_READING {
            farm.run_step("reading", intake_jobs::start_reading).await;
            if farm.jobs.running_subjects::<PartReadJob>().next().is_some() {
                continue;
            }
        }
        let Some(()) = show_life(&ledger, signals, run_tick(farm)).await else { return };
        worked_at = Instant::now();
    }
}

/// Does work of the loop. As long as it only waits for another process to let go of the ledger, the service manager is told that the
/// daemon lives, and by whom the ledger is held. `None` = the daemon is told to stop meanwhile: the work is cut short as by a crash, before
/// it has changed anything.
async fn show_life<T>(ledger: &Ledger, signals: &mut SignalListener, work: impl Future<Output = T>) -> Option<T> {
    tokio::pin!(work);
    loop {
        tokio::select! {
            done = &mut work => return Some(done),
            () = signals.wait_for_stop(), if ledger.waited_for_lock().is_some() => return None,
            () = tokio::time::sleep(TICK_INTERVAL) => {
                if let Some(holder) = ledger.waited_for_lock() {
                    systemd::notify_watchdog();
                    systemd::notify_status(&format!("waits until {holder} has changed the ledger"));
                }
            }
        }
    }
}

/// One tick: every step does its work. A step that fails is logged and retried at a later tick.
pub(crate) async fn run_tick(farm: &mut Farm) {
    systemd::notify_watchdog();
    let now = farm.now();
    status::publish_alerts(farm);
    if !farm.lifecycle.is_halted
        && let Err(replaced @ (LedgerError::Replaced { .. } | LedgerError::Overwritten { .. })) =
            farm.ledger.ensure_in_place().await
    {
        status::abandon_replaced_ledger(farm, &replaced).await;
    }
    if farm.lifecycle.is_halted || !ledger_service::may_act(farm) {
        return;
    }
    // This comes first: while this process was suspended, another farm may have taken folders and claims.
    let is_due = farm.schedule.tasks.is_due(TimedTask::RenewLeases, now);
    lease_renewal::renew_leases(farm, is_due);
    farm.run_step("looking at the clock", clock_changes::handle_clock_change).await;
    scan_jobs::start_scans(farm);
    if may_have_work(farm).await {
        run_ledger_steps(farm).await;
    }
    // What only uses time that nobody needs comes after everything that may need it.
    farm.run_step("lowering open builds", night_search::search_waiting_builds).await;
    for task in farm.schedule.tasks.due_tasks(now) {
        run_timed_task(farm, task, now).await;
    }
}

async fn run_timed_task(farm: &mut Farm, task: TimedTask, now: Instant) {
    farm.schedule.tasks.record_done(task, now, farm.settings.scan_secs);
    match task {
        TimedTask::RenewLeases => lease_renewal::renew_leases(farm, true),
        TimedTask::WriteHeartbeat => farm.run_step("sign of life", status::write_heartbeat).await,
        TimedTask::CheckFolders => {
            farm.run_step("machines of other nodes", machine_setup::take_free_machines).await;
            watching::create_missing_folders(&mut farm.machines, &mut farm.jobs);
            folder_comparison::start_folder_comparison(farm);
            farm.run_step("looking at the queues", queue_look::look_at_queues).await;
            watching::start_watcher(farm);
            farm.run_step("looking beside the hot folders", tidy::start_misplaced_file_search).await;
        }
        TimedTask::RetryClaims => {
            farm.run_step("settling claims", claim_completion::complete_claims).await;
            farm.run_step("looking at damaged files", damaged_files::check_damaged_files).await;
        }
        TimedTask::CopyFiles => farm.run_step("second copies", second_copies::keep_second_copies).await,
        TimedTask::TidyUp => farm.run_step("tidying", tidy::tidy_up).await,
    }
}

/// Runs every step that queries the ledger.
async fn run_ledger_steps(farm: &mut Farm) {
    let names: Vec<String> = farm.machines.keys().cloned().collect();
    farm.run_step("commands", commands::process_commands).await;
    farm.run_step("ordered lines", hurried_scans::hurry_scans).await;
    farm.run_step("reading", intake_jobs::start_reading).await;
    farm.run_step("revisions", revisions::take_out_replaced).await;
    farm.run_step("originals", fetch_originals::fetch_originals).await;
    // Fired builds come before open ones, so that they get the free slots first.
    farm.run_step("nesting", nest::nest_fired_builds).await;
    for name in names {
        farm.run_step(&format!("batching {name}"), async |farm| batch::batch_if_rested(farm, &name).await).await;
    }
    farm.run_step("withdrawing builds", withdrawal::withdraw_builds).await;
    farm.run_step("publishing", publish::publish_verified_builds).await;
    farm.run_step("moving builds", build_move::move_builds).await;
    farm.run_step("status", status::update_status).await;
}

/// Whether a step may find work: a job runs, a machine is not idle, or the ledger has changed.
async fn may_have_work(farm: &mut Farm) -> bool {
    let is_busy = !farm.jobs.runs_only::<NightSearchJob>() || !farm.nesting.just_fired.is_empty();
    let is_settled = farm.machines.values().all(|machine| machine.pacing.is_idle && machine.pending_flushes.is_empty());
    let (now, mark) = (farm.now(), LedgerFingerprint::take(&farm.ledger).await);
    let news = farm.schedule.ledger_changes.has_changed(mark, now);
    is_busy || !is_settled || news
}

/// Takes in an event and those queued behind it, so that one tick serves them all. Returns whether all of them were
/// ends of part reads.
async fn handle_events(farm: &mut Farm, first: LoopEvent<Farm>) -> bool {
    let mut only_read = first.is_end_of::<PartReadJob>();
    job_events::handle_event(farm, first).await;
    for _ in 0..MAX_EVENTS_PER_TICK {
        let Some(event) = farm.jobs.try_next_event() else { break };
        only_read &= event.is_end_of::<PartReadJob>();
        job_events::handle_event(farm, event).await;
    }
    only_read
}

/// Ends running searches, waits a short time for jobs, and stores the layouts found so far. What is cut short, because another process
/// holds the ledger, is done after the next start, as after a crash.
pub(crate) async fn shut_down(farm: &mut Farm) {
    info!("The farm closes.");
    farm.lifecycle.services.set_phase(ServicePhase::Closed);
    farm.lifecycle.is_stopping = true;
    let deadline = Instant::now() + SHUTDOWN_TIMEOUT;
    farm.nesting.searches.stop_all();
    let _ = timeout(SHUTDOWN_TIMEOUT, job_events::wait_for_jobs(farm, deadline)).await;
    if farm.lifecycle.is_halted {
        status::write_stopped_status(farm).await;
        // Nothing is written into a damaged ledger, and it gets no checksum.
        lease_renewal::release_leases(&mut farm.machines, &mut farm.alerts);
        farm.alerts.write_if_changed(&farm.settings.state_dir);
        if farm.ledger.ensure_files_in_place().is_ok() {
            farm.ledger.close().await;
        }
        return;
    }
    status::write_stopped_status(farm).await;
    lease_renewal::release_leases(&mut farm.machines, &mut farm.alerts);
    farm.alerts.write_if_changed(&farm.settings.state_dir);
    let last_changes = async {
        save_found_layouts(farm).await;
        if let Err(failure) = farm.ledger.record_shutdown(&farm.settings.node.name).await {
            warn!("The stop could not be recorded in the ledger: {failure}.");
        }
    };
    let _ = timeout(LAST_CHANGES_TIMEOUT, last_changes).await;
    match timeout(LAST_CHANGES_TIMEOUT, farm.ledger.close_with_checksum()).await {
        Ok(Ok(true)) => {}
        Ok(Ok(false)) => info!("The ledger has no checksum; the next start checks all of it."),
        Ok(Err(failure)) => warn!("The ledger could not be closed in order: {failure}."),
        Err(_) => info!("Another process holds the ledger, so it has no checksum; the next start checks all of it."),
    }
    info!("The farm is closed.");
}

/// Stores the layouts of searches that did not end in time.
async fn save_found_layouts(farm: &mut Farm) {
    for (build, layout) in farm.nesting.searches.found_layouts() {
        if let Err(failure) = batch::save_layout(&farm.ledger, build, &layout).await {
            warn!(build.id = %build, "The layout of build {build} could not be stored: {failure:#}.");
        }
    }
}
