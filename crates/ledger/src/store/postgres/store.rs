//! A ledger in a PostgreSQL database.

use std::time::Duration;

use sqlx::{
    ConnectOptions, Connection, PgPool,
    postgres::{PgConnectOptions, PgPoolOptions},
};

use super::{
    change_lock::begin_locked,
    lease::{self, CountedChange, HeldLease},
    repair_due,
    schema::SCHEMA,
    shared_farm,
    time_limits::{self, ConnectionUser},
};
use crate::{
    LedgerError, LiveRights, ServerError, ServiceState, ServingNode, ServingRight, SharedFarm,
    base::{
        error::Result,
        sql::{SqlExecutor, SqlTransaction, answered_within},
    },
};

/// Number of connections of a process.
const CONNECTIONS: u32 = 8;
/// How long a statement waits for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// An open database. A clone is cheap and refers to the same connections.
#[derive(Clone)]
pub struct PostgresStore {
    pool: PgPool,
    /// Within what time a statement is answered.
    answered_within: Duration,
    /// The address, without its password.
    label: String,
    /// The right to serve the ledger, which a daemon has.
    lease: Option<HeldLease>,
}

impl PostgresStore {
    /// Opens the database and migrates its schema.
    pub async fn open(options: PgConnectOptions, label: &str) -> Result<Self> {
        let store = Self::connect(options, label, ConnectionUser::Command).await?;
        SCHEMA.bring_up_to_date(&store.pool, label, "").await?;
        Ok(store)
    }

    /// Opens the database as [`PostgresStore::open`] does, for a process that serves it.
    ///
    /// `OlderNodes` if nodes run that could not use the migrated ledger, `ServedByOther` if another one has the same right, or one that excludes it.
    pub async fn open_to_serve(options: PgConnectOptions, label: &str, node: &ServingNode) -> Result<Self> {
        let user = match &node.right {
            ServingRight::Node(name) => ConnectionUser::Node(name),
            ServingRight::RepairedNode(_) | ServingRight::WholeLedger => ConnectionUser::Command,
        };
        let store = Self::connect(options, label, user).await?;
        SCHEMA.bring_up_to_date(&store.pool, label, &node.owner).await?;
        let lease = store.within(HeldLease::acquire(&store.pool, node)).await?;
        // A newer nestd may have changed the schema meanwhile. From now on it sees what this one knows.
        if let Err(error) = SCHEMA.ensure_usable(&store.pool, label).await {
            lease.release().await;
            return Err(error);
        }
        Ok(Self { lease: Some(lease), ..store })
    }

    /// Opens a database that holds a ledger which this binary can use.
    ///
    /// `Missing` if it holds none, `OlderSchema` or `NewerSchema`.
    pub async fn open_existing(options: PgConnectOptions, label: &str) -> Result<Self> {
        let store = Self::connect(options, label, ConnectionUser::Command).await?;
        match SCHEMA.ensure_usable(&store.pool, label).await {
            Ok(()) => Ok(store),
            Err(LedgerError::OlderSchema { found: 0, .. }) => {
                store.close().await;
                Err(LedgerError::Missing { path: label.into() })
            }
            Err(error) => Err(error),
        }
    }

    async fn connect(options: PgConnectOptions, label: &str, user: ConnectionUser<'_>) -> Result<Self> {
        let pool = PgPoolOptions::new().max_connections(CONNECTIONS).acquire_timeout(CONNECT_TIMEOUT);
        // One that gives no sign of life gives its place to a new one, and is not waited for.
        let pool = pool.after_release(|db, _| {
            Box::pin(async { Ok(matches!(tokio::time::timeout(CONNECT_TIMEOUT, db.ping()).await, Ok(Ok(())))) })
        });
        // A slow server would bring whole migrations into the journal.
        let pool = pool.connect_with(time_limits::limit(options, user).disable_statement_logging()).await;
        let (pool, label) = (pool.map_err(ServerError::mark_unreachable)?, label.to_owned());
        Ok(Self { pool, answered_within: user.answered_within(), label, lease: None })
    }

    /// Waits for what the server is asked.
    async fn within<T>(&self, work: impl Future<Output = Result<T>>) -> Result<T> {
        answered_within(self.answered_within, work).await
    }

    /// Fails unless the schema is exactly that of this binary.
    pub async fn ensure_own_schema(&self) -> Result<()> {
        self.within(SCHEMA.ensure_own(&self.pool, &self.label)).await
    }

    /// Gives the right to serve the ledger back, and closes all connections.
    pub async fn close(&self) {
        if let Some(lease) = &self.lease
            && !self.pool.is_closed()
        {
            lease.release().await;
        }
        self.pool.close().await;
    }

    /// Whether this process may act on what the ledger says. One that is not the daemon always may.
    pub fn service_state(&self) -> ServiceState {
        self.lease.as_ref().map_or(ServiceState::Held, HeldLease::state)
    }

    /// Tells that the server could not be reached.
    pub fn doubt(&self, why: &str) {
        if let Some(lease) = &self.lease {
            lease.doubt(why);
        }
    }

    /// The folders of a node were compared with the ledger.
    pub async fn record_repair(&self, node: &str) -> Result<()> {
        self.within(repair_due::record_repair(&self.pool, node)).await
    }

    /// The ledger has lost changes, or is about to: all nodes with machines are due for repair.
    pub async fn mark_repair_due(&self, node: &str) -> Result<()> {
        self.within(repair_due::mark(&self.pool, node, true)).await
    }

    /// The nodes that are due for repair.
    pub async fn find_repair_due(&self) -> Result<Vec<String>> {
        let mut db = self.pool.acquire().await.map_err(ServerError::mark_unreachable)?;
        self.within(repair_due::find_due(&mut db)).await
    }

    /// The farm of the ledger.
    pub async fn shared_farm(&self) -> Result<SharedFarm> {
        self.within(shared_farm::find(&self.pool)).await
    }

    /// Who serves the ledger now.
    pub async fn live_rights(&self) -> Result<LiveRights> {
        self.within(lease::live_rights(&self.pool)).await
    }

    /// Takes a duty that one node does for all, or keeps it for as long again. `false` = another one has it.
    pub async fn hold_duty(&self, duty: &str, owner: &str, lease: Duration) -> Result<bool> {
        self.within(lease::hold_duty(&self.pool, duty, owner, lease)).await
    }

    /// The connections for single statements that read.
    pub fn reader(&self) -> SqlExecutor<'_> {
        SqlExecutor::PostgresPool(&self.pool, self.answered_within)
    }

    /// Begins a consistent read of several tables.
    pub async fn begin_snapshot(&self) -> Result<SqlTransaction> {
        let limit = self.answered_within;
        let begin = self.pool.begin_with("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
        let begun = answered_within(limit, begin).await.map_err(ServerError::mark_unreachable)?;
        Ok(SqlTransaction::Postgres(begun, limit))
    }

    /// Begins a change, after all changes that have begun before.
    ///
    /// `TakenOver` if this is a daemon that does not serve the ledger any more, `Behind` if the database has lost changes of it,
    /// `RepairDue` if it has lost changes of others.
    pub async fn begin_change(&self) -> Result<(SqlTransaction, Option<CountedChange>)> {
        let begin = async {
            let mut transaction = begin_locked(&self.pool).await?;
            let counted = match &self.lease {
                Some(lease) => Some(lease.count_change(&mut transaction).await?),
                None => None,
            };
            Ok((SqlTransaction::Postgres(transaction, self.answered_within), counted))
        };
        self.within(begin).await
    }
}
