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
#[serde(rename_all = "kebab-case")]
pub enum ReceiverKind {
    /// An address to which messages are posted.
    Webhook,
    /// A program to which messages are passed.
    Command,
    /// Mails about what needs a person.
    EmailAlert,
    /// Mails about refused files.
    EmailRefused,
    /// Mails about due dates at risk.
    EmailAtRisk,
    /// Mails to customers whose orders are complete.
    EmailOrderComplete,
}

own_word!(ReceiverKind);

impl ReceiverKind {
    /// Every kind.
    pub const ALL: [Self; 6] = [
        Self::Webhook,
        Self::Command,
        Self::EmailAlert,
        Self::EmailRefused,
        Self::EmailAtRisk,
        Self::EmailOrderComplete,
    ];

    /// What it is called in sentences.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Webhook => "webhook",
            Self::Command => "command",
            Self::EmailAlert => "mail of alerts",
            Self::EmailRefused => "mail of refused files",
            Self::EmailAtRisk => "mail of dates at risk",
            Self::EmailOrderComplete => "mail to customers",
        }
    }
}

/// Delivery state of a receiver.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ReceiverRow {
    /// Which receiver.
    pub name: ReceiverKind,
    /// The latest event that was delivered to it or is not meant for it.
    #[serde(rename = "told_id")]
    pub delivered_id: i64,
    /// When an event was delivered to it last; `None` = none was yet, or it is not known.
    pub told_at: Option<UtcTimestamp>,
    /// Since when delivery fails.
    pub failing_at: Option<UtcTimestamp>,
    /// Why delivery fails; "" = it works.
    pub failure: String,
    /// Number of events that became too old before they could be delivered, or were refused for ever.
    pub dropped: u64,
}

sql_row!(ReceiverRow { name, delivered_id = "told_id", told_at, failing_at, failure, dropped });

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
        Ok(self.events_after(after, kinds, 1).await?.pop())
    }

    /// The first events of these kinds after event `after`, at most `limit`, in order. A change holds the lock of all changes from before
    /// its events get their numbers until it is committed: no smaller number ever appears after a larger one.
    pub async fn events_after(&self, after: i64, kinds: &[EventKind], limit: u32) -> Result<Vec<EventRow>> {
        let query = sql::select_as(
            "FROM event WHERE id > $1 AND kind IN (SELECT value FROM json_each($2)) ORDER BY id LIMIT $3",
        );
        Ok(query.bind(after).bind(json_array(kinds)).bind(limit).fetch_all(self.reader()?).await?)
    }

    /// Number of events of these kinds after event `after`.
    pub async fn count_events_after(&self, after: i64, kinds: &[EventKind]) -> Result<u64> {
        let query =
            sql::query_scalar("SELECT count(*) FROM event WHERE id > $1 AND kind IN (SELECT value FROM json_each($2))");
        Ok(query.bind(after).bind(json_array(kinds)).fetch_one(self.reader()?).await?)
    }

    /// Records that a receiver has all events up to this one, the last of them now.
    pub async fn mark_delivered(&self, name: ReceiverKind, event: i64) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        let delivered = "UPDATE receiver SET told_id = CASE WHEN told_id > $1 THEN told_id ELSE $1 END, told_at = $2, failing_at = NULL, failure = '' WHERE name = $3";
        sql::query(delivered).bind(event).bind(now).bind(name).execute(change.db()).await?;
        change.commit().await
    }

    /// Records that no event up to this one is for a receiver any more.
    pub async fn pass_events(&self, name: ReceiverKind, event: i64) -> Result<()> {
        let mut change = self.begin_change().await?;
        let passed = "UPDATE receiver SET told_id = CASE WHEN told_id > $1 THEN told_id ELSE $1 END, failing_at = NULL, failure = '' WHERE name = $2";
        sql::query(passed).bind(event).bind(name).execute(change.db()).await?;
        change.commit().await
    }

    /// Records that a receiver refuses an event for ever, and writes an event about it.
    pub async fn record_refused_delivery(&self, name: ReceiverKind, event: i64, why: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let refused = sql::query("UPDATE receiver SET dropped = dropped + 1 WHERE name = $1");
        refused.bind(name).execute(change.db()).await?;
        let detail = format!("1 to the {}, event {event}: {why}", name.noun());
        change.write_event(EventKind::MessagesDropped, "", None, None, &detail).await?;
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
        let detail = format!("{dropped} to the {}, older than {}", name.noun(), UtcTimestamp(before));
        change.write_event(EventKind::MessagesDropped, "", None, None, &detail).await?;
        change.commit().await?;
        Ok(dropped)
    }
}

fn json_array(kinds: &[EventKind]) -> String {
    serde_json::json!(kinds).to_string()
}
