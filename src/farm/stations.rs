//! Stations and settings: which machines are at work, and what changes when the configuration is read again.

use std::sync::Arc;

use anyhow::Result;
use tracing::{info, warn};

use super::{attention::Attention, cache::DiskCache, farm::Farm, holds::Holds, jobs::Event, sd, station::Station};
use crate::{
    access,
    intake::Watcher,
    settings::{Profile, Settings},
};

impl Farm {
    /// Makes stations and the watcher agree with the settings.
    pub(super) async fn set_up_stations(&mut self) -> Result<()> {
        self.meshes.limits = self.settings.limits.clone();
        self.meshes.cache = DiskCache::of_farm(&self.settings).map(Arc::new);
        self.nesting.slots = nest_slots(&self.settings);
        let gone: Vec<String> =
            self.stations.keys().filter(|name| !self.settings.profiles.contains_key(*name)).cloned().collect();
        for name in gone {
            if let Some(mut station) = self.stations.remove(&name) {
                station.open.clear();
                self.notices.forget_machine(&name);
                info!(profile = %name, "The profile is no longer configured; its waiting parts stay in the ledger.");
            }
        }
        for (name, profile) in self.settings.profiles.clone() {
            self.make_folders(&profile);
            match self.stations.get_mut(&name) {
                Some(station) if *station.profile == profile => (station.agrees, station.may_take) = (None, false),
                Some(station) => {
                    // Another volume or clearance makes the layout worthless; another hot folder needs another gate.
                    let row = self.ledger.open_build(&name).await?;
                    let mut fresh =
                        Station::new(Arc::new(profile), self.settings.orphan_ticket_secs, &self.owner, &row);
                    fresh.open.layout = Default::default();
                    station.open.clear();
                    fresh.paused = station.paused;
                    fresh.flush = std::mem::take(&mut station.flush);
                    *station = fresh;
                    info!(profile = %name, "The profile has changed.");
                }
                None => {
                    let row = self.ledger.open_build(&name).await?;
                    let station = Station::new(Arc::new(profile), self.settings.orphan_ticket_secs, &self.owner, &row);
                    self.stations.insert(name, station);
                }
            }
        }
        self.watch();
        self.compare_folders();
        Ok(())
    }

    fn watch(&mut self) {
        let inboxes = self.stations.values().map(|s| s.profile.folders.inbox.clone()).collect();
        let events = self.jobs.sender();
        self.schedule.watcher = match Watcher::start(inboxes, move || drop(events.send(Event::new(Farm::look_soon)))) {
            Ok(watcher) => Some(watcher),
            Err(failure) => {
                warn!("No file-system events; the periodic scan goes on without them: {failure}.");
                None
            }
        };
    }

    /// Watches hot folders that were made anew; where that cannot be, the periodic scan serves.
    pub(super) fn check_watch(&mut self) {
        let unwatched = self.schedule.watcher.as_mut().map(Watcher::check).unwrap_or_default();
        for (path, why) in unwatched {
            tracing::debug!(inbox = %path.display(), "No file-system events from a hot folder: {why}.");
        }
    }

    pub(super) async fn reload(&mut self) {
        sd::reloading();
        match self.take_configuration().await {
            Ok(()) => {
                self.notices.clear(Attention::ConfigurationWrong, "", "");
                info!(profiles = self.stations.len(), "The configuration was read again.");
            }
            Err(failure) => {
                let detail = format!("{failure:#}").replace('\n', " ");
                self.notices.clear(Attention::ConfigurationWrong, "", "");
                self.notices.raise(Attention::ConfigurationWrong, "", "", &detail);
            }
        }
        // Machines may have come or gone: what is shown follows at once.
        self.shown.shown_at = None;
        self.tell("status", Self::show_status).await;
        sd::ready(&self.shown.line);
    }

    async fn take_configuration(&mut self) -> Result<()> {
        let settings = (self.load)()?;
        if settings.ledger != self.settings.ledger || settings.state_dir != self.settings.state_dir {
            anyhow::bail!("the state folder and the ledger cannot change while the daemon runs");
        }
        settings.files.set();
        self.settings = settings;
        self.set_up_stations().await
    }

    /// A share that is away must not keep the other machines from working. What was served once is not made again: an
    /// empty directory in its place would hinder whoever puts it back.
    fn make_folders(&mut self, profile: &Profile) {
        let holds = self.stations.get(&profile.name).map(|station| &station.holds);
        let fresh = Holds::new(&self.owner, profile);
        let Holds { inbox, queue, archive, error, .. } = holds.unwrap_or(&fresh);
        let folders = &profile.folders;
        let wanted =
            [(&folders.inbox, inbox), (&folders.queue, queue), (&folders.error, error), (&folders.archive, archive)];
        let mut failed = Vec::new();
        // One that cannot be made does not hinder the others.
        for (folder, _) in wanted.into_iter().filter(|(_, hold)| hold.is_new()) {
            if let Err(error) = access::create_folders(folder) {
                failed.push(format!("creating {}: {error}", folder.display()));
            }
        }
        match failed.is_empty() {
            true => self.notices.clear(Attention::FoldersMissing, &profile.name, ""),
            false => self.notices.raise(Attention::FoldersMissing, &profile.name, "", &failed.join("; ")),
        }
    }

    /// Folders that could not be made at the start are made when they can be.
    pub(super) fn make_missing_folders(&mut self) {
        let profiles: Vec<Arc<Profile>> = self.stations.values().map(|station| station.profile.clone()).collect();
        profiles.iter().for_each(|profile| self.make_folders(profile));
    }
}

/// Searches that may run at once: the threads of the farm over those of the greediest profile.
fn nest_slots(settings: &Settings) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all = if settings.threads == 0 { cores } else { settings.threads };
    let each = settings.profiles.values().map(|p| if p.nest.threads == 0 { all } else { p.nest.threads }).max();
    (all / each.unwrap_or(1).max(1)).max(1)
}
