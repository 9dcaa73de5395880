//! Sets up the machines from the settings, and applies changes when the configuration is read again.

use std::{collections::BTreeMap, sync::Arc};

use anyhow::Result;
use nester::PreparedMeshCache;
use tracing::info;

use super::status;
use crate::{
    farm::{
        alerts::alert::AlertKind,
        core::{farm::Farm, machine_state::MachineState, printer_state::alert_subject},
        decisions::kept_layouts::keeps_layouts,
        files::disk_cache::DiskPreparationCache,
        leases::folder_lease::FolderLease,
        nodes::{folder_comparison, watching},
        process::systemd,
    },
    settings::Settings,
};

/// Creates, replaces and removes machine states to match the settings.
pub(super) async fn set_up_machines(farm: &mut Farm) -> Result<()> {
    farm.meshes.limits = farm.settings.limits.clone();
    if !farm.meshes.preparation_cache.as_ref().is_some_and(|cache| cache.is_of(&farm.settings)) {
        farm.meshes.preparation_cache = DiskPreparationCache::for_farm(&farm.settings).map(Arc::new);
        let cache = farm.meshes.preparation_cache.clone().map(|cache| cache as Arc<dyn PreparedMeshCache + Send>);
        farm.meshes.prepared = farm.meshes.prepared.clone().with_cache(cache);
    }
    farm.nesting.searches.slots = search_slots(&farm.settings);
    remove_gone_machines(farm);
    let names: Vec<String> = farm.settings.profiles.keys().cloned().collect();
    let of_others = farm.ledger.claim_machines(&farm.settings.node.name, &names).await?;
    report_other_nodes(farm, &of_others);
    for (name, profile) in farm.settings.profiles.clone() {
        if of_others.contains_key(&name) {
            continue;
        }
        match farm.machines.get_mut(&name) {
            Some(machine) if *machine.profile == profile => (machine.agreed_folders, machine.may_claim) = (None, false),
            Some(machine) => {
                // A new volume or clearance makes the layout invalid; other rules leave it as it is. A new hot folder
                // needs a new hot folder scanner.
                machine.open.end_night();
                let keeps_layout = keeps_layouts(&machine.profile, &profile);
                let row = farm.ledger.open_build(&name).await?;
                let mut fresh = MachineState::new(
                    Arc::new(profile),
                    farm.settings.orphan_ticket_secs,
                    &farm.lifecycle.holder,
                    &row,
                    &farm.schedule.time,
                );
                let layout = std::mem::take(&mut machine.open.layout);
                fresh.open.layout = if keeps_layout { layout } else { Default::default() };
                machine.open.reset();
                fresh.paused = machine.paused;
                fresh.pending_flushes = std::mem::take(&mut machine.pending_flushes);
                for printer in &machine.printers.0 {
                    let about = alert_subject(&name, &printer.name);
                    farm.alerts.clear(AlertKind::QueueAway, &name, &about);
                    farm.alerts.clear(AlertKind::QueueAway, &name, format!("lease {about}").trim_end());
                }
                *machine = fresh;
                info!(profile = %name, "The profile has changed.");
            }
            None => {
                let row = farm.ledger.open_build(&name).await?;
                let machine = MachineState::new(
                    Arc::new(profile),
                    farm.settings.orphan_ticket_secs,
                    &farm.lifecycle.holder,
                    &row,
                    &farm.schedule.time,
                );
                farm.machines.insert(name, machine);
            }
        }
    }
    Ok(())
}

/// Removes the machines that are not configured any more, and leaves their folders to another node.
fn remove_gone_machines(farm: &mut Farm) {
    let gone: Vec<String> =
        farm.machines.keys().filter(|name| !farm.settings.profiles.contains_key(*name)).cloned().collect();
    for name in gone {
        if let Some(mut machine) = farm.machines.remove(&name) {
            machine.open.reset();
            machine.leases.all_leases().into_iter().for_each(FolderLease::release);
            farm.alerts.forget_machine(&name);
            info!(profile = %name, "The profile is no longer configured; its waiting parts stay in the ledger.");
        }
    }
}

/// Raises an alert for each configured machine that another node serves. `of_others` names the node of each.
fn report_other_nodes(farm: &mut Farm, of_others: &BTreeMap<String, String>) {
    for name in farm.settings.profiles.keys() {
        match of_others.get(name) {
            None => farm.alerts.clear(AlertKind::OtherNode, name, ""),
            Some(node) => farm.alerts.raise(AlertKind::OtherNode, name, "", &format!("the node {node} serves it")),
        }
    }
}

/// Takes the configured machines that another node has served and that are free now.
pub(super) async fn take_free_machines(farm: &mut Farm) -> Result<()> {
    let not_served = |name: &&String| !farm.machines.contains_key(*name);
    let names: Vec<String> = farm.settings.profiles.keys().filter(not_served).cloned().collect();
    if !names.is_empty() && farm.ledger.machines_of_others(&farm.settings.node.name, &names).await?.len() < names.len()
    {
        set_up_machines(farm).await?;
    }
    Ok(())
}

pub(crate) async fn reload_configuration(farm: &mut Farm) {
    systemd::notify_reloading();
    match apply_configuration(farm).await {
        Ok(()) => {
            farm.alerts.clear(AlertKind::ConfigurationWrong, "", "");
            info!(profiles = farm.machines.len(), "The configuration was read again.");
        }
        Err(failure) => {
            let detail = format!("{failure:#}").replace('\n', " ");
            farm.alerts.clear(AlertKind::ConfigurationWrong, "", "");
            farm.alerts.raise(AlertKind::ConfigurationWrong, "", "", &detail);
        }
    }
    // Machines may have been added or removed: the status is updated at once.
    farm.display.updated_at = None;
    farm.run_step("status", status::update_status).await;
    systemd::notify_ready(&farm.display.status_line);
}

async fn apply_configuration(farm: &mut Farm) -> Result<()> {
    let settings = (farm.lifecycle.load)()?;
    if settings.ledger != farm.settings.ledger || settings.state_dir != farm.settings.state_dir {
        anyhow::bail!("the state folder and the ledger cannot change while the daemon runs");
    }
    settings.files.apply_to_process();
    farm.settings = settings;
    set_up_machines(farm).await?;
    watching::create_missing_folders(&mut farm.machines, &mut farm.jobs);
    watching::start_watcher(farm);
    folder_comparison::start_folder_comparison(farm);
    Ok(())
}

/// Maximum number of searches at once: the threads of the farm divided by the largest number that a profile uses.
fn search_slots(settings: &Settings) -> usize {
    let all = settings.resources.thread_count();
    let each =
        settings.profiles.values().map(|p| if p.search.nest.threads == 0 { all } else { p.search.nest.threads }).max();
    (all / each.unwrap_or(1).max(1)).max(1)
}
