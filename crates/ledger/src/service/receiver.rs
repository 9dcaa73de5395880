//! Receivers of notifications, and which events were delivered to them. Delivery of an event is retried until the
//! receiver has it, even after a restart of the daemon. A new receiver starts with the events from now on.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::{
    EventKind, EventRow, Ledger, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
};

/// Kind of receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReceiverKind {
    /// An address to which messages are posted.
    Webhook,
    /// A program to which messages are passed.
    Command,
}

own_word!(ReceiverKind);

/// Delivery state of a receiver.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ReceiverRow {
    /// Which receiver.
    pub name: ReceiverKind,
    /// The latest event that was delivered to it or is not meant for it.
    #[serde(rename = "told_id")]
    pub delivered_id: i64,
    /// Since when delivery fails.
    pub failing_at: Option<UtcTimestamp>,
    /// Why delivery fails; "" = it works.
    pub failure: String,
    /// Number of events that became too old before they could be delivered.
    pub dropped: u64,
}

sql_row!(ReceiverRow { name, delivered_id = "told_id", failing_at, failure, dropped });

impl Ledger {
    /// All receivers.
    pub async fn list_receivers(&self) -> Result<Vec<ReceiverRow>> {
        Ok(sql::select_as("FROM receiver ORDER BY name").fetch_all(self.reader()?).await?)
    }

    /// Returns the delivery state of a receiver. A new receiver starts now.
    pub async fn find_or_add_receiver(&self, name: ReceiverKind) -> Result<ReceiverRow> {
        let query = || sql::select_as("FROM receiver WHERE name = $1").bind(name);
        if let Some(known) = query().fetch_optional(self.reader()?).await? {
            return Ok(known);
        }
        let mut change = self.begin_change().await?;
        let now = "INSERT INTO receiver (name, told_id) \
            VALUES ($1, coalesce((SELECT max(id) FROM event), 0)) ON CONFLICT DO NOTHING";
        sql::query(now).bind(name).execute(change.db()).await?;
        let row = query().fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(row)
    }

    /// Removes a receiver that is not configured any more. If it is configured again later, it is a new one.
    pub async fn forget_receiver(&self, name: ReceiverKind) -> Result<()> {
        if self.list_receivers().await?.iter().any(|row| row.name == name) {
            let mut change = self.begin_change().await?;
            sql::query("DELETE FROM receiver WHERE name = $1").bind(name).execute(change.db()).await?;
            change.commit().await?;
        }
        Ok(())
    }

    /// The first event of these kinds after event `after`.
    pub async fn next_event(&self, after: i64, kinds: &[EventKind]) -> Result<Option<EventRow>> {
        let query = sql::select_as(
            "FROM event WHERE id > $1 AND kind IN (SELECT value FROM json_each($2)) ORDER BY id LIMIT 1",
        );
        Ok(query.bind(after).bind(json_array(kinds)).fetch_optional(self.reader()?).await?)
    }

    /// Number of events of these kinds after event `after`.
    pub async fn count_events_after(&self, after: i64, kinds: &[EventKind]) -> Result<u64> {
        let query =
            sql::query_scalar("SELECT count(*) FROM event WHERE id > $1 AND kind IN (SELECT value FROM json_each($2))");
        Ok(query.bind(after).bind(json_array(kinds)).fetch_one(self.reader()?).await?)
    }

    /// Records that a receiver has all events up to this one.
    pub async fn mark_delivered(&self, name: ReceiverKind, event: i64) -> Result<()> {
        let mut change = self.begin_change().await?;
        let delivered = "UPDATE receiver SET told_id = CASE WHEN told_id > $1 THEN told_id ELSE $1 END, failing_at = NULL, failure = '' WHERE name = $2";
        sql::query(delivered).bind(event).bind(name).execute(change.db()).await?;
        change.commit().await
    }

    /// Records that a delivery failed, and why.
    pub async fn record_delivery_failure(&self, name: ReceiverKind, why: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        let failing = "UPDATE receiver SET failing_at = coalesce(failing_at, $1), failure = $2 WHERE name = $3";
        sql::query(failing).bind(now).bind(why).bind(name).execute(change.db()).await?;
        change.commit().await
    }

    /// Drops the undelivered events of a receiver from before a time, and writes an event about it. Returns the number
    /// of dropped events.
    pub async fn drop_undelivered(&self, name: ReceiverKind, before: Timestamp, kinds: &[EventKind]) -> Result<u64> {
        let mut change = self.begin_change().await?;
        let delivered: i64 =
            sql::query_scalar("SELECT told_id FROM receiver WHERE name = $1").bind(name).fetch_one(change.db()).await?;
        let (dropped, last): (u64, Option<i64>) = sql::query_as(
            "SELECT count(*), max(id) FROM event WHERE id > $1 AND at < $2 AND kind IN (SELECT value FROM json_each($3))",
        )
        .bind(delivered)
        .bind(UtcTimestamp(before))
        .bind(json_array(kinds))
        .fetch_one(change.db())
        .await?;
        let Some(last) = last else { return Ok(0) };
        sql::query("UPDATE receiver SET told_id = $1, dropped = dropped + $2 WHERE name = $3")
            .bind(last)
            .bind(dropped as i64)
            .bind(name)
            .execute(change.db())
            .await?;
        let detail = format!("{dropped} to the {name}, older than {}", UtcTimestamp(before));
        change.write_event(EventKind::MessagesDropped, "", None, None, &detail).await?;
        change.commit().await?;
        Ok(dropped)
    }
}

fn json_array(kinds: &[EventKind]) -> String {
    serde_json::json!(kinds).to_string()
}
