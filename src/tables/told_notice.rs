//! What a person must see to, as programs are told.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    farm::{Attention, Notice},
    ledger::Utc,
};

/// Something that a person must see to, with what to do.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ToldNotice {
    /// Kind of the notice.
    #[schemars(with = "String")]
    kind: Attention,
    /// Machine profile; empty = the farm.
    profile: String,
    /// What is wrong.
    sentence: String,
    /// What to do.
    remedy: &'static str,
    /// Since when.
    #[schemars(with = "Utc")]
    since: String,
}

impl From<&Notice> for ToldNotice {
    fn from(notice: &Notice) -> Self {
        Self {
            kind: notice.kind,
            profile: notice.profile.clone(),
            sentence: notice.sentence().to_string(),
            remedy: notice.kind.remedy(),
            since: notice.since.to_string(),
        }
    }
}
