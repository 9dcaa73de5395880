//! The daemon's sign of life, so that faces can say whether it runs.

use jiff::Timestamp;
use serde::Serialize;
use sqlx::FromRow;

use super::Utc;

/// A beat is this long a sign of life, seconds; the daemon beats every few seconds.
pub const BEAT_LASTS_SECS: i64 = 15;

/// A sign of life.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Beat {
    /// Process.
    pub pid: u32,
    /// Server.
    pub host: String,
    /// Version of nestd.
    pub version: String,
    /// When this daemon started.
    pub started_at: Timestamp,
    /// One line on what it does.
    pub status: String,
}

/// The daemon that served this ledger last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct DaemonRow {
    /// Process.
    pub pid: u32,
    /// Server.
    pub host: String,
    /// Version of nestd.
    pub version: String,
    /// When it started.
    pub started_at: Utc,
    /// Its last sign of life.
    pub beat_at: Utc,
    /// One line on what it did.
    pub status: String,
    /// Whether the last sign of life is young enough.
    pub alive: bool,
}
