//! Rights to serve a ledger on a server: rows that their owners renew, and whose epoch each of the owner's changes compares. The
//! database's clock decides when one ends.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use rustix::time::{ClockId, clock_gettime};
use sqlx::{PgConnection, PgExecutor, PgPool};
use tokio::{sync::Notify, task::AbortHandle};

use super::{
    change_lock::begin_locked,
    connections::ServerConnections,
    lease_watch::{LeaseRecord, LeaseWatch},
    repair_due,
    schema::SCHEMA,
};
use crate::{
    LedgerError, LiveRights, ServerError, ServiceState, ServingNode, ServingRight,
    base::{error::Result, sql::answered_within},
};

/// A renewal without an answer for this long is tried again.
const RENEWAL_TIMEOUT: Duration = Duration::from_secs(5);

/// A lease that this process holds. Clones are the same lease.
#[derive(Clone)]
pub struct HeldLease {
    shared: Arc<LeaseShared>,
    renewals: AbortHandle,
}

struct LeaseShared {
    connections: ServerConnections,
    node: ServingNode,
    watch: Mutex<LeaseWatch>,
    /// Why this process may not act until a renewal says otherwise, if so.
    trouble: Mutex<Option<ServiceState>>,
    /// Asks for a renewal at once.
    doubt: Notify,
}

/// Time since the boot of this machine, sleep included.
fn since_boot() -> Duration {
    let now = clock_gettime(ClockId::Boottime);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or_default())
}

impl HeldLease {
    /// Takes the lease, and renews it from now on. The change lock keeps changes of an earlier owner out meanwhile.
    ///
    /// `ServedByOther` if another process holds it, or one that it excludes, `Behind` if the node is due for repair.
    pub async fn acquire(connections: &ServerConnections, node: &ServingNode) -> Result<Self> {
        let sent_at = since_boot();
        let mut transaction = begin_locked(connections.pool()).await?;
        let granted = grant(&mut transaction, node).await?;
        transaction.commit().await.map_err(ServerError::mark_unreachable)?;
        let shared = Arc::new(LeaseShared {
            connections: connections.clone(),
            node: node.clone(),
            watch: Mutex::new(LeaseWatch::granted(granted, sent_at, usable(node.lease))),
            trouble: Mutex::default(),
            doubt: Notify::new(),
        });
        let renewals = tokio::spawn(keep_renewing(shared.clone())).abort_handle();
        Ok(Self { shared, renewals })
    }

    /// Whether this process may act on what the ledger says.
    pub fn state(&self) -> ServiceState {
        let watch = self.shared.watch();
        if watch.is_lost() {
            return if watch.is_behind() { ServiceState::Behind } else { ServiceState::TakenOver };
        }
        let trouble = self.shared.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match trouble {
            Some(trouble) => trouble,
            None if !watch.may_act(since_boot()) => {
                ServiceState::Unsure { why: "the right to serve it was not renewed in time".to_owned() }
            }
            None => ServiceState::Held,
        }
    }

    /// Tells that a statement has failed because the server could not be reached: until a renewal succeeds, the state is unsure.
    pub fn doubt(&self, why: &str) {
        self.shared.set_trouble(Some(ServiceState::Unsure { why: why.to_owned() }));
        self.shared.doubt.notify_one();
    }

    /// Counts a change. To be called in it, after the change lock was taken.
    ///
    /// `TakenOver` if another node has the lease, `Behind` if the database has lost earlier changes, `RepairDue` if it has lost those of
    /// other nodes.
    pub async fn count_change(&self, db: &mut PgConnection) -> Result<CountedChange> {
        let before = self.shared.watch();
        let count = sqlx::query_scalar(
            "UPDATE lease_change SET changes = changes + 1 FROM lease \
             WHERE lease_change.name = $1 AND lease.name = $1 AND lease.epoch = $2 RETURNING changes - 1",
        );
        let count = count.bind(self.shared.name()).bind(before.epoch()).fetch_optional(&mut *db).await;
        let found = match count.map_err(ServerError::mark_unreachable)? {
            Some(changes) => Some(LeaseRecord { epoch: before.epoch(), changes }),
            None => self.shared.read_record(&mut *db).await?,
        };
        match (self.shared.compare(found, before.committed()), found) {
            (true, Some(found)) => {
                self.shared.ensure_no_repair_due(db).await?;
                Ok(CountedChange { lease: self.clone(), number: found.changes + 1 })
            }
            _ if self.shared.watch().is_behind() => {
                self.shared.doubt.notify_one();
                Err(ServerError::Behind.into())
            }
            _ => Err(ServerError::TakenOver.into()),
        }
    }

    /// Gives the lease back.
    pub async fn release(&self) {
        self.renewals.abort();
        if let (true, ServingRight::Node(node)) = (self.shared.watch().is_behind(), &self.shared.node.right)
            && let Err(error) = self.shared.mark_repair_due(node, false).await
        {
            tracing::warn!("The other nodes could not be told that the ledger has lost changes: {error}.");
        }
        let end = sqlx::query("UPDATE lease SET until = clock_timestamp() WHERE name = $1 AND epoch = $2");
        let end =
            end.bind(self.shared.name()).bind(self.shared.watch().epoch()).execute(self.shared.connections.pool());
        let ended = answered_within(RENEWAL_TIMEOUT, end).await;
        if let Err(error) = ended {
            tracing::warn!("The right to serve the ledger could not be given back, and lapses: {error}.");
        }
    }
}

/// A change that the database counts as one of this process.
pub struct CountedChange {
    lease: HeldLease,
    number: i64,
}

impl CountedChange {
    /// Tells that the change was committed: a database that does not have it is an older one.
    pub fn confirm(self) {
        self.lease.shared.change_watch(|watch| watch.confirm_change(self.number));
    }
}

impl LeaseShared {
    /// Name of the lease.
    fn name(&self) -> String {
        self.node.right.to_string()
    }

    fn watch(&self) -> LeaseWatch {
        *self.watch.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change_watch<T>(&self, change: impl FnOnce(&mut LeaseWatch) -> T) -> T {
        change(&mut self.watch.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn compare(&self, found: Option<LeaseRecord>, committed: i64) -> bool {
        self.change_watch(|watch| watch.compare(found, committed))
    }

    fn set_trouble(&self, trouble: Option<ServiceState>) {
        *self.trouble.lock().unwrap_or_else(PoisonError::into_inner) = trouble;
    }

    /// Fails if the database has lost changes of another node. The node that is repaired, and whoever has the whole ledger, go on.
    async fn ensure_no_repair_due(&self, db: &mut PgConnection) -> Result<()> {
        let due = match &self.node.right {
            ServingRight::Node(_) => repair_due::find_due(db).await?,
            ServingRight::RepairedNode(_) | ServingRight::WholeLedger => Vec::new(),
        };
        match due.is_empty() {
            true => Ok(()),
            false => {
                let nodes = due.join(", ");
                self.set_trouble(Some(ServiceState::RepairDue { nodes: nodes.clone() }));
                Err(ServerError::RepairDue { nodes }.into())
            }
        }
    }

    async fn read_record(&self, db: impl PgExecutor<'_>) -> Result<Option<LeaseRecord>> {
        let record = sqlx::query_as(
            "SELECT epoch, coalesce((SELECT changes FROM lease_change WHERE name = $1), -1) FROM lease WHERE name = $1",
        );
        let record: Option<(i64, i64)> =
            record.bind(self.name()).fetch_optional(db).await.map_err(ServerError::mark_unreachable)?;
        Ok(record.map(|(epoch, changes)| LeaseRecord { epoch, changes }))
    }

    /// Tells the other nodes that the ledger has lost changes of this one, or of all.
    async fn mark_repair_due(&self, node: &str, with_others: bool) -> Result<()> {
        answered_within(RENEWAL_TIMEOUT, repair_due::mark(self.connections.pool(), node, with_others)).await
    }

    /// Renews the lease. Returns whether it is still the own one.
    async fn renew(&self) -> Result<bool> {
        let (sent_at, before) = (since_boot(), self.watch());
        let renewal = async {
            let renewal = sqlx::query(
                "UPDATE lease SET until = clock_timestamp() + $2 * interval '1 millisecond' WHERE epoch = $1 AND name = $3",
            );
            let renewal = renewal.bind(before.epoch()).bind(millis(self.node.lease)).bind(self.name());
            let mut db = self.connections.acquire().await?;
            renewal.execute(&mut *db).await.map_err(ServerError::mark_unreachable)?;
            let found = self.read_record(&mut *db).await?;
            Ok::<_, LedgerError>((found, self.ensure_no_repair_due(&mut db).await))
        };
        let (found, no_repair_due) = answered_within(RENEWAL_TIMEOUT, renewal).await?;
        if !self.compare(found, before.committed()) {
            return Ok(false);
        }
        self.change_watch(|watch| watch.renew(sent_at, usable(self.node.lease)));
        if let (Err(_), ServingRight::Node(node)) = (&no_repair_due, &self.node.right) {
            // It runs, and knows that nothing of its own is lost.
            answered_within(RENEWAL_TIMEOUT, repair_due::record_repair(self.connections.pool(), node)).await?;
        }
        no_repair_due.map(|()| true)
    }
}

/// Renews the lease three times while it lasts, and more often while that fails.
async fn keep_renewing(shared: Arc<LeaseShared>) {
    let (regular, hasty) = (shared.node.lease / 3, shared.node.lease / 30);
    let mut pause = regular;
    loop {
        tokio::select! {
            () = tokio::time::sleep(pause) => {}
            () = shared.doubt.notified() => {}
        }
        let trouble = match shared.renew().await {
            Ok(true) => None,
            Ok(false) => break,
            Err(LedgerError::Server(ServerError::RepairDue { nodes })) => Some(ServiceState::RepairDue { nodes }),
            Err(error) => Some(ServiceState::Unsure { why: error.to_string() }),
        };
        pause = if trouble.is_none() { regular } else { hasty };
        shared.set_trouble(trouble);
    }
    if let (true, ServingRight::Node(node)) = (shared.watch().is_behind(), &shared.node.right) {
        // Until a person ends this process: the next standby may not have the mark.
        let mut is_first = true;
        loop {
            let marked = shared.mark_repair_due(node, is_first).await;
            is_first &= marked.is_err();
            if let Err(error) = &marked {
                tracing::warn!("The other nodes could not be told that the ledger has lost changes: {error}.");
            }
            tokio::time::sleep(if is_first { hasty } else { regular }).await;
        }
    }
}

/// For how much of a lease its owner acts: it stops well before the lease can lapse.
fn usable(lease: Duration) -> Duration {
    lease * 5 / 6
}

fn millis(lease: Duration) -> i64 {
    i64::try_from(lease.as_millis()).unwrap_or(i64::MAX)
}

/// Grants the lease where it is free, has lapsed, or was the process's own.
///
/// `Behind` if the node is due for repair. `ServedByOther` if another process holds it, or one that it excludes: whoever has the whole ledger has it alone.
async fn grant(db: &mut PgConnection, node: &ServingNode) -> Result<LeaseRecord> {
    if let ServingRight::Node(node) = &node.right
        && repair_due::find_due(db).await?.contains(node)
    {
        return Err(ServerError::Behind.into());
    }
    let (name, is_whole) = (node.right.to_string(), node.right == ServingRight::WholeLedger);
    let other = sqlx::query_as(
        "SELECT owner, CAST(ceil(extract(epoch FROM until - clock_timestamp())) AS BIGINT) FROM lease \
         WHERE until > clock_timestamp() AND owner <> $1 AND left(name, 5) <> 'duty ' AND ($3 OR name IN ($2, 'ledger')) \
         ORDER BY until DESC LIMIT 1",
    );
    let other = other.bind(&node.owner).bind(&name).bind(is_whole).fetch_optional(&mut *db).await?;
    if let Some((owner, secs)) = other {
        return Err(ServerError::ServedByOther { owner, secs }.into());
    }
    let grant = sqlx::query_scalar(
        "INSERT INTO lease (name, owner, epoch, until, newest_schema) \
         VALUES ($1, $2, 1, clock_timestamp() + $3 * interval '1 millisecond', $4) \
         ON CONFLICT (name) DO UPDATE SET owner = excluded.owner, epoch = lease.epoch + 1, until = excluded.until, \
         newest_schema = excluded.newest_schema RETURNING epoch",
    );
    let grant = grant.bind(&name).bind(&node.owner).bind(millis(node.lease)).bind(SCHEMA.newest());
    let epoch = grant.fetch_one(&mut *db).await?;
    if is_whole {
        // A node that slept meanwhile is fenced off.
        sqlx::query("UPDATE lease SET epoch = epoch + 1 WHERE left(name, 5) = 'node '").execute(&mut *db).await?;
    }
    let changes = sqlx::query_scalar(
        "INSERT INTO lease_change (name, changes) VALUES ($1, 0) \
         ON CONFLICT (name) DO UPDATE SET changes = lease_change.changes RETURNING changes",
    );
    Ok(LeaseRecord { epoch, changes: changes.bind(&name).fetch_one(db).await? })
}

/// Takes the lease of a node away, unless it is held now: who had it changes nothing more, even if it wakes up again. Returns its owner
/// if it is held.
pub async fn revoke_lapsed(db: &mut PgConnection, node: &str) -> Result<Option<String>> {
    let name = ServingRight::Node(node.to_owned()).to_string();
    let held = sqlx::query_scalar("SELECT owner FROM lease WHERE name = $1 AND until > clock_timestamp()");
    let held: Option<String> = held.bind(&name).fetch_optional(&mut *db).await?;
    if held.is_none() {
        sqlx::query("UPDATE lease SET epoch = epoch + 1 WHERE name = $1").bind(&name).execute(db).await?;
    }
    Ok(held)
}

/// Names of the nodes whose leases are held now, and whether a process has the whole ledger.
pub async fn live_rights(pool: &PgPool) -> Result<LiveRights> {
    let names = sqlx::query_scalar("SELECT name FROM lease WHERE until > clock_timestamp() ORDER BY name");
    let names: Vec<String> = names.fetch_all(pool).await.map_err(ServerError::mark_unreachable)?;
    Ok(LiveRights {
        nodes: names.iter().filter_map(|name| name.strip_prefix("node ")).map(str::to_owned).collect(),
        is_whole: names.iter().any(|name| *name == ServingRight::WholeLedger.to_string()),
    })
}

/// Takes a duty that one node does for all, or keeps it for as long again. `false` = another one has it.
pub async fn hold_duty(pool: &PgPool, duty: &str, owner: &str, lease: Duration) -> Result<bool> {
    let hold = sqlx::query(
        "INSERT INTO lease (name, owner, epoch, until) \
         VALUES ('duty ' || $1, $2, 1, clock_timestamp() + $3 * interval '1 millisecond') \
         ON CONFLICT (name) DO UPDATE SET owner = excluded.owner, epoch = lease.epoch + 1, until = excluded.until \
         WHERE lease.until <= clock_timestamp() OR lease.owner = excluded.owner",
    );
    let held = hold.bind(duty).bind(owner).bind(millis(lease)).execute(pool).await;
    Ok(held.map_err(ServerError::mark_unreachable)?.rows_affected() > 0)
}
