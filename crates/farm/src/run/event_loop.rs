//! The event loop: it waits, lets every step look for work, takes in the results of jobs, and stops in order. Every
//! step reads the ledger and the disk, so the first tick after a restart is like any other.

use std::time::{Duration, Instant};

use anyhow::Result;
use jobs::LoopEvent;
use ledger::{Ledger, LedgerError};
use tokio::time::timeout;
use tracing::{info, warn};

use super::{
    machine_setup, open, reload, status, tidy,
    unserved::{self, STOPPED_STATUS_TIMEOUT},
};
use crate::{
    again::{fetch_originals, revisions, second_copies},
    alerts::service_bridge::{ServiceBridge, ServicePhase},
    core::{
        clock_changes,
        farm::{Farm, TICK_INTERVAL},
        job_events,
        state::Load,
    },
    files::judged_file::JudgedFiles,
    nodes::{folder_comparison, lease_renewal, watching},
    open_build::{batch, nest, night_search},
    operate::commands,
    process::{
        signals::{DaemonSignal, SignalListener},
        systemd,
        tick_tasks::TimedTask,
    },
    publish::{publish, queue_look, take_back},
    receive::{
        claim_completion::{self, ClaimCompletionJob},
        damaged_files, hurried_scans,
        intake_jobs::{self, PartReadJob},
        scan_jobs,
    },
    recover::ledger_service,
};

/// How long an orderly stop waits for jobs. With the other times of a stop it makes nine seconds: whoever asked for it may kill the daemon
/// after ten, and the service manager does after 15.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(5);
/// How long it then waits for its last changes, and as long again to close the ledger. Another process may hold that.
const LAST_CHANGES_TIMEOUT: Duration = Duration::from_millis(1500);
/// Maximum number of events between two ticks, so that commands and signals are handled in between.
const MAX_EVENTS_PER_TICK: usize = 64;
/// While files are read one after the other, the other steps run only at this interval: each of them queries the
/// ledger, and together they cost more than many small files.
const TICK_INTERVAL_WHILE_READING: Duration = Duration::from_millis(250);

/// The ledger is looked at so often for work that only depends on the time, while work is under way.
const LOOK_WHILE_WORKING: Duration = Duration::from_secs(2);
/// The same while none is.
const LOOK_AT_REST: Duration = Duration::from_secs(120);

/// Runs the daemon until it is told to stop.
pub async fn run(load: Load, outside: ServiceBridge, judged: JudgedFiles) -> Result<()> {
    let settings = load()?;
    outside.adopt_settings(&settings);
    let mut signals = SignalListener::listen()?;
    let Some(mut farm) = open::open_with_retry(load, settings, &mut signals).await? else { return Ok(()) };
    farm.meshes.judged = judged;
    farm.lifecycle.services = outside;
    let ledger = farm.ledger.clone();
    if show_life(&ledger, &mut signals, run_tick(&mut farm)).await.is_some() {
        if !farm.lifecycle.is_halted {
            farm.lifecycle.services.set_phase(ServicePhase::Open);
        }
        systemd::notify_ready(&farm.display.status_line);
        info!(machines = farm.machines.len(), ledger = %farm.settings.ledger, "The farm is open.");
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
                    let reload = reload::reload_configuration(farm);
                    let Some(()) = show_life(&ledger, signals, reload).await else { return };
                }
            },
            Some(event) = farm.jobs.next_event() => {
                // What does not answer is told before the end of a job waits for it, too.
                if farm.ledger.is_out_of_reach() {
                    may_act(farm);
                }
                let Some(read) = show_life(&ledger, signals, handle_events(farm, event)).await else { return };
                only_read = read;
            }
            _ = ticks.tick() => {}
        }
        if only_read && !farm.lifecycle.is_halted && worked_at.elapsed() < TICK_INTERVAL_WHILE_READING {
            farm.run_step("reading", async |farm| intake_jobs::start_reading(&mut farm.desk()).await).await;
            if farm.jobs.running_subjects::<PartReadJob>().next().is_some() {
                continue;
            }
        }
        let Some(()) = show_life(&ledger, signals, run_tick(farm)).await else { return };
        worked_at = Instant::now();
    }
}

/// Does work of the loop. As long as it only waits for another process to let go of the ledger, or for the server of the ledger to answer,
/// the service manager is told that the daemon lives, and what it waits for. `None` = the daemon is told to stop meanwhile: the work is
/// cut short as by a crash, before it has changed anything.
async fn show_life<T>(ledger: &Ledger, signals: &mut SignalListener, work: impl Future<Output = T>) -> Option<T> {
    tokio::pin!(work);
    loop {
        tokio::select! {
            done = &mut work => return Some(done),
            () = signals.wait_for_stop(), if ledger.waits_for().is_some() => return None,
            () = tokio::time::sleep(TICK_INTERVAL) => {
                if let Some(what) = ledger.waits_for() {
                    systemd::notify_watchdog();
                    systemd::notify_status(&format!("waits until {what}"));
                }
            }
        }
    }
}

/// One tick: every step does its work. A step that fails is logged and retried at a later tick.
pub(crate) async fn run_tick(farm: &mut Farm) {
    systemd::notify_watchdog();
    let now = farm.now();
    status::publish_alerts(&mut farm.desk()).await;
    if !farm.lifecycle.is_halted
        && let Err(replaced @ (LedgerError::Replaced { .. } | LedgerError::Overwritten { .. })) =
            farm.ledger.ensure_in_place().await
    {
        status::abandon_replaced_ledger(&mut farm.desk(), &replaced).await;
        farm.halt_if_asked();
    }
    if farm.lifecycle.is_halted || !may_act(farm) {
        return;
    }
    // This comes first: while this process was suspended, another farm may have taken folders and claims.
    let is_due = farm.schedule.tasks.is_due(TimedTask::RenewLeases, now);
    lease_renewal::renew_leases(&mut farm.desk(), is_due);
    farm.run_step("looking at the clock", async |farm| clock_changes::handle_clock_change(&mut farm.desk()).await)
        .await;
    reload::take_over_configuration(farm).await;
    scan_jobs::start_scans(&mut farm.desk());
    match may_have_work(farm).await {
        LedgerLook::Everywhere => run_ledger_steps(farm).await,
        LedgerLook::Unfinished => {
            batch_machines(farm, false).await;
            update_status(farm).await;
        }
    }
    // What only uses time that nobody needs comes after everything that may need it.
    farm.run_step("lowering open builds", async |farm| night_search::search_waiting_builds(&mut farm.desk()).await)
        .await;
    for task in farm.schedule.tasks.due_tasks(now) {
        run_timed_task(farm, task, now).await;
    }
}

async fn run_timed_task(farm: &mut Farm, task: TimedTask, now: Instant) {
    farm.schedule.tasks.record_done(task, now, farm.settings.scan_secs);
    match task {
        TimedTask::RenewLeases => lease_renewal::renew_leases(&mut farm.desk(), true),
        TimedTask::WriteHeartbeat => {
            farm.run_step("sign of life", async |farm| status::write_heartbeat(&mut farm.desk()).await).await
        }
        TimedTask::CheckFolders => {
            farm.run_step("machines of other nodes", async |farm| {
                machine_setup::take_free_machines(&mut farm.desk()).await
            })
            .await;
            watching::create_missing_folders(&mut farm.machines, &mut farm.jobs);
            folder_comparison::start_folder_comparison(&mut farm.desk());
            farm.run_step("looking at the queues", async |farm| queue_look::look_at_queues(&mut farm.desk()).await)
                .await;
            watching::start_watcher(&mut farm.desk());
            farm.run_step("looking beside the hot folders", async |farm| {
                tidy::start_misplaced_file_search(&mut farm.desk()).await
            })
            .await;
        }
        TimedTask::RetryClaims => {
            farm.run_step("settling claims", async |farm| claim_completion::complete_claims(&mut farm.desk()).await)
                .await;
            farm.run_step("looking at damaged files", async |farm| {
                damaged_files::check_damaged_files(&mut farm.desk()).await
            })
            .await;
        }
        TimedTask::CopyFiles => {
            farm.run_step("second copies", async |farm| second_copies::keep_second_copies(&mut farm.desk()).await).await
        }
        TimedTask::TidyUp => farm.run_step("tidying", async |farm| tidy::tidy_up(&mut farm.desk()).await).await,
    }
}

/// Runs the steps that look for work in the whole ledger.
async fn run_ledger_steps(farm: &mut Farm) {
    farm.display.is_behind = true;
    farm.machines.values_mut().for_each(|machine| machine.queued = None);
    farm.run_step("commands", async |farm| commands::process_commands(&mut farm.desk()).await).await;
    farm.run_step("ordered lines", async |farm| hurried_scans::hurry_scans(&mut farm.desk()).await).await;
    farm.run_step("reading", async |farm| intake_jobs::start_reading(&mut farm.desk()).await).await;
    farm.run_step("revisions", async |farm| revisions::take_out_replaced(&mut farm.desk()).await).await;
    farm.run_step("originals", async |farm| fetch_originals::fetch_originals(&mut farm.desk()).await).await;
    // Fired builds come before open ones, so that they get the free slots first.
    farm.run_step("nesting", async |farm| nest::nest_fired_builds(&mut farm.desk()).await).await;
    batch_machines(farm, true).await;
    farm.run_step("taking builds back", async |farm| take_back::take_back_builds(&mut farm.desk()).await).await;
    farm.run_step("publishing", async |farm| publish::publish_verified_builds(&mut farm.desk()).await).await;
    update_status(farm).await;
}

/// Keeps the open builds up to date; without news of the ledger, those of machines that are not at rest.
async fn batch_machines(farm: &mut Farm, has_news: bool) {
    let names: Vec<String> = farm.machines.keys().cloned().collect();
    for name in names {
        let step = format!("batching {name}");
        farm.run_step(&step, async |farm| batch::batch_if_rested(&mut farm.desk(), &name, has_news).await).await;
    }
}

async fn update_status(farm: &mut Farm) {
    farm.run_step("status", async |farm| status::update_status(&mut farm.desk()).await).await;
}

/// Whether the farm may act on what its ledger says. What failed while that could not be reached or changed is done at once, and not after
/// the wait that follows a failure.
fn may_act(farm: &mut Farm) -> bool {
    let may_act = ledger_service::may_act(&mut farm.desk());
    farm.halt_if_asked();
    if may_act && std::mem::take(&mut farm.schedule.is_cut_off) {
        farm.schedule.step_backoff.end_waits();
        farm.reading.backoff.end_waits();
        farm.nesting.backoff.end_waits();
        farm.machines.values_mut().for_each(|machine| machine.open.retry_at_once());
        scan_jobs::schedule_scan(&mut farm.desk());
    }
    may_act
}

async fn write_stopped_status(farm: &mut Farm) {
    unserved::write_stopped_status(&mut farm.desk()).await;
    job_events::wait_for_jobs(farm, Instant::now() + STOPPED_STATUS_TIMEOUT).await;
}

/// Where steps look for work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LedgerLook {
    /// In the whole ledger.
    Everywhere,
    /// Where something is unfinished, or is due by now.
    Unfinished,
}

/// Where a step may find work: everywhere when a job runs for whose end something waits, or the ledger may have changed.
async fn may_have_work(farm: &mut Farm) -> LedgerLook {
    let is_busy = !farm.jobs.only_looks() || !farm.nesting.just_fired.is_empty();
    let retries =
        !(farm.schedule.step_backoff.is_empty() && farm.reading.backoff.is_empty() && farm.nesting.backoff.is_empty());
    let has_closed_queue = farm.machines.values().any(|machine| !machine.printers.are_all_open());
    let at_latest = match farm.display.is_work_under_way || retries || has_closed_queue {
        true => LOOK_WHILE_WORKING,
        false => LOOK_AT_REST,
    };
    let (now, own) = (farm.now(), farm.machines.keys().map(String::as_str));
    let news = farm.schedule.ledger_changes.may_have_changed(&farm.ledger, own, (now, at_latest)).await;
    if is_busy || news { LedgerLook::Everywhere } else { LedgerLook::Unfinished }
}

/// Takes in an event and those queued behind it, so that one tick serves them all. Returns whether all of them belong to the reading of
/// parts: ends of reads, and of the claims of files that were read.
async fn handle_events(farm: &mut Farm, first: LoopEvent<Farm>) -> bool {
    let is_of_reading =
        |event: &LoopEvent<Farm>| event.is_end_of::<PartReadJob>() || event.is_end_of::<ClaimCompletionJob>();
    let mut only_read = is_of_reading(&first);
    job_events::handle_event(farm, first).await;
    for _ in 0..MAX_EVENTS_PER_TICK {
        // The next tick tells that the ledger cannot be reached.
        if farm.ledger.is_out_of_reach() {
            break;
        }
        let Some(event) = farm.jobs.try_next_event() else { break };
        only_read &= is_of_reading(&event);
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
    let jobs_ended = timeout(SHUTDOWN_TIMEOUT, job_events::wait_for_jobs(farm, deadline)).await.is_ok();
    if !jobs_ended || !farm.jobs.is_idle() {
        info!(jobs = farm.jobs.running_names(), "Work does not end in time; the next start goes on there.");
    }
    if farm.lifecycle.is_halted {
        write_stopped_status(farm).await;
        // Nothing is written into a damaged ledger, and it gets no checksum.
        lease_renewal::release_leases(&mut farm.machines, &mut farm.alerts);
        farm.alerts.write_if_changed(&farm.settings.state_dir);
        if farm.ledger.ensure_files_in_place().is_ok() {
            farm.ledger.close().await;
        }
        return;
    }
    write_stopped_status(farm).await;
    lease_renewal::release_leases(&mut farm.machines, &mut farm.alerts);
    farm.alerts.write_if_changed(&farm.settings.state_dir);
    let last_changes = async {
        leave_searches(farm).await;
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

/// Stores what the searches have found that did not end in time.
async fn leave_searches(farm: &mut Farm) {
    for (build, cut_short) in farm.nesting.searches.cut_short() {
        if let Err(failure) = batch::leave_search(&farm.ledger, build, &cut_short).await {
            warn!(build.id = %build, "What was found for build {build} could not be stored: {failure:#}.");
        }
    }
}
