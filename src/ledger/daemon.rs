//! The heartbeat of the daemon. It tells user interfaces whether the daemon runs.

use jiff::{SignedDuration, Timestamp};
use rustix::{
    fs::{FlockOperation, flock},
    io::Errno,
    process::{Pid, test_kill_process},
    system::uname,
};
use schemars::JsonSchema;
use serde::Serialize;

use std::fs::File;

use super::{
    Ledger, ObservedMachine, UtcTimestamp,
    error::Result,
    machine,
    sql::{self, FromSqlRow, SqlRow},
};

/// Time for which a heartbeat is valid, seconds. The daemon sends one every few seconds.
pub const HEARTBEAT_VALID_SECS: i64 = 15;

/// The file beside the ledger that a running daemon holds locked. It shows that the daemon is alive even if the disk is
/// full.
pub const LOCK_NAME: &str = "nestd.lock";

/// A heartbeat.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DaemonHeartbeat {
    /// Process.
    pub pid: u32,
    /// Server.
    pub host: String,
    /// Version of nestd.
    pub version: String,
    /// When the daemon process started.
    pub started_at: Timestamp,
    /// One line on what it does.
    pub status: String,
    /// The machines that the daemon serves.
    pub machines: Vec<ObservedMachine>,
}

/// The daemon that served this ledger last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DaemonRow {
    /// Process.
    pub pid: u32,
    /// Server.
    pub host: String,
    /// Version of nestd.
    pub version: String,
    /// When it started.
    pub started_at: UtcTimestamp,
    /// Its last heartbeat.
    pub beat_at: UtcTimestamp,
    /// One line on what it did.
    pub status: String,
    /// Whether the daemon runs: its last heartbeat is younger than [`HEARTBEAT_VALID_SECS`], or its lock or lease is held. If the
    /// daemon ran on this server, its process must exist too.
    pub alive: bool,
}

impl FromSqlRow for DaemonRow {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        Ok(Self {
            pid: row.column("pid")?,
            host: row.column("host")?,
            version: row.column("version")?,
            started_at: row.column("started_at")?,
            beat_at: row.column("beat_at")?,
            status: row.column("status")?,
            alive: false,
        })
    }
}

impl Ledger {
    /// Writes a heartbeat.
    pub async fn write_heartbeat(&self, heartbeat: &DaemonHeartbeat) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        sql::query(
            "INSERT INTO daemon (id, pid, host, version, started_at, beat_at, status) VALUES (1, $1, $2, $3, $4, $5, $6) \
             ON CONFLICT (id) DO UPDATE SET pid = excluded.pid, host = excluded.host, version = excluded.version, \
             started_at = excluded.started_at, beat_at = excluded.beat_at, status = excluded.status",
        )
        .bind(heartbeat.pid)
        .bind(&heartbeat.host)
        .bind(&heartbeat.version)
        .bind(UtcTimestamp(heartbeat.started_at))
        .bind(now)
        .bind(&heartbeat.status)
        .execute(change.db())
        .await?;
        machine::record_machines(&mut change, &heartbeat.machines).await?;
        change.commit().await
    }

    /// Records an orderly shutdown: no daemon serves this ledger.
    pub async fn record_shutdown(&self) -> Result<()> {
        let mut change = self.begin_change().await?;
        sql::query("DELETE FROM daemon").execute(change.db()).await?;
        change.commit().await
    }

    /// The daemon that serves this ledger, or that ended without an orderly shutdown.
    pub async fn last_daemon(&self) -> Result<Option<DaemonRow>> {
        let query = sql::query_as("SELECT pid, host, version, started_at, beat_at, status FROM daemon");
        let row: Option<DaemonRow> = query.fetch_optional(self.reader()?).await?;
        // A heartbeat in the future was written before the clock was set back. The next one follows within seconds.
        let beats = |row: &DaemonRow| {
            self.now().duration_since(*row.beat_at).abs() < SignedDuration::from_secs(HEARTBEAT_VALID_SECS)
        };
        let is_held = match &row {
            Some(row) if !beats(row) => self.is_held().await?,
            _ => false,
        };
        let lives = |row: &DaemonRow| (beats(row) || is_held) && !row.is_process_gone();
        Ok(row.map(|row| DaemonRow { alive: lives(&row), ..row }))
    }

    /// Whether a daemon serves this ledger, including one that cannot write a heartbeat (a full disk) or is just
    /// starting.
    pub async fn is_served(&self) -> Result<bool> {
        Ok(self.is_held().await? || self.last_daemon().await?.is_some_and(|daemon| daemon.alive))
    }

    /// Whether a process holds the lock file beside the ledger, or the lease of a ledger on a server.
    async fn is_held(&self) -> Result<bool> {
        Ok(self.is_leased().await?.unwrap_or_else(|| self.is_locked()))
    }

    /// Whether a process holds the lock file beside the ledger. `false` if this cannot be determined.
    fn is_locked(&self) -> bool {
        let Some(file) = self.file() else { return false };
        let lock = File::open(super::location::parent_folder(file).join(LOCK_NAME));
        lock.is_ok_and(|lock| flock(&lock, FlockOperation::NonBlockingLockShared) == Err(Errno::WOULDBLOCK))
    }
}

impl DaemonRow {
    /// Whether the daemon runs but could not write a heartbeat for a while. Its other data is then outdated as well.
    pub fn is_silent(&self, now: Timestamp) -> bool {
        self.alive && now.duration_since(*self.beat_at).abs() >= SignedDuration::from_secs(HEARTBEAT_VALID_SECS)
    }

    /// Whether the daemon ran on this server and its process does not exist any more. So nobody needs to wait for its
    /// next heartbeat.
    fn is_process_gone(&self) -> bool {
        let is_here = uname().nodename().to_string_lossy() == self.host;
        let pid = i32::try_from(self.pid).ok().and_then(Pid::from_raw);
        is_here && pid.is_some_and(|pid| test_kill_process(pid) == Err(Errno::SRCH))
    }
}
