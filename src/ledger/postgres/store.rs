//! A ledger in a PostgreSQL database.

use std::time::Duration;

use sqlx::{
    ConnectOptions, PgPool, Postgres, Transaction,
    postgres::{PgConnectOptions, PgPoolOptions},
};

use super::{
    change_lock::begin_locked,
    lease::{self, HeldLease},
    schema,
};
use crate::ledger::{
    LedgerError, LiveRights, ServerError, ServiceState, ServingNode, ServingRight, error::Result, sql::SqlExecutor,
};

/// Number of connections of a process.
const CONNECTIONS: u32 = 8;
/// How long a statement waits for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// An open database. A clone is cheap and refers to the same connections.
#[derive(Clone)]
pub struct PostgresStore {
    pool: PgPool,
    /// The right to serve the ledger, which a daemon has.
    lease: Option<HeldLease>,
}

impl PostgresStore {
    /// Opens the database and migrates its schema.
    pub async fn open(options: PgConnectOptions, label: &str) -> Result<Self> {
        let store = Self::connect(options).await?;
        schema::bring_up_to_date(&store.pool, label).await?;
        Ok(store)
    }

    /// Opens the database as [`PostgresStore::open`] does, for a process that serves it.
    ///
    /// `ServedByOther` if another one has the same right, or one that excludes it.
    pub async fn open_to_serve(options: PgConnectOptions, label: &str, node: &ServingNode) -> Result<Self> {
        let store = Self::connect(options).await?;
        // The schema does not change under another node.
        if schema::ensure_current_version(&store.pool, label).await.is_err() {
            let alone = ServingNode { right: ServingRight::WholeLedger, ..node.clone() };
            let alone = match schema::has_table(&store.pool, "lease").await? {
                true => Some(HeldLease::acquire(&store.pool, &alone).await?),
                false => None,
            };
            schema::bring_up_to_date(&store.pool, label).await?;
            if let Some(alone) = alone {
                alone.release().await;
            }
        }
        let lease = Some(HeldLease::acquire(&store.pool, node).await?);
        Ok(Self { lease, ..store })
    }

    /// Opens a database that holds a ledger with the current schema.
    ///
    /// `Missing` if it holds none, `OlderSchema` or `NewerSchema`.
    pub async fn open_existing(options: PgConnectOptions, label: &str) -> Result<Self> {
        let store = Self::connect(options).await?;
        if !schema::has_table(&store.pool, "_sqlx_migrations").await? {
            store.close().await;
            return Err(LedgerError::Missing { path: label.into() });
        }
        schema::ensure_current_version(&store.pool, label).await?;
        Ok(store)
    }

    async fn connect(options: PgConnectOptions) -> Result<Self> {
        let pool = PgPoolOptions::new().max_connections(CONNECTIONS).acquire_timeout(CONNECT_TIMEOUT);
        // A slow server would bring whole migrations into the journal.
        let pool = pool.connect_with(options.application_name("nestd").disable_statement_logging()).await;
        Ok(Self { pool: pool.map_err(ServerError::mark_unreachable)?, lease: None })
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

    /// Who serves the ledger now.
    pub async fn live_rights(&self) -> Result<LiveRights> {
        lease::live_rights(&self.pool).await
    }

    /// Takes a duty that one node does for all, or keeps it for as long again. `false` = another one has it.
    pub async fn hold_duty(&self, duty: &str, owner: &str, lease: Duration) -> Result<bool> {
        lease::hold_duty(&self.pool, duty, owner, lease).await
    }

    /// The connections for single statements that read.
    pub fn reader(&self) -> SqlExecutor<'_> {
        SqlExecutor::PostgresPool(&self.pool)
    }

    /// Begins a consistent read of several tables.
    pub async fn begin_snapshot(&self) -> Result<Transaction<'static, Postgres>> {
        let begun = self.pool.begin_with("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY").await;
        Ok(begun.map_err(ServerError::mark_unreachable)?)
    }

    /// Begins a change, after all changes that have begun before.
    ///
    /// `TakenOver` if this is a daemon that does not serve the ledger any more.
    pub async fn begin_change(&self) -> Result<Transaction<'static, Postgres>> {
        let mut transaction = begin_locked(&self.pool).await?;
        if let Some(lease) = &self.lease {
            lease.fence(&mut transaction).await?;
        }
        Ok(transaction)
    }
}
