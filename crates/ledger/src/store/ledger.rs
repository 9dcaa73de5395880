//! The ledger handle: a database of one of two kinds, and the clock.

use std::{path::Path, sync::Arc, time::Duration};

use super::{
    change::{CommandsDone, LedgerChange},
    health,
    postgres::{self, PostgresStore},
    sqlite_store::SqliteStore,
};
use crate::{
    CommandId, LedgerAddress, LedgerError, LedgerUser, LiveRights, ServerAddress, ServerError, ServiceState,
    ServingNode, ServingRight, SharedFarm, UtcTimestamp,
    base::{
        error::Result,
        sql::{SqlExecutor, SqlTransaction, answered_within},
    },
};
use jiff::Timestamp;

/// The database of a farm. A clone is cheap and refers to the same ledger.
#[derive(Clone)]
pub struct Ledger {
    store: LedgerStore,
    clock: Arc<dyn Fn() -> Timestamp + Send + Sync>,
    /// The commands that are carried out.
    commands: CommandsDone,
    /// The node that opened it on a server to serve it, "" = none: its stored files are those of its machines.
    node: Arc<str>,
}

/// Where the rows are.
#[derive(Clone)]
enum LedgerStore {
    /// In a file.
    Sqlite(SqliteStore),
    /// On a server.
    Postgres(PostgresStore),
}

/// What a ledger on a server is opened for.
enum ServerUse<'a> {
    /// To use it; its schema is brought up to date.
    Any,
    /// To serve it as a daemon.
    Serve(&'a ServingNode),
    /// To use it as it is.
    Existing(LedgerUser),
}

impl Ledger {
    /// Opens the ledger at `at`. Creates the file and its folder if there is none, and migrates the schema.
    ///
    /// # Errors
    /// A network file system, a schema newer than this binary, or an error of the database.
    pub async fn open(at: impl Into<LedgerAddress>) -> Result<Self> {
        match at.into() {
            LedgerAddress::File(path) => Ok(Self::of(LedgerStore::Sqlite(SqliteStore::open(&path).await?))),
            LedgerAddress::Server(server) => Self::open_server(&server, ServerUse::Any).await,
        }
    }

    /// Opens the ledger file like [`Ledger::open`], but only if it is intact.
    ///
    /// # Errors
    /// As [`Ledger::open`], and `Damaged`.
    pub async fn open_checked(path: &Path) -> Result<Self> {
        Ok(Self::of(LedgerStore::Sqlite(SqliteStore::open_checked(path).await?)))
    }

    /// Opens the ledger for a daemon that serves it: a file only if it is intact, and a database on a server only if no other process has
    /// the same right.
    ///
    /// # Errors
    /// As [`Ledger::open`], and `Damaged` or `ServedByOther`.
    pub async fn open_to_serve(at: impl Into<LedgerAddress>, node: &ServingNode) -> Result<Self> {
        let ledger = match at.into() {
            LedgerAddress::File(path) => return Self::open_checked(&path).await,
            LedgerAddress::Server(server) => Self::open_server(&server, ServerUse::Serve(node)).await?,
        };
        let name = if let ServingRight::Node(name) = &node.right { name.as_str() } else { "" };
        Ok(Self { node: name.into(), ..ledger })
    }

    /// Opens an existing ledger with the current schema. For user interfaces, which must not create or change one.
    ///
    /// # Errors
    /// As [`Ledger::open`], and `Missing` or `OlderSchema`.
    pub async fn open_existing(at: impl Into<LedgerAddress>) -> Result<Self> {
        Self::open_existing_for(at, LedgerUser::Command).await
    }

    /// The same, for one who uses a ledger on a server as long as a daemon runs.
    ///
    /// # Errors
    /// As [`Ledger::open_existing`].
    pub async fn open_existing_for(at: impl Into<LedgerAddress>, user: LedgerUser) -> Result<Self> {
        match at.into() {
            LedgerAddress::File(path) => Ok(Self::of(LedgerStore::Sqlite(SqliteStore::open_existing(&path).await?))),
            LedgerAddress::Server(server) => Self::open_server(&server, ServerUse::Existing(user)).await,
        }
    }

    async fn open_server(server: &ServerAddress, to: ServerUse<'_>) -> Result<Self> {
        Ok(Self::of(LedgerStore::Postgres(match to {
            ServerUse::Any => PostgresStore::open(server).await?,
            ServerUse::Serve(node) => PostgresStore::open_to_serve(server, node).await?,
            ServerUse::Existing(user) => PostgresStore::open_existing(server, user).await?,
        })))
    }

    /// Whether there is no ledger at an address: no file or an empty one, or a database without its tables.
    ///
    /// The server cannot be reached.
    pub async fn is_missing(at: &LedgerAddress) -> Result<bool> {
        match at {
            // If it cannot be examined, opening it reports the error.
            LedgerAddress::File(path) => Ok(match std::fs::metadata(path) {
                Ok(meta) => meta.len() == 0,
                Err(error) => error.kind() == std::io::ErrorKind::NotFound,
            }),
            LedgerAddress::Server(server) => {
                match Self::open_server(server, ServerUse::Existing(LedgerUser::Command)).await {
                    Err(LedgerError::Missing { .. }) => Ok(true),
                    Err(LedgerError::OlderSchema { .. } | LedgerError::NewerSchema { .. }) => Ok(false),
                    Err(error) => Err(error),
                    Ok(ledger) => {
                        ledger.close().await;
                        Ok(false)
                    }
                }
            }
        }
    }

    fn of(store: LedgerStore) -> Self {
        Self { store, clock: Arc::new(Timestamp::now), commands: CommandsDone::default(), node: "".into() }
    }

    /// Checks the files of a ledger that no daemon serves. `true` = its checksum matches every byte. A server looks after its files
    /// itself.
    ///
    /// `Damaged` if they changed since they were closed.
    pub async fn check_files(at: impl Into<LedgerAddress>) -> Result<bool> {
        match at.into() {
            LedgerAddress::File(path) => health::check_files(&path).await,
            LedgerAddress::Server(_) => Ok(false),
        }
    }

    /// Whether the daemon that opened this may act on what the ledger says. Takes microseconds.
    pub fn service_state(&self) -> ServiceState {
        match &self.store {
            LedgerStore::Sqlite(store) => store.service_state(),
            LedgerStore::Postgres(store) => store.service_state(),
        }
    }

    /// Who holds the lock that a change of a ledger in a file waits for at this moment; `None` = no change waits.
    pub fn waited_for_lock(&self) -> Option<String> {
        self.sqlite().and_then(SqliteStore::waited_for_lock)
    }

    /// Whether the server of the ledger does not answer, as far as the daemon that serves it knows.
    pub fn is_out_of_reach(&self) -> bool {
        self.sqlite().is_none() && matches!(self.service_state(), ServiceState::Unsure { .. })
    }

    /// What the daemon waits for at this moment: "until" this. `None` = it does not wait.
    pub fn waits_for(&self) -> Option<String> {
        match self.is_out_of_reach() {
            true => Some("the server of the ledger answers".to_owned()),
            false => self.waited_for_lock().map(|holder| format!("{holder} has changed the ledger")),
        }
    }

    /// Fails unless the daemon that opened this may act on what the ledger says.
    ///
    /// # Errors
    /// `Locked`, `Unreachable`, `RepairDue`, `TakenOver` or `Behind`.
    pub fn ensure_served(&self) -> Result<()> {
        match self.service_state() {
            ServiceState::Held => Ok(()),
            ServiceState::Locked { by } => Err(LedgerError::Locked { by }),
            ServiceState::Unsure { why } => Err(ServerError::Unreachable(why).into()),
            ServiceState::RepairDue { nodes } => Err(ServerError::RepairDue { nodes }.into()),
            ServiceState::TakenOver => Err(ServerError::TakenOver.into()),
            ServiceState::Behind => Err(ServerError::Behind.into()),
        }
    }

    /// Fails unless the schema is exactly that of this binary. That of a server may have additions of a newer nestd.
    pub(crate) async fn ensure_own_schema(&self) -> Result<()> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(()),
            LedgerStore::Postgres(store) => store.ensure_own_schema().await,
        }
    }

    /// Number of the changes that these machines may be concerned by, of a ledger on a server which tells of them; `None` = it does not at
    /// present. A hint: one that was not told is found by looking.
    pub fn told_changes<'m>(&self, machines: impl IntoIterator<Item = &'m str>) -> Option<u64> {
        match &self.store {
            LedgerStore::Sqlite(_) => None,
            LedgerStore::Postgres(store) => store.told_changes(machines),
        }
    }

    /// Tells that an operation has failed because the server could not be reached: the daemon stops acting until it can be.
    pub fn doubt_service(&self, _why: &str) {
        if let LedgerStore::Postgres(store) = &self.store {
            store.doubt(_why);
        }
    }

    /// The folders of a node were compared with the ledger: it is due for repair no more.
    pub async fn record_repair(&self, node: &str) -> Result<()> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(()),
            LedgerStore::Postgres(store) => store.record_repair(node).await,
        }
    }

    /// The ledger has lost changes, or is about to: all nodes with machines are due for repair. Those that run, and have lost nothing, say
    /// so themselves.
    pub async fn mark_repair_due(&self, node: &str) -> Result<()> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(()),
            LedgerStore::Postgres(store) => store.mark_repair_due(node).await,
        }
    }

    /// The nodes that are due for repair, because the ledger has lost changes of them.
    pub async fn find_repair_due(&self) -> Result<Vec<String>> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(Vec::new()),
            LedgerStore::Postgres(store) => store.find_repair_due().await,
        }
    }

    /// The farm that all nodes of a ledger on a server are; `None` = it is a file.
    pub async fn shared_farm(&self) -> Result<Option<SharedFarm>> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(None),
            LedgerStore::Postgres(store) => store.shared_farm().await.map(Some),
        }
    }

    /// Who serves a ledger on a server now; `None` = it is a file.
    pub(crate) async fn leased_rights(&self) -> Result<Option<LiveRights>> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(None),
            LedgerStore::Postgres(store) => store.live_rights().await.map(Some),
        }
    }

    /// Takes a duty that one node of a farm does for all, or keeps it for as long again. `false` = another one has it.
    pub async fn hold_duty(&self, duty: &str, owner: &str, lease: Duration) -> Result<bool> {
        match &self.store {
            LedgerStore::Sqlite(_) => Ok(true),
            LedgerStore::Postgres(store) => store.hold_duty(duty, owner, lease).await,
        }
    }

    /// Takes the lease of a node away, unless it is held now. Returns its owner if it is held.
    pub(crate) async fn revoke_lapsed(&self, db: &mut SqlTransaction, node: &str) -> Result<Option<String>> {
        match db {
            SqlTransaction::Sqlite(_) => Ok(None),
            SqlTransaction::Postgres(transaction, limit) => {
                answered_within(*limit, postgres::revoke_lapsed(transaction, node)).await
            }
        }
    }

    /// Checks an open ledger for damage, as [`Ledger::open_checked`] does: reads the whole file. A server checks its own.
    ///
    /// # Errors
    /// `Damaged` if it is damaged.
    pub async fn check_integrity(&self) -> Result<()> {
        match &self.store {
            LedgerStore::Sqlite(store) => store.check_integrity().await,
            LedgerStore::Postgres(_) => Ok(()),
        }
    }

    /// Returns the same ledger with another clock, for tests that control the time.
    pub fn with_clock(self, clock: impl Fn() -> Timestamp + Send + Sync + 'static) -> Self {
        Self { clock: Arc::new(clock), ..self }
    }

    /// Returns the same ledger for carrying out a command: a change that is made through it is committed together with the
    /// state of the command, which is then done. After a crash the command is not carried out once more. `None` = no command
    /// asked for the change.
    pub fn for_command(&self, command: impl Into<Option<CommandId>>) -> Self {
        self.for_commands(command.into().as_slice(), "")
    }

    /// Same as [`Ledger::for_command`] for several, with their answer; "" = they get it later.
    pub fn for_commands(&self, commands: &[CommandId], answer: &str) -> Self {
        Self { commands: CommandsDone { commands: commands.into(), answer: answer.into() }, ..self.clone() }
    }

    /// The node that opened the ledger on a server to serve it, "" = none.
    pub(crate) fn node(&self) -> &str {
        &self.node
    }

    /// The file of the ledger, unless it is in PostgreSQL.
    pub fn file(&self) -> Option<&Path> {
        self.sqlite().map(|store| &*store.path)
    }

    /// The file's store, unless the ledger is in PostgreSQL.
    pub(crate) fn sqlite(&self) -> Option<&SqliteStore> {
        match &self.store {
            LedgerStore::Sqlite(store) => Some(store),
            LedgerStore::Postgres(_) => None,
        }
    }

    /// Closes all connections in an orderly way.
    pub async fn close(&self) {
        match &self.store {
            LedgerStore::Sqlite(store) => store.close().await,
            LedgerStore::Postgres(store) => store.close().await,
        }
    }

    /// Closes all connections in an orderly way and, for a file, writes the checksum, so the next start can verify every
    /// byte; a server needs none. Returns `false` if no checksum was written, for instance because other processes use the ledger; the next
    /// start then checks the whole ledger instead.
    pub async fn close_with_checksum(&self) -> Result<bool> {
        match &self.store {
            LedgerStore::Sqlite(store) => store.close_with_checksum().await,
            LedgerStore::Postgres(store) => {
                store.close().await;
                Ok(true)
            }
        }
    }

    /// Current time of the ledger's clock.
    pub(crate) fn now(&self) -> UtcTimestamp {
        UtcTimestamp((self.clock)())
    }

    /// Where single statements that read run. Fails if the files of the ledger were replaced.
    pub(crate) fn reader(&self) -> Result<SqlExecutor<'_>> {
        match &self.store {
            LedgerStore::Sqlite(store) => store.reader(),
            LedgerStore::Postgres(store) => Ok(store.reader()),
        }
    }

    /// Checks that the open files are still the ones at the ledger's path. Takes microseconds.
    ///
    /// # Errors
    /// `Replaced` if somebody removed or replaced one.
    pub fn ensure_files_in_place(&self) -> Result<()> {
        self.sqlite().map_or(Ok(()), SqliteStore::ensure_files_in_place)
    }

    /// Same as [`Ledger::ensure_files_in_place`], and that nothing was lost of what they held.
    ///
    /// # Errors
    /// `Replaced` or `Overwritten`.
    pub async fn ensure_in_place(&self) -> Result<()> {
        match self.sqlite() {
            Some(store) => store.ensure_in_place().await,
            None => Ok(()),
        }
    }

    /// Begins a change. From here to its commit, no other change of this ledger can happen.
    pub(crate) async fn begin_change(&self) -> Result<LedgerChange> {
        let (transaction, origin) = match &self.store {
            LedgerStore::Sqlite(store) => (SqlTransaction::Sqlite(store.begin_change().await?), store.change_origin()),
            LedgerStore::Postgres(store) => {
                let (transaction, counted) = store.begin_change().await?;
                (transaction, super::change::ChangeOrigin::Server(counted, store.notices()))
            }
        };
        Ok(LedgerChange::new(transaction, self.now(), origin, self.commands.clone()))
    }

    /// Begins a consistent read of several tables.
    pub(crate) async fn begin_snapshot(&self) -> Result<SqlTransaction> {
        Ok(match &self.store {
            LedgerStore::Sqlite(store) => SqlTransaction::Sqlite(store.begin_snapshot().await?),
            LedgerStore::Postgres(store) => store.begin_snapshot().await?,
        })
    }
}

impl std::fmt::Debug for Ledger {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Ledger").field("file", &self.file()).finish_non_exhaustive()
    }
}
