//! Creates missing folders of machines, and subscribes to file-system events of the hot folders. Both run on threads,
//! because the folders may be network shares.

use std::{path::PathBuf, sync::Arc};

use anyhow::Result;
use tracing::{debug, warn};

use super::{
    alert::AlertKind,
    farm::Farm,
    folder_leases::FolderLeases,
    jobs::{BackgroundJob, LoopEvent},
    state::WatchedInboxes,
};
use crate::{
    access,
    intake::{InboxWatcher, WatchError},
    settings::MachineProfile,
};

/// Subscribes to file-system events, again if hot folders were created or changed.
#[derive(Clone)]
struct WatchJob;

impl BackgroundJob<Farm> for WatchJob {
    const KIND: &'static str = "Watch";
    type Outcome = Result<WatchedInboxes, WatchError>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, farm: &mut Farm, watched: Self::Outcome) -> Result<()> {
        farm.on_watched(watched);
        Ok(())
    }
}

/// Creates the folders of a profile. Returns those that could not be created.
#[derive(Clone)]
struct FoldersJob {
    profile: String,
}

impl BackgroundJob<Farm> for FoldersJob {
    const KIND: &'static str = "Folders";
    type Outcome = Vec<String>;

    fn subject(&self) -> String {
        self.profile.clone()
    }

    async fn on_done(self, farm: &mut Farm, failed: Self::Outcome) -> Result<()> {
        farm.on_folders_made(&self.profile, &failed);
        Ok(())
    }
}

impl Farm {
    /// Watches the hot folders, including those that were created or replaced. If a folder cannot be watched, the
    /// periodic scan finds its files.
    pub(super) fn start_watcher(&mut self) {
        if self.jobs.is_running::<WatchJob>("") {
            return;
        }
        let (inboxes, before) = (self.inboxes(), self.schedule.watched.take());
        let events = self.jobs.event_sender();
        self.jobs.start(WatchJob, move || match before {
            Some(mut watched) if watched.inboxes == inboxes => {
                for (path, why) in watched.watcher.check_roots() {
                    debug!(inbox = %path.display(), "No file-system events from a hot folder: {why}.");
                }
                Ok(watched)
            }
            _ => {
                let watcher = InboxWatcher::start(inboxes.clone(), move || {
                    drop(events.send(LoopEvent::new(Farm::schedule_scan)))
                })?;
                Ok(WatchedInboxes { watcher, inboxes })
            }
        });
    }

    fn inboxes(&self) -> Vec<PathBuf> {
        self.machines.values().map(|station| station.profile.folders.inbox.clone()).collect()
    }

    fn on_watched(&mut self, watched: Result<WatchedInboxes, WatchError>) {
        match watched {
            Ok(watched) => {
                let is_current = watched.inboxes == self.inboxes();
                self.schedule.watched = Some(watched);
                self.schedule.is_unwatched = false;
                if !is_current {
                    self.start_watcher();
                }
            }
            Err(failure) => {
                if !std::mem::replace(&mut self.schedule.is_unwatched, true) {
                    warn!("No file-system events; the periodic scan goes on without them: {failure}.");
                }
            }
        }
    }

    /// Creates the folders of all machines, before anything else is done with them.
    pub(super) fn make_folders_at_start(&mut self) {
        let stations: Vec<(Arc<MachineProfile>, FolderLeases)> =
            self.machines.values().map(|station| (station.profile.clone(), station.leases.clone())).collect();
        for (profile, holds) in stations {
            let failed = make_folders(&profile, &holds);
            self.tell_of_folders(&profile.name, &failed);
        }
    }

    /// Starts jobs that create the folders of new machines, and those that could not be created before.
    pub(super) fn create_missing_folders(&mut self) {
        for (name, station) in &mut self.machines {
            if station.leases.all_leases().iter().all(|hold| hold.held_identity().is_some()) {
                continue;
            }
            let (profile, holds) = (station.profile.clone(), station.leases.clone());
            self.jobs.start(FoldersJob { profile: name.clone() }, move || make_folders(&profile, &holds));
        }
    }

    /// Scans the folders of a machine as soon as they exist.
    fn on_folders_made(&mut self, name: &str, failed: &[String]) {
        self.tell_of_folders(name, failed);
        let now = self.now();
        if let Some(station) = self.machines.get_mut(name).filter(|station| station.inbox.scanned_at.is_none()) {
            station.inbox.look_at = now;
            self.renew_leases(true);
            self.start_watcher();
            self.start_folder_comparison();
        }
    }

    fn tell_of_folders(&mut self, name: &str, failed: &[String]) {
        match failed.is_empty() {
            true => self.alerts.clear(AlertKind::FoldersMissing, name, ""),
            false => self.alerts.raise(AlertKind::FoldersMissing, name, "", &failed.join("; ")),
        }
    }
}

/// Creates the folders of a profile. An unavailable share must not stop the other machines. A folder that was served
/// before is not created again: an empty directory in its place would be in the way of whoever mounts it again. Returns
/// the folders that could not be created.
fn make_folders(profile: &MachineProfile, holds: &FolderLeases) -> Vec<String> {
    let folders = &profile.folders;
    let wanted = [
        (&folders.inbox, &holds.inbox),
        (&folders.queue, &holds.queue),
        (&folders.error, &holds.error),
        (&folders.archive, &holds.archive),
    ];
    let mut failed = Vec::new();
    // A folder that cannot be created does not prevent the creation of the others.
    for (folder, _) in wanted.into_iter().filter(|(_, hold)| hold.was_never_served()) {
        if let Err(error) = access::create_folders(folder) {
            failed.push(format!("creating {}: {error}", folder.display()));
        }
    }
    failed
}
