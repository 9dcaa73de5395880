//! Outcomes: what somebody told of a published build.

use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{BuildId, Utc, word::own_word};

/// What became of a published build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The machine has begun.
    Printing,
    /// Printed.
    Complete,
    /// The machine stopped before the end.
    Interrupted,
    /// The print failed.
    Failed,
}

own_word!(Outcome);

/// An outcome as it was told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct OutcomeRow {
    /// Its number.
    pub id: i64,
    /// The build.
    pub build_id: BuildId,
    /// What became of it.
    pub outcome: Outcome,
    /// Free text.
    pub note: String,
    /// user@host.
    pub told_by: String,
    /// When.
    pub told_at: Utc,
}
