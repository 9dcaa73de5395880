//! Which of the configured machines are this node's own. Where several nodes share a ledger, another one may serve a machine.

use crate::{
    ledger::{Ledger, LedgerError},
    settings::Settings,
};

/// The settings with the machines of this node alone: the folders of the others are for the nodes that serve them.
///
/// # Errors
/// The ledger cannot be read.
pub async fn without_other_nodes(settings: &Settings, ledger: &Ledger) -> Result<Settings, LedgerError> {
    let names: Vec<String> = settings.profiles.keys().cloned().collect();
    let others = ledger.machines_of_others(&settings.node.name, &names).await?;
    let mut own = settings.clone();
    own.profiles.retain(|name, _| !others.contains_key(name));
    Ok(own)
}
