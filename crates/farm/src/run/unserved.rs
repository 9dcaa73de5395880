//! What hot folders say where nobody works: nestd was stopped, the farm is halted, or the node of the machine does not run and another one
//! reaches its folder. The status there before promised builds.

use std::{path::Path, time::Duration};

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};
use jobs::{BackgroundJob, JobRunner};
use language::say;
use ledger::{MachineRow, MachineStatus, NodeRow};
use serde_json::json;

use crate::{
    alerts::alert::AlertKind,
    core::{
        desks::{Shared, Showing},
        farm::Farm,
        machine_state::MachineState,
    },
    leases::{
        lease_marker::{LeaseMarker, read_marker},
        own_machines::profiles_of_others,
    },
    process::time_text::floor_to_minute,
    receive::scan_jobs::HotFolderScanJob,
};

/// After a stop, the hot folders get their last status within this time; a share that hangs is not waited for longer.
pub(super) const STOPPED_STATUS_TIMEOUT: Duration = Duration::from_secs(1);

/// A daemon and the marker of its folder tell its start no further apart.
const SAME_START: SignedDuration = SignedDuration::from_secs(60);

/// Writes into a hot folder that nestd has stopped or halted.
#[derive(Clone)]
pub(crate) struct WriteStatusJob {
    machine: String,
}

impl BackgroundJob<Farm> for WriteStatusJob {
    const KIND: &'static str = "Status";
    const IS_LOOK: bool = true;
    type Outcome = ();
    type Desk<'f> = Shared<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, _shared: Self::Desk<'_>, (): ()) -> Result<()> {
        Ok(())
    }
}

impl WriteStatusJob {
    /// Starts to write `STATUS.txt` and `status.json` of a machine, if whoever writes may do so when it comes to that.
    pub(super) fn start_in(
        jobs: &mut JobRunner<Farm>,
        machine: &str,
        inbox: &Path,
        (text, json): (String, String),
        may_write: impl FnOnce() -> bool + Send + 'static,
    ) {
        let (name, inbox) = (machine.to_owned(), inbox.to_owned());
        jobs.start(Self { machine: name.clone() }, move || {
            if may_write()
                && let Err(error) = intake::write_status(&inbox, &text, &json)
            {
                tracing::debug!(machine = name, "STATUS.txt could not be written: {error}.");
            }
        });
    }
}

/// Starts to write into each hot folder that nestd has stopped: the status there before promised builds.
pub(super) async fn write_stopped_status(desk: &mut Showing<'_>) {
    let rows = match desk.shared.lifecycle.is_halted {
        true => Vec::new(),
        false => desk.shared.ledger.machine_statuses().await.unwrap_or_default(),
    };
    for (name, machine) in desk.machines.iter() {
        // A job that did not end hangs in that folder, and this one would hang too.
        if desk.jobs.is_running::<HotFolderScanJob>(name) {
            continue;
        }
        let row = rows.iter().find(|row| row.machine == *name).cloned().unwrap_or_default();
        let status = match desk.shared.lifecycle.is_halted {
            true => halted_status(machine, &desk.shared, false),
            false => stopped_status(machine, &desk.shared, &row),
        };
        let mut lease = machine.leases.inbox.clone();
        // Nothing is written into an empty mount point.
        let may_write = move || lease.held_identity().is_some() && lease.check_usable().is_ok();
        WriteStatusJob::start_in(desk.jobs, name, &machine.profile.folders.inbox, status, may_write);
    }
}

/// `STATUS.txt` and `status.json` of a stopped farm: the last known values, and that nothing happens.
fn stopped_status(machine: &MachineState, shared: &Shared<'_>, row: &MachineStatus) -> (String, String) {
    let (name, now) = (&machine.profile.name, Timestamp::now());
    let time = machine.profile.time_zone.format_minute(now);
    let text = shared.settings.language.within(|| {
        let stopped = say!("status-stopped", machine = name, time = time);
        let waiting = (row.waiting_parts > 0).then(|| say!("status-until-then", waiting = waiting_text(row)));
        [Some(stopped), waiting].into_iter().flatten().map(|line| line + "\n").collect::<String>()
    });
    let json = json!({
        "machine": name,
        "running": false,
        "written_at": floor_to_minute(now).to_string(),
        "waiting_parts": row.waiting_parts,
        "waiting_copies": row.waiting_copies,
        "fires_at": null,
        "fires_at_latest": null,
    });
    (text, format!("{json:#}\n"))
}

/// `STATUS.txt` and `status.json` of a farm that cannot rely on its ledger: what waits is not known.
pub(super) fn halted_status(machine: &MachineState, shared: &Shared<'_>, is_running: bool) -> (String, String) {
    let (name, now, alerts) = (&machine.profile.name, Timestamp::now(), &*shared.alerts);
    let time = machine.profile.time_zone.format_minute(now);
    let text = shared.settings.language.within(|| {
        let halted = say!("status-halted", machine = name);
        format!("{}{halted}\n{}\n", alerts.status_text_for(name), say!("status-written", time = time))
    });
    let json = json!({
        "machine": name,
        "running": is_running,
        "written_at": floor_to_minute(now).to_string(),
        "attention": alerts.status_json_for(name),
        "fires_at": null,
        "fires_at_latest": null,
    });
    (text, format!("{json:#}\n"))
}

/// The waiting copies and parts, in words.
pub(super) fn waiting_text(row: &MachineStatus) -> String {
    let parts = say!("count-parts", count = row.waiting_parts);
    say!("status-waiting", copies = row.waiting_copies, parts = parts)
}

/// Tells which other nodes do not run.
pub(super) async fn tell_gone_nodes(desk: &mut Showing<'_>, observed: &[MachineRow]) -> Result<()> {
    if desk.shared.ledger.file().is_some() {
        return Ok(());
    }
    let own = &desk.shared.settings.node.name;
    for node in desk.shared.ledger.list_nodes().await?.into_iter().filter(|node| node.name != *own) {
        let its: Vec<&MachineRow> = observed.iter().filter(|row| row.node == node.name).collect();
        if node.alive || node.pid == 0 || its.is_empty() {
            desk.shared.alerts.clear(AlertKind::NodeGone, "", &node.name);
            continue;
        }
        let names: Vec<&str> = its.iter().map(|row| row.machine.as_str()).collect();
        let detail = format!("{} on {}, with {}", node.name, node.host, names.join(", "));
        desk.shared.alerts.raise(AlertKind::NodeGone, "", &node.name, &detail);
        desk.shared.ledger.record_node_gone(&node.name).await?;
        write_into_folders(desk, &node, observed);
    }
    Ok(())
}

/// Starts to write into the hot folders of a node, where they can be reached from here, that nobody looks into them.
fn write_into_folders(desk: &mut Showing<'_>, node: &NodeRow, observed: &[MachineRow]) {
    let settings = desk.shared.settings;
    let all = settings.clone().with_machines_of_others(&profiles_of_others(settings, observed));
    for (name, profile) in all.profiles.iter().filter(|(_, profile)| profile.of_node == node.name) {
        let since = profile.time_zone.format_minute(node.beat_at.0);
        let text = settings
            .language
            .within(|| say!("status-node-gone", machine = name, node = &node.name, host = &node.host, time = since));
        let json = json!({
            "machine": name,
            "running": false,
            "node": node.name,
            "last_seen_at": node.beat_at,
            "fires_at": null,
            "fires_at_latest": null,
        });
        let (inbox, state_dir) = (profile.folders.inbox.clone(), settings.state_dir.clone());
        let (pid, started_at) = (node.pid, node.started_at.0);
        // At the same path, another server may have something else, and this one a folder of its own.
        let is_of_node = move || {
            matches!(read_marker(&inbox), Ok(LeaseMarker::HeldBy(holder))
                if holder.belongs_to_state_dir(&state_dir)
                    && holder.pid == pid
                    && holder.since.duration_until(started_at).abs() < SAME_START)
        };
        let status = (format!("{text}\n"), format!("{json:#}\n"));
        WriteStatusJob::start_in(desk.jobs, name, &profile.folders.inbox, status, is_of_node);
    }
}
