//! Creates missing folders of machines, and subscribes to file-system events of the hot folders. Both run on threads,
//! because the folders may be network shares.

use std::path::PathBuf;

use anyhow::Result;
use intake::{InboxWatcher, WatchError};
use jobs::{BackgroundJob, Carried, JobRunner, LoopEvent};
use tracing::{debug, warn};

use super::{folder_comparison, lease_renewal};
use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    core::{
        desks::{Serving, Watching},
        farm::Farm,
        machine_state::MachineStates,
        state::WatchedInboxes,
    },
    leases::folder_leases::FolderLeases,
    receive::scan_jobs,
};

/// Subscribes to file-system events, again if hot folders were created or changed.
#[derive(Clone)]
struct WatchJob;

impl BackgroundJob<Farm> for WatchJob {
    const KIND: &'static str = "Watch";
    const IS_LOOK: bool = true;
    type Outcome = Result<(), WatchError>;
    type Desk<'f> = Watching<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, watched: Self::Outcome) -> Result<()> {
        on_watched(&mut desk, watched);
        Ok(())
    }
}

/// The watch that a job looks at or replaces.
struct CarriedWatch(Option<WatchedInboxes>);

impl Carried<Farm> for CarriedWatch {
    type Desk<'f> = Watching<'f>;

    fn give_back(self, desk: Self::Desk<'_>) {
        desk.watch.watched = self.0;
    }
}

/// Creates the folders of a machine. Returns those that could not be created.
#[derive(Clone)]
struct FoldersJob {
    machine: String,
}

impl BackgroundJob<Farm> for FoldersJob {
    const KIND: &'static str = "Folders";
    type Outcome = Vec<String>;
    type Desk<'f> = Watching<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, failed: Self::Outcome) -> Result<()> {
        on_folders_made(&mut desk, &self.machine, &failed);
        Ok(())
    }
}

/// Watches the hot folders, including those that were created or replaced. If a folder cannot be watched, the
/// periodic scan finds its files.
pub(crate) fn start_watcher(desk: &mut Watching<'_>) {
    if desk.jobs.is_running::<WatchJob>("") {
        return;
    }
    let (inboxes, before) = (list_inboxes(desk.machines), CarriedWatch(desk.watch.watched.take()));
    let events = desk.jobs.event_sender();
    desk.jobs.start_with(WatchJob, before, move |CarriedWatch(watched)| {
        if let Some(watched) = watched.as_mut().filter(|watched| watched.inboxes == inboxes) {
            for (path, why) in watched.watcher.check_roots() {
                debug!(inbox = %path.display(), "No file-system events from a hot folder: {why}.");
            }
            return Ok(());
        }
        // It is no end of a job, so it gets the farm, and takes a desk at once.
        let something_happened = || LoopEvent::<Farm>::new(|farm| scan_jobs::schedule_scan(&mut farm.desk()));
        let watcher = InboxWatcher::start(inboxes.clone(), move || drop(events.send(something_happened())))?;
        *watched = Some(WatchedInboxes { watcher, inboxes });
        Ok(())
    });
}

fn list_inboxes(machines: &MachineStates) -> Vec<PathBuf> {
    machines.values().map(|machine| machine.profile.folders.inbox.clone()).collect()
}

fn on_watched(desk: &mut Watching<'_>, watched: Result<(), WatchError>) {
    match watched {
        Ok(()) => {
            let watched = desk.watch.watched.as_ref();
            let is_current = watched.is_some_and(|watched| watched.inboxes == list_inboxes(desk.machines));
            desk.watch.is_unwatched = false;
            if !is_current {
                start_watcher(desk);
            }
        }
        Err(failure) => {
            if !std::mem::replace(&mut desk.watch.is_unwatched, true) {
                warn!("No file-system events; the periodic scan goes on without them: {failure}.");
            }
        }
    }
}

/// Creates the folders of all machines, before anything else is done with them.
pub(crate) fn make_folders_at_start(desk: &mut Serving<'_>) {
    for (name, machine) in desk.machines.iter() {
        let failed = make_folders(machine.leases.clone());
        update_folder_alert(desk.shared.alerts, name, &failed);
    }
}

/// Starts jobs that create the folders of new machines, and those that could not be created before.
pub(crate) fn create_missing_folders(machines: &mut MachineStates, jobs: &mut JobRunner<Farm>) {
    for (name, machine) in machines {
        if machine.leases.all_leases().iter().all(|lease| lease.held_identity().is_some()) {
            continue;
        }
        let leases = machine.leases.clone();
        jobs.start(FoldersJob { machine: name.clone() }, move || make_folders(leases));
    }
}

/// Scans the folders of a machine as soon as they exist.
fn on_folders_made(desk: &mut Watching<'_>, name: &str, failed: &[String]) {
    update_folder_alert(desk.shared.alerts, name, failed);
    let now = desk.shared.now();
    if let Some(machine) = desk.machines.get_mut(name).filter(|machine| machine.inbox.scanned_at.is_none()) {
        machine.inbox.next_scan_at = now;
        lease_renewal::renew_leases(&mut desk.serving(), true);
        start_watcher(desk);
        folder_comparison::start_folder_comparison(&mut desk.serving());
    }
}

fn update_folder_alert(alerts: &mut AlertRegistry, name: &str, failed: &[String]) {
    match failed.is_empty() {
        true => alerts.clear(AlertKind::FoldersMissing, name, ""),
        false => alerts.raise(AlertKind::FoldersMissing, name, "", &failed.join("; ")),
    }
}

/// Creates the folders of a machine. An unavailable share must not stop the other machines. A folder that was served
/// before is not created again: an empty directory in its place would be in the way of whoever mounts it again. Returns
/// the folders that could not be created.
fn make_folders(mut leases: FolderLeases) -> Vec<String> {
    let mut failed = Vec::new();
    // A folder that cannot be created does not prevent the creation of the others.
    for lease in leases.all_leases().into_iter().filter(|lease| lease.was_never_served()) {
        let folder = lease.folder_path();
        if let Err(error) = access::create_folders(folder) {
            failed.push(format!("creating {}: {error}", folder.display()));
        }
    }
    failed
}
