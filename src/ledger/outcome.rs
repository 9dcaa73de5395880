//! Outcomes: what somebody told of a published build.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{BuildId, BuildState, Ledger, LedgerError, Utc, error::Result, word::own_word};

/// Builds of which an outcome can be told.
const TOLD: &[BuildState] = &[BuildState::Published, BuildState::Printing];

/// What became of a published build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

impl Outcome {
    /// The state that a build enters with it.
    fn state(self) -> BuildState {
        match self {
            Self::Printing => BuildState::Printing,
            Self::Complete => BuildState::Complete,
            Self::Interrupted => BuildState::Interrupted,
            Self::Failed => BuildState::Failed,
        }
    }
}

impl Ledger {
    /// Writes what somebody told of a published build and moves it, through printing where needed.
    pub async fn record_outcome(&self, build: BuildId, outcome: Outcome, note: &str, told_by: &str) -> Result<()> {
        let mut change = self.change().await?;
        let (_, state) = change.build(build).await?;
        if state == BuildState::Nesting {
            // Only the farm may fail a build that is being nested, and it lets its copies go when it does.
            return Err(LedgerError::WrongState { build, state, needed: TOLD });
        }
        if state == BuildState::Published && outcome != Outcome::Printing {
            change.move_build(build, BuildState::Printing, "").await?;
        }
        change.move_build(build, outcome.state(), note).await?;
        let now = change.now;
        sqlx::query("INSERT INTO outcome (build_id, outcome, note, told_by, told_at) VALUES (?, ?, ?, ?, ?)")
            .bind(build)
            .bind(outcome)
            .bind(note)
            .bind(told_by)
            .bind(now)
            .execute(change.db())
            .await?;
        change.commit().await
    }

    /// What was told of a build, oldest first.
    pub async fn outcomes(&self, build: BuildId) -> Result<Vec<OutcomeRow>> {
        let query = sqlx::query_as("SELECT * FROM outcome WHERE build_id = ? ORDER BY id").bind(build);
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
