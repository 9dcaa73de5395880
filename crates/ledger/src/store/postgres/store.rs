//! A ledger in a PostgreSQL database.

use std::time::Duration;

use tokio::task::AbortHandle;

use super::{
    change_lock::begin_locked,
    connections::ServerConnections,
    lease::{self, CountedChange, HeldLease},
    notices::ChangeNotices,
    repair_due,
    schema::SCHEMA,
    shared_farm,
    time_limits::ConnectionUser,
};
use crate::{
    LedgerError, LedgerUser, LiveRights, ServerAddress, ServerError, ServiceState, ServingNode, ServingRight,
    SharedFarm,
    base::{
        error::Result,
        sql::{SqlExecutor, SqlTransaction, answered_within},
    },
};

/// An open database. A clone is cheap and refers to the same connections.
#[derive(Clone)]
pub struct PostgresStore {
    connections: ServerConnections,
    /// Within what time a statement is answered.
    answered_within: Duration,
    /// The address, without its password.
    label: String,
    /// The right to serve the ledger, which a daemon has.
    lease: Option<HeldLease>,
    /// The changes that a daemon is told of, and what listens to them.
    notices: ChangeNotices,
    listening: Option<AbortHandle>,
}

impl PostgresStore {
    /// Opens the database and migrates its schema.
    pub async fn open(server: &ServerAddress) -> Result<Self> {
        let store = Self::connect(server, ConnectionUser::RightHolder).await?;
        SCHEMA.bring_up_to_date(store.connections.pool(), &store.label, "").await?;
        Ok(store)
    }

    /// Opens the database as [`PostgresStore::open`] does, for a process that serves it.
    ///
    /// `OlderNodes` if nodes run that could not use the migrated ledger, `ServedByOther` if another one has the same right, or one that excludes it.
    pub async fn open_to_serve(server: &ServerAddress, node: &ServingNode) -> Result<Self> {
        let user = match &node.right {
            ServingRight::Node(name) => ConnectionUser::Node(name),
            ServingRight::RepairedNode(_) | ServingRight::WholeLedger => ConnectionUser::RightHolder,
        };
        let store = Self::connect(server, user).await?;
        SCHEMA.bring_up_to_date(store.connections.pool(), &store.label, &node.owner).await?;
        let lease = store.within(HeldLease::acquire(&store.connections, node)).await?;
        // A newer nestd may have changed the schema meanwhile. From now on it sees what this one knows.
        if let Err(error) = SCHEMA.ensure_usable(store.connections.pool(), &store.label).await {
            lease.release().await;
            return Err(error);
        }
        let is_node = matches!(user, ConnectionUser::Node(_));
        let listening = is_node.then(|| store.notices.listen_on(&store.connections));
        Ok(Self { lease: Some(lease), listening, ..store })
    }

    /// Opens a database that holds a ledger which this binary can use.
    ///
    /// `Missing` if it holds none, `OlderSchema` or `NewerSchema`.
    pub async fn open_existing(server: &ServerAddress, user: LedgerUser) -> Result<Self> {
        let store = Self::connect(server, ConnectionUser::Other(user)).await?;
        match SCHEMA.ensure_usable(store.connections.pool(), &store.label).await {
            Ok(()) => Ok(store),
            Err(LedgerError::OlderSchema { found: 0, .. }) => {
                store.close().await;
                Err(LedgerError::Missing { path: store.label.into() })
            }
            Err(error) => Err(error),
        }
    }

    async fn connect(server: &ServerAddress, user: ConnectionUser<'_>) -> Result<Self> {
        let connections = ServerConnections::open(server, user).await?;
        let (answered_within, label) = (user.answered_within(), server.to_string());
        Ok(Self {
            connections,
            answered_within,
            label,
            lease: None,
            notices: ChangeNotices::default(),
            listening: None,
        })
    }

    /// What this process is told of changes.
    pub fn notices(&self) -> ChangeNotices {
        self.notices.clone()
    }

    /// Number of the changes that these machines may be concerned by; `None` = this process is not told of changes at present.
    pub fn told_changes<'m>(&self, machines: impl IntoIterator<Item = &'m str>) -> Option<u64> {
        self.notices.count_for(machines)
    }

    /// Waits for what the server is asked.
    async fn within<T>(&self, work: impl Future<Output = Result<T>>) -> Result<T> {
        answered_within(self.answered_within, work).await
    }

    /// Fails unless the schema is exactly that of this binary.
    pub async fn ensure_own_schema(&self) -> Result<()> {
        self.within(SCHEMA.ensure_own(self.connections.pool(), &self.label)).await
    }

    /// Gives the right to serve the ledger back, and closes all connections.
    pub async fn close(&self) {
        self.listening.iter().for_each(AbortHandle::abort);
        if let Some(lease) = &self.lease
            && !self.connections.pool().is_closed()
        {
            lease.release().await;
        }
        self.connections.pool().close().await;
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
        self.within(repair_due::record_repair(self.connections.pool(), node)).await
    }

    /// The ledger has lost changes, or is about to: all nodes with machines are due for repair.
    pub async fn mark_repair_due(&self, node: &str) -> Result<()> {
        self.within(repair_due::mark(self.connections.pool(), node, true)).await
    }

    /// The nodes that are due for repair.
    pub async fn find_repair_due(&self) -> Result<Vec<String>> {
        let mut db = self.connections.acquire().await?;
        self.within(repair_due::find_due(&mut db)).await
    }

    /// The farm of the ledger.
    pub async fn shared_farm(&self) -> Result<SharedFarm> {
        self.within(shared_farm::find(self.connections.pool())).await
    }

    /// Who serves the ledger now.
    pub async fn live_rights(&self) -> Result<LiveRights> {
        self.within(lease::live_rights(self.connections.pool())).await
    }

    /// Takes a duty that one node does for all, or keeps it for as long again. `false` = another one has it.
    pub async fn hold_duty(&self, duty: &str, owner: &str, lease: Duration) -> Result<bool> {
        self.within(lease::hold_duty(self.connections.pool(), duty, owner, lease)).await
    }

    /// The connections for single statements that read.
    pub fn reader(&self) -> SqlExecutor<'_> {
        SqlExecutor::PostgresPool(self.connections.pool(), self.answered_within)
    }

    /// Begins a consistent read of several tables.
    pub async fn begin_snapshot(&self) -> Result<SqlTransaction> {
        let limit = self.answered_within;
        let begin = self.connections.pool().begin_with("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
        let begun = answered_within(limit, begin).await.map_err(ServerError::mark_unreachable)?;
        Ok(SqlTransaction::Postgres(begun, limit))
    }

    /// Begins a change, after all changes that have begun before.
    ///
    /// `TakenOver` if this is a daemon that does not serve the ledger any more, `Behind` if the database has lost changes of it,
    /// `RepairDue` if it has lost changes of others.
    pub async fn begin_change(&self) -> Result<(SqlTransaction, Option<CountedChange>)> {
        let begin = async {
            let mut transaction = begin_locked(self.connections.pool()).await?;
            let counted = match &self.lease {
                Some(lease) => Some(lease.count_change(&mut transaction).await?),
                None => None,
            };
            Ok((SqlTransaction::Postgres(transaction, self.answered_within), counted))
        };
        self.within(begin).await
    }
}
