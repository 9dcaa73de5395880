//! Events: a permanent, ordered record of what happened to parts and builds.

use jiff::SignedDuration;
use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, EventKind, Ledger, PartId, RefusalCause, UtcTimestamp, error::Result};

/// An event.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct EventRow {
    /// Its number.
    pub id: i64,
    /// When it happened.
    pub at: UtcTimestamp,
    /// Kind: the state that was entered, or a word for other events.
    pub kind: EventKind,
    /// Machine profile, "" = none.
    pub profile: String,
    /// The part concerned.
    pub part_id: Option<PartId>,
    /// The build concerned.
    pub build_id: Option<BuildId>,
    /// Further details.
    pub detail: String,
    /// For a refusal: its [`RefusalCause`] as a word; "" otherwise.
    pub cause: String,
}

impl Ledger {
    /// Writes an event.
    pub async fn write_event(
        &self,
        kind: EventKind,
        profile: &str,
        part: Option<PartId>,
        build: Option<BuildId>,
        detail: &str,
    ) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.write_event(kind, profile, part, build, detail).await?;
        change.commit().await
    }

    /// Records that a file was refused before it became a part.
    pub async fn record_file_refusal(&self, profile: &str, cause: RefusalCause, detail: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.write_refusal_event(EventKind::Refused, profile, None, cause, detail).await?;
        change.commit().await
    }

    /// When the latest event happened.
    pub async fn last_event_at(&self) -> Result<Option<UtcTimestamp>> {
        let query = sqlx::query_scalar(
            "SELECT at FROM event WHERE id = (SELECT seq FROM sqlite_sequence WHERE name = 'event')",
        );
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Number of the latest event; 0 if there is none.
    pub async fn last_event_id(&self) -> Result<i64> {
        let query = "SELECT coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'event'), 0)";
        Ok(sqlx::query_scalar(query).fetch_one(self.reader()?).await?)
    }

    /// Adjusts to a clock that was set by `jump`: shifts the times at which the parts in the farm were claimed or put back, so
    /// their ages stay the same.
    pub async fn shift_claim_times(&self, jump: SignedDuration) -> Result<()> {
        let mut change = self.begin_change().await?;
        sqlx::query(
            "UPDATE part SET claimed_at = strftime('%Y-%m-%dT%H:%M:%fZ', claimed_at, ?1 || ' seconds'), \
             put_back_at = strftime('%Y-%m-%dT%H:%M:%fZ', put_back_at, ?1 || ' seconds') \
             WHERE state IN ('claimed', 'waiting', 'batched')",
        )
        .bind(format!("{:+.3}", jump.as_secs_f64()))
        .execute(change.db())
        .await?;
        change
            .write_event(EventKind::ClockSet, "", None, None, &format!("by {jump:#}; the ages of parts are kept"))
            .await?;
        change.commit().await
    }

    /// The events of a part, oldest first.
    pub async fn events_of_part(&self, part: PartId) -> Result<Vec<EventRow>> {
        let query = sqlx::query_as("SELECT * FROM event WHERE part_id = ? ORDER BY id").bind(part);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The events of a build, oldest first. Events of its parts are included only if they refer to the build.
    pub async fn events_of_build(&self, build: BuildId) -> Result<Vec<EventRow>> {
        let query = sqlx::query_as("SELECT * FROM event WHERE build_id = ? ORDER BY id").bind(build);
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
