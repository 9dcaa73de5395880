//! Events: a permanent, ordered record of what happened to parts and builds.

use jiff::SignedDuration;
use serde::Serialize;

use crate::{
    BuildId, EventKind, Ledger, PartId, RefusalCause, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// An event.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct EventRow {
    /// Its number.
    pub id: i64,
    /// When it happened.
    pub at: UtcTimestamp,
    /// Kind: the state that was entered, or a word for other events.
    pub kind: EventKind,
    /// Machine, "" = none.
    pub machine: String,
    /// The part concerned.
    pub part_id: Option<PartId>,
    /// The build concerned.
    pub build_id: Option<BuildId>,
    /// Further details.
    pub detail: String,
    /// For a refusal: its [`RefusalCause`] as a word; for an alert: its kind; "" otherwise.
    pub cause: String,
}

sql_row!(EventRow { id, at, kind, machine, part_id, build_id, detail, cause });

impl Ledger {
    /// Writes an event.
    pub async fn write_event(
        &self,
        kind: EventKind,
        machine: &str,
        part: Option<PartId>,
        build: Option<BuildId>,
        detail: &str,
    ) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.write_event(kind, machine, part, build, detail).await?;
        change.commit().await
    }

    /// Records that a file was refused before it became a part.
    pub async fn record_file_refusal(&self, machine: &str, cause: RefusalCause, detail: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.write_refusal_event(machine, None, cause, detail).await?;
        change.commit().await
    }

    /// Records that something needs a person. `alert` is the word of its kind.
    pub async fn record_alert(&self, machine: &str, alert: &str, detail: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.write_caused_event(EventKind::Alert, machine, None, alert, detail).await?;
        change.commit().await
    }

    /// When the latest event happened.
    pub async fn last_event_at(&self) -> Result<Option<UtcTimestamp>> {
        let query = sql::query_scalar("SELECT at FROM event ORDER BY id DESC LIMIT 1");
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Finds an event by its number.
    pub async fn find_event(&self, id: i64) -> Result<Option<EventRow>> {
        Ok(sql::select_as("FROM event WHERE id = $1").bind(id).fetch_optional(self.reader()?).await?)
    }

    /// Number of the latest event; 0 if there is none.
    pub async fn last_event_id(&self) -> Result<i64> {
        let query = "SELECT coalesce(max(id), 0) FROM event";
        Ok(sql::query_scalar(query).fetch_one(self.reader()?).await?)
    }

    /// Numbers of the latest event and of the latest command; 0 if there is none. Whoever changes the farm adds one of them.
    pub async fn latest_numbers(&self) -> Result<(i64, i64)> {
        let query = "SELECT coalesce((SELECT max(id) FROM event), 0), coalesce((SELECT max(id) FROM command), 0)";
        Ok(sql::query_as(query).fetch_one(self.reader()?).await?)
    }

    /// Adjusts to a clock that was set by `jump`: shifts the times at which the parts in the farm were claimed, moved or
    /// put back, so their ages stay the same.
    pub async fn shift_claim_times(&self, jump: SignedDuration) -> Result<()> {
        /// A part; when it was claimed, changed its state, was put back, and since when it waits.
        type TimesOfPart = (PartId, UtcTimestamp, UtcTimestamp, Option<UtcTimestamp>, Option<UtcTimestamp>);
        let mut change = self.begin_change().await?;
        let parts: Vec<TimesOfPart> = sql::query_as(
            "SELECT id, claimed_at, state_at, put_back_at, waits_since FROM part WHERE state IN ('claimed', 'waiting', 'batched') \
             AND ($1 = '' OR machine NOT IN (SELECT machine FROM station WHERE node NOT IN ('', $1)))",
        )
        .bind(self.node())
        .fetch_all(change.db())
        .await?;
        let shifted = |at: UtcTimestamp| at.checked_add(jump).map_or(at, UtcTimestamp);
        for (part, claimed_at, state_at, put_back_at, waits_since) in parts {
            let shift = sql::query(
                "UPDATE part SET claimed_at = $1, state_at = $2, put_back_at = $3, waits_since = $4 WHERE id = $5",
            );
            let shift = shift.bind(shifted(claimed_at)).bind(shifted(state_at)).bind(put_back_at.map(shifted));
            shift.bind(waits_since.map(shifted)).bind(part).execute(change.db()).await?;
        }
        change
            .write_event(EventKind::ClockSet, "", None, None, &format!("by {jump:#}; the ages of parts are kept"))
            .await?;
        change.commit().await
    }

    /// The events of a part, oldest first.
    pub async fn events_of_part(&self, part: PartId) -> Result<Vec<EventRow>> {
        let query = sql::select_as("FROM event WHERE part_id = $1 ORDER BY id").bind(part);
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The events of a build, oldest first. Events of its parts are included only if they refer to the build.
    pub async fn events_of_build(&self, build: BuildId) -> Result<Vec<EventRow>> {
        let query = sql::select_as("FROM event WHERE build_id = $1 ORDER BY id").bind(build);
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
