//! The settings of the node: this daemon among those that share one ledger.

use rustix::system::uname;

use super::inputs::{HOST, NodeInputs};
use crate::reading::validator::ConfigValidator;

/// Most letters of a name.
const MAX_LETTERS: usize = 64;

/// A node: a daemon among those that share one ledger on a server.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeSettings {
    /// Its name.
    pub name: String,
    /// Where the other nodes reach its dashboard, without a slash at the end; `None` = they cannot.
    pub address: Option<String>,
}

/// Validates the options of the node.
pub(crate) fn validate_node(inputs: &NodeInputs, validator: &mut ConfigValidator) -> NodeSettings {
    let is_fit = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_' | '.');
    let name = match inputs.name.as_str() {
        HOST => {
            uname().nodename().to_string_lossy().chars().filter(|&letter| is_fit(letter)).take(MAX_LETTERS).collect()
        }
        name => name.to_owned(),
    };
    if name.is_empty() || name.len() > MAX_LETTERS || !name.chars().all(is_fit) {
        let text = format!("node.name = \"{}\" cannot be the name of a node", inputs.name.escape_debug());
        validator.report_problem("node.name", text, "1 to 64 of a-z, A-Z, 0-9, '-', '_' and '.', as in print1");
    }
    let address = inputs.address.0.as_deref().map(|address| address.trim_end_matches('/').to_owned());
    if let Some(address) = &address
        && !is_address(address)
    {
        let text = format!("node.address = \"{}\" is no address of a dashboard", address.escape_debug());
        validator.report_problem(
            "node.address",
            text,
            "write http://HOST:PORT, where HOST is a name that the other nodes know",
        );
    }
    validator.require_within("node.connections", inputs.connections, 6..=50);
    NodeSettings { name, address }
}

fn is_address(address: &str) -> bool {
    let host = address.strip_prefix("http://").or_else(|| address.strip_prefix("https://"));
    host.is_some_and(|host| !host.is_empty() && !host.contains(['@', '?', '#', ' ']))
}
