//! The queue folders of the printers. A folder that was unavailable is opened again. Half-written files left by a crash and the
//! files of builds that are given up are removed. All of this runs on threads, because a queue folder may be a network
//! share that hangs.

use std::time::Duration;

use anyhow::{Result, ensure};
use build_file::DeliveryKind;
use delivery::queue::{FileState, OpenQueue, QueueAddress, QueueError, is_build_name};
use jobs::{BackgroundJob, JobRunner};
use ledger::{BuildId, BuildRow, BuildState, Ledger, Verified};
use tracing::{info, warn};

use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry, failure::error_chain},
    core::{
        desks::{Serving, Shared},
        farm::Farm,
        machine_state::MachineStates,
        printer_state::{PrinterState, alert_subject},
    },
    leases::folder_lease::FolderLease,
    nesting::write_build::{queue_file_name, queue_file_stem},
    records::build_record,
};

/// Wait before a queue folder that could not be opened is tried again.
const OPEN_AGAIN: Duration = Duration::from_secs(1);

/// Opens a machine's queue folder.
#[derive(Clone)]
pub(crate) struct OpenQueueJob {
    machine: String,
    printer: String,
}

impl BackgroundJob<Farm> for OpenQueueJob {
    const KIND: &'static str = "Queue";
    /// The folder, or the reason why it cannot be used; `None` = its lease says so.
    type Outcome = Result<Option<OpenedQueue>, String>;
    type Desk<'f> = Serving<'f>;

    fn subject(&self) -> String {
        self.printer.clone()
    }

    async fn on_done(self, desk: Self::Desk<'_>, opened: Self::Outcome) -> Result<()> {
        if let Ok(Some(OpenedQueue { queue, builds })) = &opened {
            // A machine that got printers, or a printer that got another name, goes on with what is there.
            desk.shared.ledger.name_printer(&self.machine, &self.printer, queue.id(), builds).await?;
        }
        let opened = opened.map(|opened| opened.map(|opened| opened.queue));
        on_queue_opened(desk.machines, desk.shared.alerts, &self, opened);
        Ok(())
    }
}

/// Removes the staged files of a build that is given up.
#[derive(Clone)]
struct DiscardJob {
    build: BuildId,
}

impl BackgroundJob<Farm> for DiscardJob {
    const KIND: &'static str = "Discard";
    type Outcome = Result<bool, QueueError>;
    type Desk<'f> = Shared<'f>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, _shared: Self::Desk<'_>, discarded: Self::Outcome) -> Result<()> {
        // Files that cannot be removed now are removed when the folder is opened next.
        if let Err(failure) = discarded {
            warn!(build.id = %self.build, "The build's dot-file could not be removed: {failure}.");
        }
        Ok(())
    }
}

/// Starts jobs that open the queue folders that are not open.
pub(crate) async fn open_queues(desk: &mut Serving<'_>) -> Result<()> {
    let now = desk.shared.now();
    let is_due = |printer: &PrinterState| printer.opened.is_none() && now >= printer.open_at;
    if !desk.machines.values().any(|machine| machine.printers.0.iter().any(is_due)) {
        return Ok(());
    }
    // A build that is being nested may already be staged, and one that moves is on its way: only files that belong to no
    // build are removed.
    let mut live = Vec::new();
    for state in [BuildState::Nesting, BuildState::Verified] {
        live.extend(desk.shared.ledger.builds_in_state(state).await?);
    }
    for (name, machine) in desk.machines.iter_mut() {
        live.extend(desk.shared.ledger.builds_to_take_back(name).await?);
        let names: Vec<String> = machine.printers.0.iter().map(|printer| printer.name.clone()).collect();
        for printer in machine.printers.0.iter_mut().filter(|printer| is_due(printer)) {
            printer.open_at = now + OPEN_AGAIN;
            let lease = machine.leases.queue_lease(&printer.address).cloned();
            if lease.is_none() && printer.address.folder().is_some() {
                continue;
            }
            let kept = live.iter().filter(|build| may_lie_at(build, &printer.name, &names));
            let opening = QueueOpening {
                machine: name.clone(),
                address: printer.address.clone(),
                lease,
                staged: kept.map(staged_name).collect(),
                ledger: desk.shared.ledger.clone(),
            };
            let (runtime, printer) = (tokio::runtime::Handle::current(), printer.name.clone());
            let job = OpenQueueJob { machine: name.clone(), printer };
            desk.jobs.start(job, move || runtime.block_on(opening.open_and_sweep()));
        }
    }
    Ok(())
}

/// Whether a live build may have files in the queue folder of a printer. `names` are the printers of that machine.
fn may_lie_at(build: &BuildRow, printer: &str, names: &[String]) -> bool {
    let is_here = |of: &Option<String>| of.as_deref() == Some(printer);
    let is_elsewhere = build.place.printer.as_ref().is_some_and(|of| of != printer && names.contains(of));
    !is_elsewhere || is_here(&build.place.move_to)
}

fn staged_name(build: &BuildRow) -> String {
    build.staged.file_name.clone().unwrap_or_else(|| any_file_name(build))
}

/// A name that the file of a build may have. What is staged is kept and removed by its stem.
fn any_file_name(build: &BuildRow) -> String {
    queue_file_name(&build.machine, build, DeliveryKind::default())
}

fn on_queue_opened(
    machines: &mut MachineStates,
    alerts: &mut AlertRegistry,
    job: &OpenQueueJob,
    opened: Result<Option<OpenQueue>, String>,
) {
    let Some(machine) = machines.get_mut(&job.machine) else { return };
    // After a reload, the printer may be gone, or have another queue folder.
    let Some(printer) = machine.printers.0.iter_mut().find(|printer| printer.name == job.printer) else { return };
    let (name, about) = (&job.machine, &alert_subject(&job.machine, &job.printer));
    match opened {
        // The renewal of the leases reports it.
        Ok(None) => alerts.clear(AlertKind::QueueAway, name, about),
        Ok(Some(queue)) if *queue.address() != printer.address => {}
        Ok(Some(queue)) => {
            printer.opened = Some(queue);
            alerts.clear(AlertKind::QueueAway, name, about);
        }
        // Of a printer that a person took out of use, everybody knows.
        Err(_) if printer.down.is_some() => alerts.clear(AlertKind::QueueAway, name, about),
        Err(why) => alerts.raise(AlertKind::QueueAway, name, about, &why),
    }
}

/// Checks that a build was written into the queue folder that is configured now. Otherwise it is not recorded in
/// the ledger.
pub(crate) async fn demand_same_queue(
    ledger: &Ledger,
    machines: &MachineStates,
    build: BuildId,
    verified: &Verified,
) -> Result<()> {
    let name = ledger.find_build(build).await?.map(|b| b.machine).unwrap_or_default();
    let printers = machines.get(&name).map(|machine| machine.printers.0.as_slice()).unwrap_or_default();
    ensure!(printers.iter().any(|printer| printer.opened.is_some()), "the queue folder is not available any more");
    let is_staging =
        |printer: &PrinterState| printer.opened.as_ref().is_some_and(|queue| queue.id() == verified.file.queue_id);
    ensure!(printers.iter().any(is_staging), "the queue folder has changed since the build was written");
    Ok(())
}

/// Starts a job that removes the staged files of a build that is given up.
pub(crate) fn discard_staged(machines: &MachineStates, jobs: &mut JobRunner<Farm>, build: &BuildRow) {
    let printer = machines.get(&build.machine).and_then(|machine| machine.printers.of_build(build));
    let Some(queue) = printer.and_then(|printer| printer.opened.clone()) else { return };
    let name = any_file_name(build);
    jobs.start(DiscardJob { build: build.id }, move || queue.discard(&name));
}

/// A queue folder, and the names of the builds that are visible or staged in it.
pub(crate) struct OpenedQueue {
    queue: OpenQueue,
    builds: Vec<String>,
}

/// The data for opening a queue folder.
struct QueueOpening {
    machine: String,
    address: QueueAddress,
    /// The lease on its folder, if it is one.
    lease: Option<FolderLease>,
    /// File names of the builds that may be staged. Their files are kept.
    staged: Vec<String>,
    ledger: Ledger,
}

impl QueueOpening {
    /// Opens the folder and removes the half-written files that a crash left in it.
    async fn open_and_sweep(mut self) -> Result<Option<OpenedQueue>, String> {
        // This check comes first, so that an empty mount point is not marked as a queue.
        if self.lease.as_mut().is_some_and(|lease| lease.check_usable().is_err()) {
            return Ok(None);
        }
        let queue = self.address.open().map_err(|error| error_chain(&error))?;
        // Another farm staged the builds that this farm has not fired. Their files are kept.
        for file in queue.names(FileState::Staged).unwrap_or_default() {
            if !is_own_build(&self.ledger, &self.machine, &file).await.map_err(|error| format!("{error:#}"))? {
                self.staged.push(file);
            }
        }
        let swept = queue.sweep(&self.staged).map_err(|error| error_chain(&error))?;
        if !swept.is_empty() {
            info!(machine = %self.machine, files = swept.len(), "Removed half-written files of an earlier run.");
        }
        let mut builds = queue.names(FileState::Visible).map_err(|error| error_chain(&error))?;
        builds.retain(|name| is_build_name(name));
        builds.extend(queue.names(FileState::Staged).map_err(|error| error_chain(&error))?);
        Ok(Some(OpenedQueue { queue, builds }))
    }
}

/// Whether this farm has fired the build of a build file. An open build has no file yet: if a file with its future name
/// exists, the file belongs to another farm.
async fn is_own_build(ledger: &Ledger, machine: &str, file: &str) -> Result<bool> {
    let Some((_, number)) = build_record::parse_build_file_name(file) else { return Ok(false) };
    let build = ledger.find_build(BuildId(number)).await?;
    Ok(build.is_some_and(|build| {
        build.state != BuildState::Open && build_file::build_file_stem(file) == Some(&*queue_file_stem(machine, &build))
    }))
}

/// Checks that a written build is in the queue folder under its dot-name, and that nothing has removed it.
///
/// # Errors
/// The queue folder cannot be read, or the file is missing.
pub(crate) fn demand_staged(queue: &OpenQueue, name: &str) -> Result<()> {
    ensure!(queue.state(name)? == FileState::Staged, "the written build is gone from the queue folder");
    Ok(())
}
