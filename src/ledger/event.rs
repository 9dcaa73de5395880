//! Events: what happened to parts and builds, in order, for ever.

use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, PartId, Utc};

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct EventRow {
    /// Its number.
    pub id: i64,
    /// When.
    pub at: Utc,
    /// What: a state that was entered, or a word of its own.
    pub kind: String,
    /// Machine profile, "" = none.
    pub profile: String,
    /// The part that it is about.
    pub part_id: Option<PartId>,
    /// The build that it is about.
    pub build_id: Option<BuildId>,
    /// More about it.
    pub detail: String,
}
