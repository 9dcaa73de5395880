//! An alert that needs a person, in the form that programs read: in `status.json`, `nestd status --json` and the
//! farm's JSON.

use ledger::UtcTimestamp;
use schemars::JsonSchema;
use serde::Serialize;

use super::alert::{AlertKind, FarmAlert};

/// An alert that needs a person, with its remedy.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AlertSummary {
    /// Kind of the alert.
    #[schemars(with = "String")]
    kind: AlertKind,
    /// Machine; empty = the whole farm, or the other node.
    machine: String,
    /// The other node that asks for it; empty = the one that was asked.
    #[serde(skip_serializing_if = "String::is_empty")]
    node: String,
    /// What is wrong.
    sentence: String,
    /// What to do.
    remedy: String,
    /// When the alert began.
    #[schemars(with = "UtcTimestamp")]
    since: String,
}

impl From<&FarmAlert> for AlertSummary {
    fn from(alert: &FarmAlert) -> Self {
        Self {
            kind: alert.kind,
            machine: alert.machine.clone(),
            node: alert.node.clone(),
            sentence: alert.alert_text().to_string(),
            remedy: alert.kind.remedy(),
            since: alert.since.to_string(),
        }
    }
}
