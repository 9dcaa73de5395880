//! The printer queue folders. A folder that was unavailable is opened again. Half-written files left by a crash and the
//! files of builds that are given up are removed. All of this runs on threads, because a queue folder may be a network
//! share that hangs.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use tracing::{info, warn};

use super::{
    alert::AlertKind, alert_registry::AlertRegistry, build_record, failure::error_chain, farm::Farm,
    folder_lease::FolderLease, jobs::BackgroundJob, jobs::JobRunner, machine_state::MachineStates,
    write_build::queue_file_name,
};
use crate::{
    ledger::{BuildId, BuildRow, BuildState, Ledger, Verified},
    queue::{QueueError, QueueFolder, StagedState},
};

/// Wait before a queue folder that could not be opened is tried again.
const OPEN_AGAIN: Duration = Duration::from_secs(1);

/// Opens a profile's queue folder.
#[derive(Clone)]
pub(super) struct OpenQueueJob {
    profile: String,
}

impl BackgroundJob<Farm> for OpenQueueJob {
    const KIND: &'static str = "Queue";
    /// The folder, or the reason why it cannot be used; `None` = its lease says so.
    type Outcome = Result<Option<QueueFolder>, String>;

    fn subject(&self) -> String {
        self.profile.clone()
    }

    async fn on_done(self, farm: &mut Farm, opened: Self::Outcome) -> Result<()> {
        on_queue_opened(&mut farm.machines, &mut farm.alerts, &self.profile, opened);
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

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, _farm: &mut Farm, discarded: Self::Outcome) -> Result<()> {
        // Files that cannot be removed now are removed when the folder is opened next.
        if let Err(failure) = discarded {
            warn!(build.id = %self.build, "The build's dot-file could not be removed: {failure}.");
        }
        Ok(())
    }
}

/// Starts jobs that open the queue folders that are not open.
pub(super) async fn open_queues(farm: &mut Farm) -> Result<()> {
    let now = farm.now();
    let is_due =
        |machine: &super::machine_state::MachineState| machine.queue.opened.is_none() && now >= machine.queue.open_at;
    if !farm.machines.values().any(is_due) {
        return Ok(());
    }
    let mut staged = Vec::new();
    // A build that is being nested may already be staged: only files that belong to no build are removed.
    for state in [BuildState::Nesting, BuildState::Verified] {
        for build in farm.ledger.builds_in_state(state).await? {
            staged.push(build.staged.file_name.clone().unwrap_or_else(|| queue_file_name(&build.profile, &build)));
        }
    }
    for (name, machine) in farm.machines.iter_mut().filter(|(_, machine)| is_due(machine)) {
        machine.queue.open_at = now + OPEN_AGAIN;
        let opening = QueueOpening {
            profile: name.clone(),
            lease: machine.leases.queue.clone(),
            staged: staged.clone(),
            ledger: farm.ledger.clone(),
        };
        let runtime = tokio::runtime::Handle::current();
        farm.jobs.start(OpenQueueJob { profile: name.clone() }, move || runtime.block_on(opening.open_and_sweep()));
    }
    Ok(())
}

fn on_queue_opened(
    machines: &mut MachineStates,
    alerts: &mut AlertRegistry,
    name: &str,
    opened: Result<Option<QueueFolder>, String>,
) {
    let Some(machine) = machines.get_mut(name) else { return };
    match opened {
        // The renewal of the leases reports it.
        Ok(None) => alerts.clear(AlertKind::QueueAway, name, ""),
        // After a reload, the profile may have another queue folder.
        Ok(Some(queue)) if queue.folder_path() != machine.profile.folders.queue => {}
        Ok(Some(queue)) => {
            machine.queue.opened = Some(queue);
            alerts.clear(AlertKind::QueueAway, name, "");
        }
        Err(why) => alerts.raise(AlertKind::QueueAway, name, "", &why),
    }
}

/// Whether builds could be written into the queue folder of a profile when the folder was last checked. An
/// unavailable folder does not use up an attempt of a build.
pub(super) fn has_usable_queue(machines: &MachineStates, profile: &str) -> bool {
    let Some(machine) = machines.get(profile) else { return false };
    machine.agreed_folders.is_some() && machine.queue.opened.is_some() && machine.leases.are_fresh()
}

/// Checks that a build was written into the queue folder that is configured now. Otherwise it is not recorded in
/// the ledger.
pub(super) async fn demand_same_queue(
    ledger: &Ledger,
    machines: &MachineStates,
    build: BuildId,
    verified: &Verified,
) -> Result<()> {
    let profile = ledger.find_build(build).await?.map(|b| b.profile).unwrap_or_default();
    let queue = machines.get(&profile).and_then(|s| s.queue.opened.as_ref());
    let queue = queue.context("the queue folder is not available any more")?;
    ensure!(queue.marker_id() == verified.file.queue_id, "the queue folder has changed since the build was written");
    Ok(())
}

/// Starts a job that removes the staged files of a build that is given up.
pub(super) fn discard_staged(machines: &MachineStates, jobs: &mut JobRunner<Farm>, build: &BuildRow) {
    let Some(queue) = machines.get(&build.profile).and_then(|s| s.queue.opened.clone()) else { return };
    let name = queue_file_name(&build.profile, build);
    jobs.start(DiscardJob { build: build.id }, move || queue.discard(&name));
}

/// The data for opening a queue folder.
struct QueueOpening {
    profile: String,
    lease: FolderLease,
    /// File names of the builds that may be staged. Their files are kept.
    staged: Vec<String>,
    ledger: Ledger,
}

impl QueueOpening {
    /// Opens the folder and removes the half-written files that a crash left in it.
    async fn open_and_sweep(mut self) -> Result<Option<QueueFolder>, String> {
        // This check comes first, so that an empty mount point is not marked as a queue.
        if self.lease.check_usable().is_err() {
            return Ok(None);
        }
        let queue = QueueFolder::open(self.lease.folder_path()).map_err(|error| error_chain(&error))?;
        // Another farm staged the builds that this farm has not fired. Their files are kept.
        for file in queue.staged_build_names().unwrap_or_default() {
            if !is_own_build(&self.ledger, &self.profile, &file).await.map_err(|error| format!("{error:#}"))? {
                self.staged.push(file);
            }
        }
        let swept = queue.remove_unknown_staged(&self.staged).map_err(|error| error_chain(&error))?;
        if !swept.is_empty() {
            info!(profile = %self.profile, files = swept.len(), "Removed half-written files of an earlier run.");
        }
        Ok(Some(queue))
    }
}

/// Whether this farm has fired the build of a build file. An open build has no file yet: if a file with its future name
/// exists, the file belongs to another farm.
async fn is_own_build(ledger: &Ledger, profile: &str, file: &str) -> Result<bool> {
    let Some((_, number)) = build_record::parse_build_file_name(file) else { return Ok(false) };
    let build = ledger.find_build(BuildId(number)).await?;
    Ok(build.is_some_and(|build| build.state != BuildState::Open && queue_file_name(profile, &build) == file))
}

/// Checks that a written build is in the queue folder under its dot-name, and that nothing has removed it.
///
/// # Errors
/// The queue folder cannot be read, or the file is missing.
pub(super) fn demand_staged(queue: &QueueFolder, name: &str) -> Result<()> {
    ensure!(queue.staged_state(name)? == StagedState::Staged, "the written build is gone from the queue folder");
    Ok(())
}
