//! Stations: every machine as the daemon that serves it sees it, for those who watch the farm from outside. That one becomes
//! unavailable, or available again, is an event, told once however often the daemon restarts meanwhile.

use serde::Serialize;
use sqlx::FromRow;

use super::{Ledger, Utc, change::Change, error::Result};

/// What the daemon sees of a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StationSeen {
    /// Machine profile.
    pub profile: String,
    /// When its hot folder was last looked through; `None` = not in this run.
    pub scanned_at: Option<Utc>,
    /// Whether its hot folder can be used.
    pub is_inbox_there: bool,
    /// Whether its queue folder can be written to.
    pub is_queue_writable: bool,
    /// Why it is unavailable, "" = it is available; `None` = not known yet.
    pub trouble: Option<String>,
}

/// A machine as the daemon saw it last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct StationRow {
    /// Machine profile.
    pub profile: String,
    /// When its hot folder was last looked through.
    pub scanned_at: Option<Utc>,
    /// Whether its hot folder can be used.
    pub is_inbox_there: bool,
    /// Whether its queue folder can be written to.
    pub is_queue_writable: bool,
    /// Why it is unavailable, "" = it is available.
    pub trouble: String,
    /// Since when it is unavailable.
    pub trouble_at: Option<Utc>,
}

impl Ledger {
    /// The machines as the daemon saw them last, by name.
    pub async fn stations(&self) -> Result<Vec<StationRow>> {
        Ok(sqlx::query_as("SELECT * FROM station ORDER BY profile").fetch_all(self.reader()?).await?)
    }
}

/// Notes what the daemon sees; machines that it does not serve any more are forgotten.
pub(super) async fn note(change: &mut Change, seen: &[StationSeen]) -> Result<()> {
    let known: Vec<StationRow> = sqlx::query_as("SELECT * FROM station").fetch_all(change.db()).await?;
    for gone in known.iter().filter(|row| !seen.iter().any(|s| s.profile == row.profile)) {
        sqlx::query("DELETE FROM station WHERE profile = ?").bind(&gone.profile).execute(change.db()).await?;
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
            (true, false) => change.event("unavailable", &seen.profile, None, None, is).await?,
            (false, true) => change.event("available", &seen.profile, None, None, "").await?,
            _ => {}
        }
        sqlx::query(
            "INSERT INTO station (profile, scanned_at, is_inbox_there, is_queue_writable, trouble, trouble_at) \
             VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (profile) DO UPDATE SET \
             scanned_at = coalesce(excluded.scanned_at, scanned_at), is_inbox_there = excluded.is_inbox_there, \
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
