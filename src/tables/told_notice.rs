//! An alert that needs a person, in the form that programs read.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    farm::{AlertKind, FarmAlert},
    ledger::UtcTimestamp,
};

/// An alert that needs a person, with its remedy.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ToldNotice {
    /// Kind of the alert.
    #[schemars(with = "String")]
    kind: AlertKind,
    /// Machine profile; empty = the whole farm.
    profile: String,
    /// What is wrong.
    sentence: String,
    /// What to do.
    remedy: &'static str,
    /// When the alert began.
    #[schemars(with = "UtcTimestamp")]
    since: String,
}

impl From<&FarmAlert> for ToldNotice {
    fn from(notice: &FarmAlert) -> Self {
        Self {
            kind: notice.kind,
            profile: notice.profile.clone(),
            sentence: notice.alert_text().to_string(),
            remedy: notice.kind.remedy(),
            since: notice.since.to_string(),
        }
    }
}
