//! The nodes of a farm: the daemons that share its ledger, each with its machines.

use ledger::{Ledger, LedgerError, NodeRow};
use schemars::JsonSchema;
use serde::Serialize;

use crate::tables::{
    columns::{cell_value::CellValue, table_column::TableColumn},
    fields,
};

/// A node with its machines.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FarmNode {
    /// The node.
    #[serde(flatten)]
    pub node: NodeRow,
    /// The machines that it serves, by name.
    pub machines: Vec<String>,
    /// Whether the ledger has lost changes of it, so that its folders are to be compared with it.
    pub repair_due: bool,
}

/// The nodes of a farm.
pub const NODE_COLUMNS: &[TableColumn<FarmNode>] = &[
    TableColumn::new("name", fields::NODE, |row| (&row.node.name).into()),
    TableColumn::new("state", fields::STATE, |row| CellValue::State(row.state_text().to_owned())),
    TableColumn::new("host", fields::HOST, |row| (&row.node.host).into()),
    TableColumn::new("version", fields::VERSION, |row| (&row.node.version).into()),
    TableColumn::new("beat_at", fields::LAST_SIGN, |row| row.node.beat_at.into()),
    TableColumn::new("address", fields::ADDRESS, |row| (&row.node.address).into()),
    TableColumn::new("machines", fields::MACHINES, |row| row.machines.join(", ").into()),
];

impl FarmNode {
    fn state_text(&self) -> &'static str {
        match (self.node.alive, self.node.pid) {
            _ if self.repair_due => "is to be repaired",
            (true, _) => "runs",
            (false, 0) => "stopped",
            (false, _) => "does not answer",
        }
    }
}

/// The nodes of a farm with their machines, by name.
///
/// # Errors
/// The ledger cannot be read.
pub async fn list_farm_nodes(ledger: &Ledger) -> Result<Vec<FarmNode>, LedgerError> {
    let machines = ledger.list_machines().await?;
    let nodes = ledger.list_nodes().await?.into_iter();
    let due = ledger.find_repair_due().await?;
    let with_machines = |node: NodeRow| FarmNode {
        machines: machines.iter().filter(|row| row.node == node.name).map(|row| row.machine.clone()).collect(),
        repair_due: due.contains(&node.name),
        node,
    };
    Ok(nodes.map(with_machines).collect())
}
