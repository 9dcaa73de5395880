//! Opens the farm: checks what must exist and be intact before any file is claimed.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use intake::ContentStore;
use jobs::JobRunner;
use language::say;
use ledger::{Ledger, LedgerError, ServingRight};
use settings::Settings;
use tracing::warn;

use super::{
    machine_setup::{self, MachineRows},
    status,
};
use crate::{
    alerts::{
        alert::AlertKind, alert_registry::AlertRegistry, failure::is_disk_failure, service_bridge::ServiceBridge,
    },
    core::{
        clock_changes,
        farm::{Farm, TICK_INTERVAL},
        state::{
            CompletionState, DaemonLifecycle, DisplayState, HotFolderWatch, Load, LoopSchedule, NestingState,
            ReadingState,
        },
    },
    files::{mesh_cache::MeshCache, mesh_source::MeshSource},
    leases::{folder_lease::LeaseError, lease_holder::LeaseHolder, state_lock::StateDirLock},
    nesting::node_content::COPIES_DIR,
    nodes::{adopt, folder_comparison, lease_renewal, watching},
    process::{
        retry_backoff::RetryBackoff,
        signals::{DaemonSignal, SignalListener},
        systemd,
        time_source::TimeSource,
    },
    records::{
        ledger_freshness::{LedgerBehindError, check_ledger_current},
        lost_ledger::{LostLedgerError, detect_lost_ledger, ledger_alert},
    },
    recover::ledger_service,
};

/// Opens the farm. While the disk of the state folder is full or unavailable, waits instead of ending again and
/// again. `None` = the daemon was stopped meanwhile.
pub(super) async fn open_with_retry(
    load: Load,
    settings: Settings,
    signals: &mut SignalListener,
) -> Result<Option<Farm>> {
    let (mut load, mut settings, mut waits, mut alerts) =
        (load, settings, RetryBackoff::default(), AlertRegistry::default());
    let mut told: Option<AlertKind> = None;
    let mut lock = None;
    loop {
        let (back, known, failure) = match open_farm(load, settings, TimeSource::of_this_machine(), &mut lock).await {
            Ok(farm) => return Ok(Some(farm)),
            Err(kept) => kept,
        };
        (load, settings) = (back, known);
        let of_ledger = ledger_alert(&failure);
        if let Some(over) = told.take_if(|told| of_ledger.as_ref().is_none_or(|(kind, _)| kind != told)) {
            alerts.clear(over, "", "");
        }
        let text = format!("the farm cannot be opened now and is tried again: {failure:#}");
        match &of_ledger {
            Some((kind, detail)) => {
                alerts.raise(*kind, "", "", detail);
                told = Some(*kind);
            }
            None if is_transient(&failure) => alerts.report_failure(AlertKind::StepFails, "", "opening", &text),
            None => {}
        }
        if !is_transient(&failure) {
            report_not_open(&settings, &mut alerts, false);
            return Err(failure);
        }
        report_not_open(&settings, &mut alerts, true);
        systemd::notify_start_delayed(&text);
        waits.record_failure(());
        while waits.is_waiting(&()) {
            tokio::select! {
                signal = signals.next_signal() => if matches!(signal, DaemonSignal::Stop) { return Ok(None) },
                () = tokio::time::sleep(TICK_INTERVAL) => {}
            }
        }
    }
}

/// On failure, returns what the next attempt needs. `lock` is taken by the first attempt, and is for all of them.
pub(crate) async fn open_farm(
    load: Load,
    settings: Settings,
    time: TimeSource,
    lock: &mut Option<StateDirLock>,
) -> Result<Farm, (Load, Settings, anyhow::Error)> {
    match OpenedState::open(&settings, &time, lock).await {
        Ok(parts) => {
            let mut farm = build_farm(load, settings, parts, time);
            match open_machines(&mut farm).await {
                Ok(()) => Ok(farm),
                Err(failure) => {
                    farm.ledger.close().await;
                    Err((farm.lifecycle.load, farm.settings, failure))
                }
            }
        }
        Err(failure) => Err((load, settings, failure)),
    }
}

async fn open_machines(farm: &mut Farm) -> Result<()> {
    clock_changes::compare_clock_with_ledger(&mut farm.desk()).await?;
    // Before it takes machines: they are its own as long as it is known.
    let node = status::describe_node(&farm.desk());
    farm.ledger.announce_node(&node).await?;
    let rows = MachineRows::read(&farm.ledger, &farm.settings).await?;
    machine_setup::set_up_machines(&mut farm.desk(), rows);
    watching::make_folders_at_start(&mut farm.desk());
    watching::start_watcher(&mut farm.desk());
    lease_renewal::acquire_leases_at_start(&mut farm.machines, &mut farm.alerts)?;
    // After the leases: a folder whose last daemon died on another server is read only once that is clear.
    folder_comparison::start_folder_comparison(&mut farm.desk());
    Ok(())
}

fn build_farm(load: Load, settings: Settings, parts: OpenedState, time: TimeSource) -> Farm {
    Farm {
        ledger: parts.ledger,
        meshes: MeshSource {
            mesh_cache: MeshCache::default(),
            store: parts.store,
            limits: settings.limits.clone(),
            prepared: Default::default(),
            preparation_cache: None,
            judged: Default::default(),
            unreadable_since: Default::default(),
        },
        machines: BTreeMap::new(),
        jobs: JobRunner::default(),
        completion: CompletionState::default(),
        reading: ReadingState::by(time.clone()),
        nesting: NestingState::by(time.clone()),
        watch: HotFolderWatch::default(),
        display: DisplayState { status_line: "opening".to_owned(), ..DisplayState::default() },
        lifecycle: DaemonLifecycle {
            load,
            holder: parts.holder,
            started_at: time.date(),
            is_stopping: false,
            is_halted: false,
            services: ServiceBridge::default(),
            started_with: settings.interfaces.clone(),
            next_settings: None,
            _lock: parts.lock,
        },
        alerts: AlertRegistry::after_last_run(time.clone(), &settings.state_dir),
        schedule: LoopSchedule::starting_now(settings.scan_secs, time),
        settings,
    }
}

/// What is opened in the state directory.
struct OpenedState {
    lock: StateDirLock,
    holder: LeaseHolder,
    ledger: Ledger,
    store: ContentStore,
}

impl OpenedState {
    async fn open(settings: &Settings, time: &TimeSource, held: &mut Option<StateDirLock>) -> Result<Self> {
        let since = time.date();
        settings.files.apply_to_process();
        access::create_private_folders(&settings.state_dir)
            .with_context(|| format!("creating the state directory {}", settings.state_dir.display()))?;
        let lock = match held.clone() {
            Some(lock) => lock,
            None => held.insert(StateDirLock::acquire(&settings.state_dir, since)?).clone(),
        };
        if let Some(file) = settings.ledger.file() {
            ledger::clear_unfinished(file)?;
        }
        systemd::notify_status("looking through the ledger");
        let clock = time.clone();
        let ledger = open_ledger(settings).await?.with_clock(move || clock.date());
        // Opened after the ledger: if the farm has an id, it must have had a ledger.
        adopt::join_farm(settings, ledger.shared_farm().await?)
            .with_context(|| format!("writing the farm's number into {}", settings.state_dir.display()))?;
        let holder = LeaseHolder::for_this_process(&settings.state_dir, since)
            .with_context(|| format!("reading the farm's number in {}", settings.state_dir.display()))?;
        let store = ContentStore::open(settings.state_dir.join("store"))?;
        if ledger.file().is_none() {
            ContentStore::open(settings.state_dir.join(COPIES_DIR))?;
        }
        Ok(Self { lock, holder, ledger, store })
    }
}

/// Whether the cause of a failed start may end by itself: a full disk, a share that hangs, a process that holds the ledger.
pub(crate) fn is_transient(failure: &anyhow::Error) -> bool {
    // If another daemon serves a folder, this one does not wait: whoever started it must know.
    let is_served = |cause: &LeaseError| matches!(cause, LeaseError::HeldByOther { .. });
    if failure.chain().any(|cause| cause.downcast_ref().is_some_and(is_served)) {
        return false;
    }
    is_disk_failure(failure)
        || failure.chain().any(|cause| cause.downcast_ref::<LedgerError>().is_some_and(LedgerError::is_disk_failure))
}

/// Opens the ledger, if it is intact and belongs to this farm.
async fn open_ledger(settings: &Settings) -> Result<Ledger> {
    if Ledger::is_missing(&settings.ledger).await?
        && let Some(detail) = detect_lost_ledger(settings)
    {
        return Err(LostLedgerError { detail }.into());
    }
    let node = ledger_service::serving_node(settings, ServingRight::Node(settings.node.name.clone()));
    let ledger = Ledger::open_to_serve(&settings.ledger, &node).await?;
    if let Err(failure) = check_ledger_current(settings, &ledger).await {
        if failure.is::<LedgerBehindError>() {
            // Other nodes may have got what it has lost.
            ledger.mark_repair_due(&settings.node.name).await?;
        }
        ledger.close().await;
        return Err(failure);
    }
    Ok(ledger)
}

/// Reports for `nestd status` and in every hot folder that the daemon does not work, where there is a reason to tell. `waits` = it will
/// begin by itself.
fn report_not_open(settings: &Settings, alerts: &mut AlertRegistry, waits: bool) {
    if alerts.active_alerts().next().is_none() {
        return;
    }
    alerts.write_if_changed(&settings.state_dir);
    for (name, profile) in &settings.profiles {
        let text = settings.language.within(|| {
            let said = match waits {
                true => say!("status-waits-to-begin", machine = name),
                false => say!("status-does-not-run", machine = name),
            };
            format!("{said}\n{}", alerts.status_text_for(name))
        });
        let json = serde_json::json!({ "machine": name, "runs": false, "attention": alerts.status_json_for(name) });
        if let Err(error) = intake::write_status(&profile.folders.inbox, &text, &format!("{json:#}\n")) {
            warn!("The status could not be written into {}: {error}.", profile.folders.inbox.display());
        }
    }
}
