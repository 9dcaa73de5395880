//! Sets up the machines from the settings, and applies changes when the configuration is read again.

use std::sync::Arc;

use anyhow::Result;
use nester::PreparedMeshCache;
use tracing::info;

use super::{alert::AlertKind, disk_cache::DiskPreparationCache, farm::Farm, machine_state::MachineState, systemd};
use crate::settings::Settings;

impl Farm {
    /// Creates, replaces and removes machine states to match the settings.
    pub(super) async fn set_up_machines(&mut self) -> Result<()> {
        self.meshes.limits = self.settings.limits.clone();
        if !self.meshes.preparation_cache.as_ref().is_some_and(|cache| cache.is_of(&self.settings)) {
            self.meshes.preparation_cache = DiskPreparationCache::for_farm(&self.settings).map(Arc::new);
            let cache = self.meshes.preparation_cache.clone().map(|cache| cache as Arc<dyn PreparedMeshCache + Send>);
            self.meshes.prepared = self.meshes.prepared.clone().with_cache(cache);
        }
        self.nesting.slots = search_slots(&self.settings);
        let gone: Vec<String> =
            self.machines.keys().filter(|name| !self.settings.profiles.contains_key(*name)).cloned().collect();
        for name in gone {
            if let Some(mut station) = self.machines.remove(&name) {
                station.open.reset();
                self.alerts.forget_machine(&name);
                info!(profile = %name, "The profile is no longer configured; its waiting parts stay in the ledger.");
            }
        }
        for (name, profile) in self.settings.profiles.clone() {
            match self.machines.get_mut(&name) {
                Some(station) if *station.profile == profile => {
                    (station.agreed_folders, station.may_take) = (None, false)
                }
                Some(station) => {
                    // A new volume or clearance makes the layout invalid. A new hot folder needs a new hot folder
                    // scanner.
                    let row = self.ledger.open_build(&name).await?;
                    let mut fresh = MachineState::new(
                        Arc::new(profile),
                        self.settings.orphan_ticket_secs,
                        &self.lifecycle.owner,
                        &row,
                        &self.schedule.time,
                    );
                    fresh.open.layout = Default::default();
                    station.open.reset();
                    fresh.paused = station.paused;
                    fresh.pending_flushes = std::mem::take(&mut station.pending_flushes);
                    *station = fresh;
                    info!(profile = %name, "The profile has changed.");
                }
                None => {
                    let row = self.ledger.open_build(&name).await?;
                    let station = MachineState::new(
                        Arc::new(profile),
                        self.settings.orphan_ticket_secs,
                        &self.lifecycle.owner,
                        &row,
                        &self.schedule.time,
                    );
                    self.machines.insert(name, station);
                }
            }
        }
        Ok(())
    }

    pub(super) async fn reload_configuration(&mut self) {
        systemd::notify_reloading();
        match self.apply_configuration().await {
            Ok(()) => {
                self.alerts.clear(AlertKind::ConfigurationWrong, "", "");
                info!(profiles = self.machines.len(), "The configuration was read again.");
            }
            Err(failure) => {
                let detail = format!("{failure:#}").replace('\n', " ");
                self.alerts.clear(AlertKind::ConfigurationWrong, "", "");
                self.alerts.raise(AlertKind::ConfigurationWrong, "", "", &detail);
            }
        }
        // Machines may have been added or removed: the status is updated at once.
        self.display.updated_at = None;
        self.run_step("status", Self::update_status).await;
        systemd::notify_ready(&self.display.status_line);
    }

    async fn apply_configuration(&mut self) -> Result<()> {
        let settings = (self.lifecycle.load)()?;
        if settings.ledger != self.settings.ledger || settings.state_dir != self.settings.state_dir {
            anyhow::bail!("the state folder and the ledger cannot change while the daemon runs");
        }
        settings.files.apply_to_process();
        self.settings = settings;
        self.set_up_machines().await?;
        self.create_missing_folders();
        self.start_watcher();
        self.start_folder_comparison();
        Ok(())
    }
}

/// Maximum number of searches at once: the threads of the farm divided by the largest number that a profile uses.
fn search_slots(settings: &Settings) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all = if settings.threads == 0 { cores } else { settings.threads };
    let each =
        settings.profiles.values().map(|p| if p.search.nest.threads == 0 { all } else { p.search.nest.threads }).max();
    (all / each.unwrap_or(1).max(1)).max(1)
}
