//! Rights to serve a ledger on a server: rows that their owners renew, and whose epoch each of the owner's changes compares. The
//! database's clock decides when one ends.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use rustix::time::{ClockId, clock_gettime};
use sqlx::{PgConnection, PgPool};
use tokio::{sync::Notify, task::AbortHandle};

use super::{change_lock::begin_locked, lease_watch::LeaseWatch};
use crate::ledger::{LedgerError, LiveRights, ServerError, ServiceState, ServingNode, ServingRight, error::Result};

/// A renewal without an answer for this long is tried again.
const RENEWAL_TIMEOUT: Duration = Duration::from_secs(5);

/// A lease that this process holds. Clones are the same lease.
#[derive(Clone)]
pub struct HeldLease {
    shared: Arc<LeaseShared>,
    renewals: AbortHandle,
}

struct LeaseShared {
    pool: PgPool,
    node: ServingNode,
    watch: Mutex<LeaseWatch>,
    /// Why the last renewal failed, if it did.
    trouble: Mutex<Option<String>>,
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
    /// `ServedByOther` if another process holds it, or one that it excludes.
    pub async fn acquire(pool: &PgPool, node: &ServingNode) -> Result<Self> {
        let sent_at = since_boot();
        let mut transaction = begin_locked(pool).await?;
        let epoch = grant(&mut transaction, node).await?;
        transaction.commit().await.map_err(ServerError::mark_unreachable)?;
        let shared = Arc::new(LeaseShared {
            pool: pool.clone(),
            node: node.clone(),
            watch: Mutex::new(LeaseWatch::granted(epoch, sent_at, usable(node.lease))),
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
            return ServiceState::TakenOver;
        }
        let trouble = self.shared.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match trouble {
            Some(why) => ServiceState::Unsure { why },
            None if !watch.may_act(since_boot()) => {
                ServiceState::Unsure { why: "the right to serve it was not renewed in time".to_owned() }
            }
            None => ServiceState::Held,
        }
    }

    /// Tells that a statement has failed because the server could not be reached: until a renewal succeeds, the state is unsure.
    pub fn doubt(&self, why: &str) {
        *self.shared.trouble.lock().unwrap_or_else(PoisonError::into_inner) = Some(why.to_owned());
        self.shared.doubt.notify_one();
    }

    /// Fails if another node has the lease. To be called in a change, after the change lock was taken.
    pub async fn fence(&self, db: &mut PgConnection) -> Result<()> {
        let is_ours = sqlx::query("SELECT 1 FROM lease WHERE name = $1 AND epoch = $2");
        let is_ours = is_ours.bind(self.shared.name()).bind(self.shared.watch().epoch()).fetch_optional(db).await;
        match is_ours.map_err(ServerError::mark_unreachable)? {
            Some(_) => Ok(()),
            None => {
                self.shared.lose();
                Err(ServerError::TakenOver.into())
            }
        }
    }

    /// Gives the lease back.
    pub async fn release(&self) {
        self.renewals.abort();
        let end = sqlx::query("UPDATE lease SET until = clock_timestamp() WHERE name = $1 AND epoch = $2");
        let ended = end.bind(self.shared.name()).bind(self.shared.watch().epoch()).execute(&self.shared.pool).await;
        if let Err(error) = ended {
            tracing::warn!("The right to serve the ledger could not be given back, and lapses: {error}.");
        }
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

    fn lose(&self) {
        self.watch.lock().unwrap_or_else(PoisonError::into_inner).lose();
    }

    async fn renew(&self) -> Result<bool, sqlx::Error> {
        let sent_at = since_boot();
        let renewal = sqlx::query(
            "UPDATE lease SET until = clock_timestamp() + $2 * interval '1 millisecond' WHERE epoch = $1 AND name = $3",
        );
        let renewal = renewal.bind(self.watch().epoch()).bind(millis(self.node.lease)).bind(self.name());
        let renewal = renewal.execute(&self.pool);
        let renewed = tokio::time::timeout(RENEWAL_TIMEOUT, renewal).await.unwrap_or(Err(sqlx::Error::PoolTimedOut));
        let is_ours = renewed?.rows_affected() > 0;
        let mut watch = self.watch.lock().unwrap_or_else(PoisonError::into_inner);
        match is_ours {
            true => watch.renew(sent_at, usable(self.node.lease)),
            false => watch.lose(),
        }
        Ok(is_ours)
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
            Ok(false) => return,
            Err(error) => Some(LedgerError::from(ServerError::mark_unreachable(error)).to_string()),
        };
        pause = if trouble.is_none() { regular } else { hasty };
        *shared.trouble.lock().unwrap_or_else(PoisonError::into_inner) = trouble;
    }
}

/// For how much of a lease its owner acts: it stops well before the lease can lapse.
fn usable(lease: Duration) -> Duration {
    lease * 5 / 6
}

fn millis(lease: Duration) -> i64 {
    i64::try_from(lease.as_millis()).unwrap_or(i64::MAX)
}

/// Grants the lease where it is free, has lapsed, or was the process's own. Returns its epoch.
///
/// `ServedByOther` if another process holds it, or one that it excludes: whoever has the whole ledger has it alone.
async fn grant(db: &mut PgConnection, node: &ServingNode) -> Result<i64> {
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
        "INSERT INTO lease (name, owner, epoch, until) \
         VALUES ($1, $2, 1, clock_timestamp() + $3 * interval '1 millisecond') \
         ON CONFLICT (name) DO UPDATE SET owner = excluded.owner, epoch = lease.epoch + 1, until = excluded.until \
         RETURNING epoch",
    );
    Ok(grant.bind(&name).bind(&node.owner).bind(millis(node.lease)).fetch_one(db).await?)
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
