//! Which machines are this node's own. Where several nodes share a ledger, another one may serve a machine, also one that is configured
//! here for the day on which it moves.

use std::collections::BTreeMap;

use ledger::{Ledger, LedgerError, MachineRow};
use settings::{OtherMachine, Settings};

/// The machines that other nodes serve, each with its node, whether they are configured here or not.
///
/// # Errors
/// The ledger cannot be read.
pub async fn machines_of_other_nodes(
    settings: &Settings,
    ledger: &Ledger,
) -> Result<BTreeMap<String, String>, LedgerError> {
    if ledger.file().is_some() {
        return Ok(BTreeMap::new());
    }
    let rows = ledger.list_machines().await?.into_iter();
    let others = rows.filter(|row| !row.node.is_empty() && row.node != settings.node.name);
    Ok(others.map(|row| (row.machine, row.node)).collect())
}

/// The settings with the machines of this node alone: the folders of the others are for the nodes that serve them.
///
/// # Errors
/// The ledger cannot be read.
pub async fn without_other_nodes(settings: &Settings, ledger: &Ledger) -> Result<Settings, LedgerError> {
    let others = machines_of_other_nodes(settings, ledger).await?;
    let mut own = settings.clone();
    own.profiles.retain(|name, _| !others.contains_key(name));
    Ok(own)
}

/// The machines of other nodes, as these say them.
pub(crate) fn profiles_of_others(settings: &Settings, rows: &[MachineRow]) -> Vec<OtherMachine> {
    let own = &settings.node.name;
    let others = rows.iter().filter(|row| !row.node.is_empty() && row.node != *own && !row.profile.is_empty());
    let machine = |row: &MachineRow| OtherMachine {
        name: row.machine.clone(),
        node: row.node.clone(),
        text: row.profile.clone(),
    };
    others.map(machine).collect()
}

/// The settings with the machines of all nodes, for whoever shows and plans them.
///
/// # Errors
/// The ledger cannot be read.
pub async fn with_other_nodes(settings: Settings, ledger: &Ledger) -> Result<Settings, LedgerError> {
    if ledger.file().is_some() {
        return Ok(settings);
    }
    Ok(settings.with_machines_of_others(&profiles_of_others(&settings, &ledger.list_machines().await?)))
}
