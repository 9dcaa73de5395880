//! The right to serve the ledger. A ledger on a server can be reached from several hosts, of which one serves it; and it may
//! be out of reach. While that is not clear, the daemon takes and publishes nothing.

use super::{alert::AlertKind, farm::Farm, lease_clock, state_lock::host_name};
use crate::{
    ledger::{ServerError, ServiceState, ServingNode},
    settings::Settings,
};

/// This daemon, as the ledger names it.
pub fn serving_node(settings: &Settings) -> ServingNode {
    let folder = std::fs::canonicalize(&settings.state_dir).unwrap_or_else(|_| settings.state_dir.clone());
    ServingNode {
        owner: format!("the one on {} with the state folder {}", host_name(), folder.display()),
        lease: lease_clock::ledger_lease(),
    }
}

/// A process that copies a ledger, as the ledger names it.
pub fn copying_node(host: &str) -> ServingNode {
    ServingNode {
        owner: format!("`nestd ledger copy`, process {} on {host}", std::process::id()),
        lease: lease_clock::ledger_lease(),
    }
}

/// Whether the farm may act on what its ledger says. If another daemon serves the ledger now, the farm halts.
pub fn may_act(farm: &mut Farm) -> bool {
    match farm.ledger.service_state() {
        ServiceState::Held => {
            farm.alerts.clear(AlertKind::LedgerUnreachable, "", "");
            true
        }
        ServiceState::Unsure { why } => {
            farm.alerts.raise(AlertKind::LedgerUnreachable, "", "", &why);
            false
        }
        ServiceState::TakenOver => {
            farm.halt_farm(AlertKind::LedgerTakenOver, &ServerError::TakenOver.to_string());
            false
        }
    }
}
