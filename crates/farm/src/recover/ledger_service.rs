//! The right to serve the ledger. A ledger on a server is served by several nodes, each of which one process is; and it may
//! be out of reach. While that is not clear, the daemon takes and publishes nothing.

use ledger::{ServerError, ServiceState, ServingNode, ServingRight};
use settings::Settings;

use crate::{
    alerts::alert::AlertKind,
    core::desks::Shared,
    leases::{lease_clock, state_lock::host_name},
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
pub(crate) fn may_act(shared: &mut Shared<'_>) -> bool {
    let state = shared.ledger.service_state();
    // What was before is not so any more.
    if !matches!(state, ServiceState::Unsure { .. }) {
        shared.alerts.clear(AlertKind::LedgerUnreachable, "", "");
    }
    if !matches!(state, ServiceState::Locked { .. }) {
        shared.alerts.clear(AlertKind::LedgerLocked, "", "");
    }
    if !matches!(state, ServiceState::RepairDue { .. }) {
        shared.alerts.clear(AlertKind::RepairDue, "", "");
    }
    shared.schedule.is_cut_off |= state != ServiceState::Held;
    match state {
        ServiceState::Held => true,
        ServiceState::RepairDue { nodes } => {
            shared.alerts.raise(AlertKind::RepairDue, "", "", &nodes);
            false
        }
        ServiceState::Locked { by } => {
            shared.alerts.raise(AlertKind::LedgerLocked, "", "", &by);
            false
        }
        ServiceState::Unsure { why } => {
            shared.alerts.raise(AlertKind::LedgerUnreachable, "", "", &why);
            false
        }
        ServiceState::TakenOver => {
            shared.halt(AlertKind::LedgerTakenOver, &ServerError::TakenOver.to_string());
            false
        }
        ServiceState::Behind => {
            shared.halt(AlertKind::LedgerBehind, &ServerError::Behind.to_string());
            false
        }
    }
}
