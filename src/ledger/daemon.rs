//! The daemon's sign of life, so that faces can say whether it runs.

use jiff::{SignedDuration, Timestamp};
use rustix::{
    fs::{FlockOperation, flock},
    io::Errno,
    process::{Pid, test_kill_process},
    system::uname,
};
use schemars::JsonSchema;
use serde::Serialize;
use sqlx::FromRow;

use std::{fs::File, path::Path};

use super::{Ledger, StationSeen, Utc, error::Result, station};

/// A beat is this long a sign of life, seconds; the daemon beats every few seconds.
pub const BEAT_LASTS_SECS: i64 = 15;

/// The file beside the ledger that a daemon holds locked for as long as it lives: a sign of life that needs no room on a disk.
pub const LOCK_NAME: &str = "nestd.lock";

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
    /// The machines that it serves.
    pub stations: Vec<StationSeen>,
}

/// The daemon that served this ledger last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow, JsonSchema)]
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
    /// Whether it runs: its last sign of life is younger than [`BEAT_LASTS_SECS`] or its lock is held and, on its own server, its
    /// process is there.
    #[sqlx(default)]
    pub alive: bool,
}

impl Ledger {
    /// Writes a sign of life.
    pub async fn beat(&self, beat: &Beat) -> Result<()> {
        let mut change = self.change().await?;
        let now = change.now;
        sqlx::query(
            "INSERT INTO daemon (id, pid, host, version, started_at, beat_at, status) VALUES (1, ?, ?, ?, ?, ?, ?) \
             ON CONFLICT (id) DO UPDATE SET pid = excluded.pid, host = excluded.host, version = excluded.version, \
             started_at = excluded.started_at, beat_at = excluded.beat_at, status = excluded.status",
        )
        .bind(beat.pid)
        .bind(&beat.host)
        .bind(&beat.version)
        .bind(Utc(beat.started_at))
        .bind(now)
        .bind(&beat.status)
        .execute(change.db())
        .await?;
        station::note(&mut change, &beat.stations).await?;
        change.commit().await
    }

    /// The daemon has stopped in order: nobody serves this ledger.
    pub async fn farewell(&self) -> Result<()> {
        let mut change = self.change().await?;
        sqlx::query("DELETE FROM daemon").execute(change.db()).await?;
        change.commit().await
    }

    /// The daemon that serves this ledger, or that died without a farewell.
    pub async fn daemon(&self) -> Result<Option<DaemonRow>> {
        let query = sqlx::query_as("SELECT pid, host, version, started_at, beat_at, status FROM daemon");
        let row: Option<DaemonRow> = query.fetch_optional(self.reader()?).await?;
        // A beat from the future is from before the clock was set back: the next one comes within seconds.
        let beats = |row: &DaemonRow| {
            self.now().duration_since(*row.beat_at).abs() < SignedDuration::from_secs(BEAT_LASTS_SECS)
        };
        let lives = |row: &DaemonRow| (beats(row) || self.is_locked()) && !row.is_known_to_be_gone();
        Ok(row.map(|row| DaemonRow { alive: lives(&row), ..row }))
    }

    /// Whether a daemon holds this ledger, also one that cannot write a sign of life (a full disk) or is only starting.
    pub async fn is_served(&self) -> Result<bool> {
        Ok(self.is_locked() || self.daemon().await?.is_some_and(|daemon| daemon.alive))
    }

    /// Whether a process holds the lock beside the ledger; `false` when that cannot be told.
    fn is_locked(&self) -> bool {
        let lock = File::open(self.folder().join(LOCK_NAME));
        lock.is_ok_and(|lock| flock(&lock, FlockOperation::NonBlockingLockShared) == Err(Errno::WOULDBLOCK))
    }

    fn folder(&self) -> &Path {
        super::place::folder(self.path())
    }
}

impl DaemonRow {
    /// Whether it runs, but has not been able to write a sign of life for a while: what it wrote before is as old.
    pub fn is_silent(&self, now: Timestamp) -> bool {
        self.alive && now.duration_since(*self.beat_at).abs() >= SignedDuration::from_secs(BEAT_LASTS_SECS)
    }

    /// Whether it ran on this server and its process is no more: killed, so that nobody need wait for its next beat.
    fn is_known_to_be_gone(&self) -> bool {
        let is_here = uname().nodename().to_string_lossy() == self.host;
        let pid = i32::try_from(self.pid).ok().and_then(Pid::from_raw);
        is_here && pid.is_some_and(|pid| test_kill_process(pid) == Err(Errno::SRCH))
    }
}
