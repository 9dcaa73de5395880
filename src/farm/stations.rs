//! Stations and settings: which machines are at work, and what changes when the configuration is read again.

use std::sync::Arc;

use anyhow::Result;
use nester::Cache;
use tracing::info;

use super::{attention::Attention, cache::DiskCache, farm::Farm, sd, station::Station};
use crate::settings::Settings;

impl Farm {
    /// Makes stations agree with the settings.
    pub(super) async fn set_up_stations(&mut self) -> Result<()> {
        self.meshes.limits = self.settings.limits.clone();
        if !self.meshes.cache.as_ref().is_some_and(|cache| cache.is_of(&self.settings)) {
            self.meshes.cache = DiskCache::of_farm(&self.settings).map(Arc::new);
            let cache = self.meshes.cache.clone().map(|cache| cache as Arc<dyn Cache + Send>);
            self.meshes.prepared = self.meshes.prepared.clone().with_cache(cache);
        }
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
            match self.stations.get_mut(&name) {
                Some(station) if *station.profile == profile => (station.agrees, station.may_take) = (None, false),
                Some(station) => {
                    // Another volume or clearance makes the layout worthless; another hot folder needs another gate.
                    let row = self.ledger.open_build(&name).await?;
                    let mut fresh = Station::new(
                        Arc::new(profile),
                        self.settings.orphan_ticket_secs,
                        &self.life.owner,
                        &row,
                        &self.schedule.time,
                    );
                    fresh.open.layout = Default::default();
                    station.open.clear();
                    fresh.paused = station.paused;
                    fresh.flush = std::mem::take(&mut station.flush);
                    *station = fresh;
                    info!(profile = %name, "The profile has changed.");
                }
                None => {
                    let row = self.ledger.open_build(&name).await?;
                    let station = Station::new(
                        Arc::new(profile),
                        self.settings.orphan_ticket_secs,
                        &self.life.owner,
                        &row,
                        &self.schedule.time,
                    );
                    self.stations.insert(name, station);
                }
            }
        }
        Ok(())
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
        let settings = (self.life.load)()?;
        if settings.ledger != self.settings.ledger || settings.state_dir != self.settings.state_dir {
            anyhow::bail!("the state folder and the ledger cannot change while the daemon runs");
        }
        settings.files.set();
        self.settings = settings;
        self.set_up_stations().await?;
        self.make_missing_folders();
        self.watch();
        self.compare_folders();
        Ok(())
    }
}

/// Searches that may run at once: the threads of the farm over those of the greediest profile.
fn nest_slots(settings: &Settings) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all = if settings.threads == 0 { cores } else { settings.threads };
    let each =
        settings.profiles.values().map(|p| if p.search.nest.threads == 0 { all } else { p.search.nest.threads }).max();
    (all / each.unwrap_or(1).max(1)).max(1)
}
