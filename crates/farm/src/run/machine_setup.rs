//! Sets up the machines from the settings, and applies changes when the configuration is read again.

use std::{collections::BTreeMap, sync::Arc};

use anyhow::Result;
use ledger::{BuildRow, Ledger};
use nester::PreparedMeshCache;
use settings::Settings;
use tracing::info;

use crate::{
    alerts::alert::AlertKind,
    core::{desks::SettingUp, machine_state::MachineState, printer_state::alert_subject},
    decisions::kept_layouts::keeps_layouts,
    files::disk_cache::DiskPreparationCache,
    leases::folder_lease::FolderLease,
};

/// What the ledger says of the machines of a configuration.
pub(super) struct MachineRows {
    /// The machines that other nodes serve, each with its node.
    of_others: BTreeMap<String, String>,
    /// The open builds of the others.
    open_builds: BTreeMap<String, BuildRow>,
}

impl MachineRows {
    /// Reads them. Machines without a node are claimed for this one, machines without an open build get one, and the ledger learns what
    /// their files say is loaded.
    pub(super) async fn read(ledger: &Ledger, settings: &Settings) -> Result<Self> {
        let names: Vec<String> = settings.profiles.keys().cloned().collect();
        let of_others = ledger.claim_machines(&settings.node.name, &names).await?;
        let own = settings.profiles.values().filter(|profile| !of_others.contains_key(&profile.name));
        let loaded = own.map(|profile| (profile.name.clone(), profile.printing.material.clone())).collect();
        ledger.take_over_materials(&loaded, &|word| settings.materials.name_of(word)).await?;
        let mut open_builds = BTreeMap::new();
        for name in names.into_iter().filter(|name| !of_others.contains_key(name)) {
            let row = ledger.open_build(&name).await?;
            open_builds.insert(name, row);
        }
        Ok(Self { of_others, open_builds })
    }
}

/// Creates, replaces and removes machine states to match the settings.
pub(super) fn set_up_machines(desk: &mut SettingUp<'_>, rows: MachineRows) {
    desk.meshes.limits = desk.shared.settings.limits.clone();
    if !desk.meshes.preparation_cache.as_ref().is_some_and(|cache| cache.is_of(desk.shared.settings)) {
        desk.meshes.preparation_cache = DiskPreparationCache::for_farm(desk.shared.settings).map(Arc::new);
        let cache = desk.meshes.preparation_cache.clone().map(|cache| cache as Arc<dyn PreparedMeshCache + Send>);
        desk.meshes.prepared = desk.meshes.prepared.clone().with_cache(cache);
    }
    *desk.search_slots = search_slots(desk.shared.settings);
    remove_gone_machines(desk);
    report_other_nodes(desk, &rows.of_others);
    for (name, row) in rows.open_builds {
        let Some(profile) = desk.shared.settings.profiles.get(&name).cloned() else { continue };
        match desk.machines.get_mut(&name) {
            Some(machine) if *machine.profile == profile => (machine.agreed_folders, machine.may_claim) = (None, false),
            Some(machine) => {
                // A new volume or clearance makes the layout invalid; other rules leave it as it is. A new hot folder
                // needs a new hot folder scanner.
                machine.open.end_night();
                let keeps_layout = keeps_layouts(&machine.profile, &profile);
                let mut fresh = MachineState::new(
                    Arc::new(profile),
                    desk.shared.settings.orphan_ticket_secs,
                    &desk.shared.lifecycle.holder,
                    &row,
                    &desk.shared.schedule.time,
                );
                let layout = std::mem::take(&mut machine.open.layout);
                fresh.open.layout = if keeps_layout { layout } else { Default::default() };
                machine.open.reset();
                fresh.paused = machine.paused;
                fresh.pending_flushes = std::mem::take(&mut machine.pending_flushes);
                for printer in &machine.printers.0 {
                    let about = alert_subject(&name, &printer.name);
                    desk.shared.alerts.clear(AlertKind::QueueAway, &name, &about);
                    desk.shared.alerts.clear(AlertKind::QueueAway, &name, format!("lease {about}").trim_end());
                }
                *machine = fresh;
                info!(machine = %name, "The profile has changed.");
            }
            None => {
                let machine = MachineState::new(
                    Arc::new(profile),
                    desk.shared.settings.orphan_ticket_secs,
                    &desk.shared.lifecycle.holder,
                    &row,
                    &desk.shared.schedule.time,
                );
                desk.machines.insert(name, machine);
            }
        }
    }
}

/// Removes the machines that are not configured any more, and leaves their folders to another node.
fn remove_gone_machines(desk: &mut SettingUp<'_>) {
    let gone: Vec<String> =
        desk.machines.keys().filter(|name| !desk.shared.settings.profiles.contains_key(*name)).cloned().collect();
    for name in gone {
        if let Some(mut machine) = desk.machines.remove(&name) {
            machine.open.reset();
            machine.leases.all_leases().into_iter().for_each(FolderLease::release);
            desk.shared.alerts.forget_machine(&name);
            info!(machine = %name, "The machine is no longer configured; its waiting parts stay in the ledger.");
        }
    }
}

/// Raises an alert for each configured machine that another node serves. `of_others` names the node of each.
fn report_other_nodes(desk: &mut SettingUp<'_>, of_others: &BTreeMap<String, String>) {
    for name in desk.shared.settings.profiles.keys() {
        match of_others.get(name) {
            None => desk.shared.alerts.clear(AlertKind::OtherNode, name, ""),
            Some(node) => {
                desk.shared.alerts.raise(AlertKind::OtherNode, name, "", &format!("the node {node} serves it"))
            }
        }
    }
}

/// Takes the configured machines that another node has served and that are free now.
pub(super) async fn take_free_machines(desk: &mut SettingUp<'_>) -> Result<()> {
    let not_served = |name: &&String| !desk.machines.contains_key(*name);
    let names: Vec<String> = desk.shared.settings.profiles.keys().filter(not_served).cloned().collect();
    if !names.is_empty()
        && desk.shared.ledger.machines_of_others(&desk.shared.settings.node.name, &names).await?.len() < names.len()
    {
        let rows = MachineRows::read(desk.shared.ledger, desk.shared.settings).await?;
        set_up_machines(desk, rows);
    }
    Ok(())
}

/// Maximum number of searches at once: the threads of the farm divided by the largest number that a machine uses.
fn search_slots(settings: &Settings) -> usize {
    let all = settings.resources.thread_count();
    let each =
        settings.profiles.values().map(|p| if p.search.nest.threads == 0 { all } else { p.search.nest.threads }).max();
    (all / each.unwrap_or(1).max(1)).max(1)
}
