//! Outcomes: what users report about published builds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{BuildId, BuildState, Ledger, LedgerError, UtcTimestamp, error::Result, text_column::own_word};

/// States of a build in which an outcome can be reported.
const REPORTABLE_STATES: &[BuildState] = &[BuildState::Published, BuildState::Printing];

/// The outcome of a published build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PrintOutcome {
    /// The machine has started to print.
    Printing,
    /// Printed.
    Complete,
    /// The machine stopped before the end.
    Interrupted,
    /// The print failed.
    Failed,
}

own_word!(PrintOutcome);

/// A reported outcome.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct OutcomeRow {
    /// Its number.
    pub id: i64,
    /// The build.
    pub build_id: BuildId,
    /// The outcome.
    pub outcome: PrintOutcome,
    /// Free text.
    pub note: String,
    /// user@host.
    pub told_by: String,
    /// When it was reported.
    pub told_at: UtcTimestamp,
}

impl PrintOutcome {
    /// The state that a build enters with this outcome.
    fn build_state(self) -> BuildState {
        match self {
            Self::Printing => BuildState::Printing,
            Self::Complete => BuildState::Complete,
            Self::Interrupted => BuildState::Interrupted,
            Self::Failed => BuildState::Failed,
        }
    }
}

impl Ledger {
    /// Records the reported outcome of a published build and changes its state, through printing if needed.
    pub async fn record_outcome(&self, build: BuildId, outcome: PrintOutcome, note: &str, told_by: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (_, state) = change.require_build(build).await?;
        if state == BuildState::Nesting {
            // Only the farm may fail a nesting build, because it then releases the copies.
            return Err(LedgerError::WrongState { build, state, needed: REPORTABLE_STATES });
        }
        if state == BuildState::Published && outcome != PrintOutcome::Printing {
            change.move_build(build, BuildState::Printing, "").await?;
        }
        change.move_build(build, outcome.build_state(), note).await?;
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

    /// The reported outcomes of a build, oldest first.
    pub async fn outcomes_of_build(&self, build: BuildId) -> Result<Vec<OutcomeRow>> {
        let query = sqlx::query_as("SELECT * FROM outcome WHERE build_id = ? ORDER BY id").bind(build);
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
