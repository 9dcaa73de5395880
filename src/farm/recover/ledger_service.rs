//! The right to serve the ledger. A ledger on a server is served by several nodes, each of which one process is; and it may
//! be out of reach. While that is not clear, the daemon takes and publishes nothing.

use ledger::{ServerError, ServiceState, ServingNode, ServingRight};

use crate::{
    farm::{
        alerts::alert::AlertKind,
        core::farm::Farm,
        leases::{lease_clock, state_lock::host_name},
        receive::scan_jobs,
    },
    settings::Settings,
};

/// This farm's right to be its node, or to have the whole ledger alone, as the ledger names it.
pub fn serving_node(settings: &Settings, right: ServingRight) -> ServingNode {
    let folder = std::fs::canonicalize(&settings.state_dir).unwrap_or_else(|_| settings.state_dir.clone());
    let owner = format!("the one on {} with the state folder {}", host_name(), folder.display());
    ServingNode { right, owner, lease: lease_clock::ledger_lease() }
}

/// A process that copies a ledger, as the ledger names it.
pub fn copying_node(host: &str) -> ServingNode {
    let owner = format!("`nestd ledger copy`, process {} on {host}", std::process::id());
    ServingNode { right: ServingRight::WholeLedger, owner, lease: lease_clock::ledger_lease() }
}

/// Whether the farm may act on what its ledger says. If another process has its right now, the farm halts.
pub fn may_act(farm: &mut Farm) -> bool {
    let state = farm.ledger.service_state();
    // What was before is not so any more.
    if !matches!(state, ServiceState::Unsure { .. }) {
        farm.alerts.clear(AlertKind::LedgerUnreachable, "", "");
    }
    if !matches!(state, ServiceState::Locked { .. }) {
        farm.alerts.clear(AlertKind::LedgerLocked, "", "");
    }
    if !matches!(state, ServiceState::RepairDue { .. }) {
        farm.alerts.clear(AlertKind::RepairDue, "", "");
    }
    farm.schedule.is_cut_off |= state != ServiceState::Held;
    match state {
        ServiceState::Held => {
            if std::mem::take(&mut farm.schedule.is_cut_off) {
                retry_at_once(farm);
            }
            true
        }
        ServiceState::RepairDue { nodes } => {
            farm.alerts.raise(AlertKind::RepairDue, "", "", &nodes);
            false
        }
        ServiceState::Locked { by } => {
            farm.alerts.raise(AlertKind::LedgerLocked, "", "", &by);
            false
        }
        ServiceState::Unsure { why } => {
            farm.alerts.raise(AlertKind::LedgerUnreachable, "", "", &why);
            false
        }
        ServiceState::TakenOver => {
            farm.halt_farm(AlertKind::LedgerTakenOver, &ServerError::TakenOver.to_string());
            false
        }
        ServiceState::Behind => {
            farm.halt_farm(AlertKind::LedgerBehind, &ServerError::Behind.to_string());
            false
        }
    }
}

/// The ledger can be reached and changed again: what failed meanwhile is done now, and not after the wait that follows a failure.
fn retry_at_once(farm: &mut Farm) {
    farm.schedule.step_backoff.end_waits();
    farm.reading.backoff.end_waits();
    farm.nesting.backoff.end_waits();
    farm.machines.values_mut().for_each(|machine| machine.open.retry_at_once());
    scan_jobs::schedule_scan(farm);
}
