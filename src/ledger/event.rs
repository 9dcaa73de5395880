//! Events: what happened to parts and builds, in order, for ever.

use jiff::SignedDuration;
use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, Ledger, PartId, Refusal, Utc, error::Result};

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
    /// Of a refusal: a word of [`Refusal`]; "" otherwise.
    pub cause: String,
}

impl Ledger {
    /// Writes an event.
    pub async fn event(
        &self,
        kind: &str,
        profile: &str,
        part: Option<PartId>,
        build: Option<BuildId>,
        detail: &str,
    ) -> Result<()> {
        let mut change = self.change().await?;
        change.event(kind, profile, part, build, detail).await?;
        change.commit().await
    }

    /// A file was refused before it became a part.
    pub async fn file_refused(&self, profile: &str, cause: Refusal, detail: &str) -> Result<()> {
        let mut change = self.change().await?;
        change.refusal("refused", profile, None, cause, detail).await?;
        change.commit().await
    }

    /// When the latest event happened.
    pub async fn last_event_at(&self) -> Result<Option<Utc>> {
        let query = sqlx::query_scalar(
            "SELECT at FROM event WHERE id = (SELECT seq FROM sqlite_sequence WHERE name = 'event')",
        );
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// The number of the latest event; 0 when there is none.
    pub async fn last_event_id(&self) -> Result<i64> {
        let query = "SELECT coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'event'), 0)";
        Ok(sqlx::query_scalar(query).fetch_one(self.reader()?).await?)
    }

    /// The clock was set by so much: the times at which the parts in the farm were claimed are set with it, so that each has
    /// waited as long as before.
    pub async fn keep_ages(&self, jump: SignedDuration) -> Result<()> {
        let mut change = self.change().await?;
        sqlx::query(
            "UPDATE part SET claimed_at = strftime('%Y-%m-%dT%H:%M:%fZ', claimed_at, ? || ' seconds') \
             WHERE state IN ('claimed', 'waiting', 'batched')",
        )
        .bind(format!("{:+.3}", jump.as_secs_f64()))
        .execute(change.db())
        .await?;
        change.event("clock_set", "", None, None, &format!("by {jump:#}; the ages of parts are kept")).await?;
        change.commit().await
    }

    /// The events of a part, oldest first.
    pub async fn events_of_part(&self, part: PartId) -> Result<Vec<EventRow>> {
        let query = sqlx::query_as("SELECT * FROM event WHERE part_id = ? ORDER BY id").bind(part);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The events of a build, oldest first; of its parts only those that name it.
    pub async fn events_of_build(&self, build: BuildId) -> Result<Vec<EventRow>> {
        let query = sqlx::query_as("SELECT * FROM event WHERE build_id = ? ORDER BY id").bind(build);
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
