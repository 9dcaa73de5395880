//! The nodes of a farm, which are daemons, and their heartbeats. A ledger in a file has one node, one on a server may have several. The
//! heartbeat tells user interfaces whether a daemon runs.

use jiff::{SignedDuration, Timestamp};
use language::say;
use rustix::{
    fs::{FlockOperation, flock},
    io::Errno,
    process::{Pid, test_kill_process},
    system::uname,
};
use schemars::JsonSchema;
use serde::Serialize;

use std::fs::File;

use super::machine;
use crate::{
    Ledger, LiveRights, ObservedMachine, UtcTimestamp,
    base::{
        error::Result,
        lock_wait::{TOLD_AFTER, find_holder},
        sql::{self, FromSqlRow, SqlRow},
    },
    store::change::LedgerChange,
};

/// Time for which a heartbeat is valid, seconds. The daemon sends one every few seconds.
pub const HEARTBEAT_VALID_SECS: i64 = 15;

/// A node without machines is forgotten this long after its last heartbeat, hours.
const FORGET_NODE_HOURS: i64 = 30 * 24;

/// The file beside the ledger that a running daemon holds locked. It shows that the daemon is alive even if the disk is
/// full.
pub const LOCK_NAME: &str = "nestd.lock";

/// A heartbeat.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeHeartbeat {
    /// Name of the node.
    pub name: String,
    /// Where other nodes reach its pages; "" = they cannot.
    pub address: String,
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
    /// What it asks people to see to, as JSON.
    pub alerts: String,
    /// The machines that the daemon serves.
    pub machines: Vec<ObservedMachine>,
    /// The machines that it has files of. One that was given to it stays its own until it has taken it.
    pub configured: Vec<String>,
}

/// A node that serves this ledger, or that ended without an orderly shutdown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct NodeRow {
    /// Its name.
    pub name: String,
    /// Where other nodes reach its pages; "" = they cannot.
    pub address: String,
    /// Process; 0 = it was stopped.
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
    /// What it asked people to see to, as JSON.
    #[serde(skip)]
    pub alerts: String,
    /// Whether its daemon runs: its last heartbeat is younger than [`HEARTBEAT_VALID_SECS`], or its lock or lease is held. If the
    /// daemon ran on this server, its process must exist too.
    pub alive: bool,
}

impl FromSqlRow for NodeRow {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        Ok(Self {
            name: row.column("name")?,
            address: row.column("address")?,
            pid: row.column("pid")?,
            host: row.column("host")?,
            version: row.column("version")?,
            started_at: row.column("started_at")?,
            beat_at: row.column("beat_at")?,
            status: row.column("status")?,
            alerts: row.column("alerts")?,
            alive: false,
        })
    }
}

impl Ledger {
    /// Makes a node known that is just starting. What the heartbeat says of machines is not recorded. Nodes that lost their machines to
    /// others and have given no sign for long are forgotten.
    pub async fn announce_node(&self, heartbeat: &NodeHeartbeat) -> Result<()> {
        if self.file().is_some() {
            // Its first heartbeat will do; a full disk does not keep it from starting.
            return Ok(());
        }
        let mut change = self.begin_change().await?;
        let long_ago = change.now.0.saturating_sub(SignedDuration::from_hours(FORGET_NODE_HOURS)).unwrap_or_default();
        let forget = sql::query(
            "DELETE FROM node WHERE beat_at < $1 AND NOT EXISTS (SELECT 1 FROM station WHERE station.node = node.name)",
        );
        forget.bind(UtcTimestamp(long_ago)).execute(change.db()).await?;
        self.record_node(&mut change, heartbeat).await?;
        change.commit().await
    }

    /// Writes a heartbeat.
    pub async fn write_heartbeat(&self, heartbeat: &NodeHeartbeat) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        self.record_node(&mut change, heartbeat).await?;
        let machines = (&heartbeat.machines[..], &heartbeat.configured[..]);
        machine::record_machines(&mut change, &heartbeat.name, machines).await?;
        change.commit().await
    }

    async fn record_node(&self, change: &mut LedgerChange, heartbeat: &NodeHeartbeat) -> Result<()> {
        let now = change.now;
        if self.file().is_some() {
            // A server that was renamed is the same node.
            sql::query("DELETE FROM node WHERE name <> $1").bind(&heartbeat.name).execute(change.db()).await?;
            let all = sql::query("UPDATE station SET node = $1 WHERE node <> $1").bind(&heartbeat.name);
            all.execute(change.db()).await?;
        }
        sql::query(
            "INSERT INTO node (name, pid, host, version, started_at, beat_at, status, address, alerts) \
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9) ON CONFLICT (name) DO UPDATE SET pid = excluded.pid, \
             host = excluded.host, version = excluded.version, started_at = excluded.started_at, \
             beat_at = excluded.beat_at, status = excluded.status, address = excluded.address, \
             alerts = excluded.alerts",
        )
        .bind(&heartbeat.name)
        .bind(heartbeat.pid)
        .bind(&heartbeat.host)
        .bind(&heartbeat.version)
        .bind(UtcTimestamp(heartbeat.started_at))
        .bind(now)
        .bind(&heartbeat.status)
        .bind(&heartbeat.address)
        .bind(&heartbeat.alerts)
        .execute(change.db())
        .await?;
        Ok(())
    }

    /// Records an orderly shutdown of a node. Where several nodes share the ledger, it stays known with its machines.
    pub async fn record_shutdown(&self, node: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let stopped = match self.file().is_some() {
            true => sql::query("DELETE FROM node WHERE name = $1"),
            false => sql::query("UPDATE node SET pid = 0, status = 'stopped' WHERE name = $1"),
        };
        stopped.bind(node).execute(change.db()).await?;
        change.commit().await
    }

    /// The nodes of this farm, by name: of a file the one that serves it, or that ended without an orderly shutdown.
    pub async fn list_nodes(&self) -> Result<Vec<NodeRow>> {
        let query = sql::query_as(
            "SELECT name, pid, host, version, started_at, beat_at, status, address, alerts FROM node ORDER BY name",
        );
        let mut rows: Vec<NodeRow> = query.fetch_all(self.reader()?).await?;
        // A heartbeat in the future was written before the clock was set back. The next one follows within seconds.
        let beats = |row: &NodeRow| {
            self.now().duration_since(*row.beat_at).abs() < SignedDuration::from_secs(HEARTBEAT_VALID_SECS)
        };
        let rights = match rows.iter().all(beats) {
            true => LiveRights::default(),
            false => self.live_rights().await?,
        };
        for row in &mut rows {
            row.alive = row.pid != 0 && (beats(row) || rights.nodes.contains(&row.name)) && !row.is_process_gone();
        }
        Ok(rows)
    }

    /// The node of this name, or the one node of a file.
    pub async fn find_node(&self, name: &str) -> Result<Option<NodeRow>> {
        let is_file = self.file().is_some();
        Ok(self.list_nodes().await?.into_iter().find(|row| is_file || row.name == name))
    }

    /// The secret of this name that all nodes have in common, so that what one signs, all know; `proposed` = the one that it is from now
    /// on, if there is none. No view shows it.
    pub async fn farm_secret(&self, name: &str, proposed: &str) -> Result<String> {
        let find = || sql::query_scalar("SELECT secret FROM farm_secret WHERE name = $1").bind(name);
        if let Some(known) = find().fetch_optional(self.reader()?).await? {
            return Ok(known);
        }
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        let propose = "INSERT INTO farm_secret (name, secret) VALUES ($1, $2) ON CONFLICT (name) DO NOTHING";
        sql::query(propose).bind(name).bind(proposed).execute(change.db()).await?;
        let chosen = find().fetch_one(change.db()).await?;
        change.commit().await?;
        Ok(chosen)
    }

    /// What helps where a daemon runs and does not write into the ledger, as far as that can be told from here.
    pub async fn silence_hint(&self) -> Result<String> {
        if let Some(by) = self.locked_by().await? {
            return Ok(say!("silent-locked", by = by));
        }
        Ok(match self.file() {
            Some(_) => say!("silent-disk"),
            None => say!("silent-database"),
        })
    }

    /// The process, other than a daemon, that keeps a ledger in a file from being changed for longer than a change takes; `None` = none, as
    /// far as that can be told from here.
    pub async fn locked_by(&self) -> Result<Option<String>> {
        let Some(file) = self.file() else { return Ok(None) };
        let daemons: Vec<u32> = self.list_nodes().await?.into_iter().map(|node| node.pid).collect();
        // The kernel's list is read in pieces while others change it: a lock that is held may be missing once.
        let find = || find_holder(file).or_else(|| find_holder(file));
        let Some(first) = find().filter(|holder| !daemons.contains(&holder.pid)) else { return Ok(None) };
        tokio::time::sleep(TOLD_AFTER).await;
        Ok(find().filter(|now| *now == first).map(|holder| holder.to_string()))
    }

    /// Whether a daemon serves this ledger, including one that cannot write a heartbeat (a full disk) or is just
    /// starting.
    pub async fn is_served(&self) -> Result<bool> {
        let rights = self.live_rights().await?;
        Ok(rights.is_whole || !rights.nodes.is_empty() || self.list_nodes().await?.iter().any(|node| node.alive))
    }

    /// Whether this daemon serves this ledger: of a file the one that there is, on a server the node of this name.
    pub async fn is_served_by(&self, node: &str) -> Result<bool> {
        let rights = self.live_rights().await?;
        let is_its = |name: &str| self.file().is_some() || name == node;
        let nodes = self.list_nodes().await?;
        Ok(rights.is_whole
            || rights.nodes.iter().any(|name| is_its(name))
            || nodes.iter().any(|row| row.alive && is_its(&row.name)))
    }

    /// Whether a node carries out what concerns no machine that a node serves: one of them does, the first by name.
    pub async fn is_first_node(&self, node: &str) -> Result<bool> {
        Ok(self.file().is_some() || self.live_rights().await?.nodes.first().is_some_and(|first| first == node))
    }

    /// Who serves this ledger now, by the leases of a server, or the lock file beside a file.
    async fn live_rights(&self) -> Result<LiveRights> {
        if let Some(rights) = self.leased_rights().await? {
            return Ok(rights);
        }
        if !self.is_locked() {
            return Ok(LiveRights::default());
        }
        let node = sql::query_scalar("SELECT name FROM node").fetch_optional(self.reader()?).await?;
        Ok(LiveRights { nodes: node.into_iter().collect(), is_whole: true })
    }

    /// Whether a process holds the lock file beside the ledger. `false` if this cannot be determined.
    fn is_locked(&self) -> bool {
        let Some(file) = self.file() else { return false };
        let lock = File::open(crate::store::location::parent_folder(file).join(LOCK_NAME));
        lock.is_ok_and(|lock| flock(&lock, FlockOperation::NonBlockingLockShared) == Err(Errno::WOULDBLOCK))
    }
}

impl NodeRow {
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
