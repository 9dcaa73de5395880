//! Machines as the daemon sees them, for users who monitor the farm. When a machine becomes unavailable or available
//! again, this is written as one event, even if the daemon restarts meanwhile.

use serde::Serialize;

use super::{
    EventKind, Ledger, UtcTimestamp,
    change::LedgerChange,
    error::Result,
    sql::{self, sql_row},
};

/// State of a machine as observed by the daemon.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObservedMachine {
    /// Machine profile.
    pub profile: String,
    /// When its hot folder was last scanned; `None` = not since the daemon started.
    pub scanned_at: Option<UtcTimestamp>,
    /// Whether its hot folder can be used.
    pub is_inbox_there: bool,
    /// Whether its queue folder can be written to.
    pub is_queue_writable: bool,
    /// Why it is unavailable; "" = it is available, `None` = not known yet.
    pub trouble: Option<String>,
}

/// Last observed state of a machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MachineRow {
    /// Machine profile.
    pub profile: String,
    /// When its hot folder was last scanned.
    pub scanned_at: Option<UtcTimestamp>,
    /// Whether its hot folder can be used.
    pub is_inbox_there: bool,
    /// Whether its queue folder can be written to.
    pub is_queue_writable: bool,
    /// Why it is unavailable; "" = it is available.
    pub trouble: String,
    /// Since when it has been unavailable.
    pub trouble_at: Option<UtcTimestamp>,
}

sql_row!(MachineRow { profile, scanned_at, is_inbox_there, is_queue_writable, trouble, trouble_at });

impl Ledger {
    /// The last observed states of all machines, by name.
    pub async fn list_machines(&self) -> Result<Vec<MachineRow>> {
        Ok(sql::query_as("SELECT * FROM station ORDER BY profile").fetch_all(self.reader()?).await?)
    }
}

/// Records the observed machines. Removes machines that the daemon does not serve any more.
pub(super) async fn record_machines(change: &mut LedgerChange, seen: &[ObservedMachine]) -> Result<()> {
    let known: Vec<MachineRow> = sql::query_as("SELECT * FROM station").fetch_all(change.db()).await?;
    for gone in known.iter().filter(|row| !seen.iter().any(|s| s.profile == row.profile)) {
        sql::query("DELETE FROM station WHERE profile = $1").bind(&gone.profile).execute(change.db()).await?;
    }
    for seen in seen {
        let known = known.iter().find(|row| row.profile == seen.profile);
        let was = known.map_or("", |row| &row.trouble);
        let is = seen.trouble.as_deref().unwrap_or(was);
        let since = match (was.is_empty(), is.is_empty()) {
            (_, true) => None,
            (true, false) => Some(change.now),
            (false, false) => known.and_then(|row| row.trouble_at),
        };
        match (was.is_empty(), is.is_empty()) {
            (true, false) => change.write_event(EventKind::Unavailable, &seen.profile, None, None, is).await?,
            (false, true) => change.write_event(EventKind::Available, &seen.profile, None, None, "").await?,
            _ => {}
        }
        sql::query(
            "INSERT INTO station (profile, scanned_at, is_inbox_there, is_queue_writable, trouble, trouble_at) \
             VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (profile) DO UPDATE SET \
             scanned_at = coalesce(excluded.scanned_at, station.scanned_at), is_inbox_there = excluded.is_inbox_there, \
             is_queue_writable = excluded.is_queue_writable, trouble = excluded.trouble, trouble_at = excluded.trouble_at",
        )
        .bind(&seen.profile)
        .bind(seen.scanned_at)
        .bind(seen.is_inbox_there)
        .bind(seen.is_queue_writable)
        .bind(is)
        .bind(since)
        .execute(change.db())
        .await?;
    }
    Ok(())
}
