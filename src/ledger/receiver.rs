//! Receivers: who is told of events, and how far. An event is told until the receiver has it, however often the daemon
//! restarts meanwhile; a new receiver begins with what happens from now on.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{EventRow, Ledger, Utc, error::Result, word::own_word};

/// Who is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Receiver {
    /// An address that messages are posted to.
    Webhook,
    /// A program that messages are given to.
    Command,
}

own_word!(Receiver);

/// How far a receiver has been told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct ReceiverRow {
    /// Which.
    pub name: Receiver,
    /// The latest event that it was told, or that is not for it.
    pub told_id: i64,
    /// Since when it cannot be told.
    pub failing_at: Option<Utc>,
    /// Why it cannot be told, "" = it can.
    pub failure: String,
    /// Events that became too old before it could be told.
    pub dropped: u64,
}

/// Kind of the event that says that events were dropped.
pub const DROPPED: &str = "messages_dropped";

impl Ledger {
    /// The receivers that there are.
    pub async fn receivers(&self) -> Result<Vec<ReceiverRow>> {
        Ok(sqlx::query_as("SELECT * FROM receiver ORDER BY name").fetch_all(self.reader()?).await?)
    }

    /// How far a receiver has been told. One that is new begins now.
    pub async fn receiver(&self, name: Receiver) -> Result<ReceiverRow> {
        let query = || sqlx::query_as("SELECT * FROM receiver WHERE name = ?").bind(name);
        if let Some(known) = query().fetch_optional(self.reader()?).await? {
            return Ok(known);
        }
        let mut change = self.change().await?;
        let now = "INSERT INTO receiver (name, told_id) \
            VALUES (?, coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'event'), 0)) ON CONFLICT DO NOTHING";
        sqlx::query(now).bind(name).execute(change.db()).await?;
        let row = query().fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(row)
    }

    /// A receiver is not configured any more: when it is again, it is a new one.
    pub async fn forget_receiver(&self, name: Receiver) -> Result<()> {
        if self.receivers().await?.iter().any(|row| row.name == name) {
            let mut change = self.change().await?;
            sqlx::query("DELETE FROM receiver WHERE name = ?").bind(name).execute(change.db()).await?;
            change.commit().await?;
        }
        Ok(())
    }

    /// The first event of these kinds after another one.
    pub async fn next_event(&self, after: i64, kinds: &[&str]) -> Result<Option<EventRow>> {
        let query = sqlx::query_as(
            "SELECT * FROM event WHERE id > ? AND kind IN (SELECT value FROM json_each(?)) ORDER BY id LIMIT 1",
        );
        Ok(query.bind(after).bind(json(kinds)).fetch_optional(self.reader()?).await?)
    }

    /// How many events of these kinds there are after another one.
    pub async fn events_after(&self, after: i64, kinds: &[&str]) -> Result<u64> {
        let query =
            sqlx::query_scalar("SELECT count(*) FROM event WHERE id > ? AND kind IN (SELECT value FROM json_each(?))");
        Ok(query.bind(after).bind(json(kinds)).fetch_one(self.reader()?).await?)
    }

    /// A receiver has all up to this event.
    pub async fn told(&self, name: Receiver, event: i64) -> Result<()> {
        let mut change = self.change().await?;
        let told = "UPDATE receiver SET told_id = max(told_id, ?), failing_at = NULL, failure = '' WHERE name = ?";
        sqlx::query(told).bind(event).bind(name).execute(change.db()).await?;
        change.commit().await
    }

    /// A receiver could not be told, and why.
    pub async fn not_told(&self, name: Receiver, why: &str) -> Result<()> {
        let mut change = self.change().await?;
        let now = change.now;
        let failing = "UPDATE receiver SET failing_at = coalesce(failing_at, ?), failure = ? WHERE name = ?";
        sqlx::query(failing).bind(now).bind(why).bind(name).execute(change.db()).await?;
        change.commit().await
    }

    /// Drops what a receiver should have been told before a time, and writes an event that says so; how many there were.
    pub async fn drop_untold(&self, name: Receiver, before: Timestamp, kinds: &[&str]) -> Result<u64> {
        let mut change = self.change().await?;
        let told: i64 =
            sqlx::query_scalar("SELECT told_id FROM receiver WHERE name = ?").bind(name).fetch_one(change.db()).await?;
        let (dropped, last): (u64, Option<i64>) = sqlx::query_as(
            "SELECT count(*), max(id) FROM event WHERE id > ? AND at < ? AND kind IN (SELECT value FROM json_each(?))",
        )
        .bind(told)
        .bind(Utc(before))
        .bind(json(kinds))
        .fetch_one(change.db())
        .await?;
        let Some(last) = last else { return Ok(0) };
        sqlx::query("UPDATE receiver SET told_id = ?, dropped = dropped + ? WHERE name = ?")
            .bind(last)
            .bind(dropped as i64)
            .bind(name)
            .execute(change.db())
            .await?;
        let detail = format!("{dropped} to the {name}, older than {}", Utc(before));
        change.event(DROPPED, "", None, None, &detail).await?;
        change.commit().await?;
        Ok(dropped)
    }
}

fn json(kinds: &[&str]) -> String {
    serde_json::json!(kinds).to_string()
}
