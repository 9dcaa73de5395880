//! What a person must see to, as programs are told.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    farm::{AlertKind, FarmAlert},
    ledger::UtcTimestamp,
};

/// Something that a person must see to, with what to do.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ToldNotice {
    /// Kind of the notice.
    #[schemars(with = "String")]
    kind: AlertKind,
    /// Machine profile; empty = the farm.
    profile: String,
    /// What is wrong.
    sentence: String,
    /// What to do.
    remedy: &'static str,
    /// Since when.
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
