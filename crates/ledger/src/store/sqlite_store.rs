//! A ledger in a SQLite file: its single writer, its readers, and the guard of its files.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use sqlx::{
    ConnectOptions, Sqlite, SqlitePool, Transaction,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous},
};

use super::{change::ChangeOrigin, file_guard::LedgerFileGuard, health, last_change::LastChangeSeen, location, schema};
use crate::{
    LedgerError, ServiceState,
    base::{
        error::Result,
        lock_wait::{BUSY_TIMEOUT, LockWait, TOLD_AFTER, describe_holder},
        sql::SqlExecutor,
        sqlite_code::{SQLITE_BUSY, sqlite_code},
    },
};

/// Number of read-only connections.
const READERS: u32 = 4;
/// Memory in which a connection may keep pages, KiB. SQLite's own 2 MiB hold some thousand parts, and with more of them each query reads its
/// pages from the file again.
const CACHE_KIB: u32 = 64 << 10;
/// Switching a new file to WAL mode cannot wait for a lock, so opening is retried this many times ...
const OPEN_ATTEMPTS: u32 = 100;
/// ... with this pause.
const OPEN_PAUSE: Duration = Duration::from_millis(50);

/// An open SQLite file. A clone is cheap and refers to the same connections.
#[derive(Clone)]
pub struct SqliteStore {
    /// Path of the file.
    pub path: PathBuf,
    writer: SqlitePool,
    reader: SqlitePool,
    /// A connection that is never used. SQLite removes the files beside the ledger when its last connection closes, and
    /// the other connections are closed and reopened as needed.
    anchor: SqlitePool,
    file_guard: Arc<LedgerFileGuard>,
    last_change: Arc<LastChangeSeen>,
    lock_wait: Arc<LockWait>,
}

impl SqliteStore {
    /// Opens the file at `path`. Creates it and its folder if there is none, and migrates the schema.
    pub async fn open(path: &Path) -> Result<Self> {
        let folder = location::parent_folder(path);
        std::fs::create_dir_all(folder).map_err(|source| LedgerError::Folder { path: path.to_owned(), source })?;
        location::refuse_network_location(path)?;
        let options = connect_options(path).create_if_missing(true).journal_mode(SqliteJournalMode::Wal);
        let store = Self::connect(path, options).await?;
        schema::bring_up_to_date(path, &store.writer)
            .await
            .map_err(|error| name_holder(path, &store.lock_wait, error))?;
        Ok(store)
    }

    /// Opens the file like [`SqliteStore::open`], but only if it is intact.
    pub async fn open_checked(path: &Path) -> Result<Self> {
        if path.exists() || health::checksum_path(path).exists() {
            let is_sealed = health::check_files(path).await?;
            if !is_sealed && health::has_content(path) {
                let store = Self::connect(path, connect_options(path)).await?;
                let checked = health::check_database(path, &store.writer).await;
                store.close().await;
                checked?;
            }
        }
        Self::open(path).await
    }

    /// Opens an existing file with the current schema.
    pub async fn open_existing(path: &Path) -> Result<Self> {
        if !path.is_file() {
            return Err(LedgerError::Missing { path: path.to_owned() });
        }
        location::refuse_network_location(path)?;
        health::ensure_no_noted_loss(path)?;
        let store = Self::connect(path, connect_options(path)).await?;
        schema::ensure_current_version(path, &store.writer).await?;
        Ok(store)
    }

    /// Opens the connections. Neither creates nor migrates anything by itself.
    pub async fn connect(path: &Path, options: SqliteConnectOptions) -> Result<Self> {
        // A read-only connection must be marked as such: a query that writes by mistake would bypass the single writer.
        let reading = options.clone().create_if_missing(false).pragma("query_only", "ON");
        health::clear_note(path);
        let in_place = Arc::new(LedgerFileGuard::for_ledger(path));
        let writer = connect_one(path, options).await?;
        let anchor = connect_one(path, reading.clone()).await?;
        // SQLite opens the file at the first query.
        sqlx::query("SELECT count(*) FROM sqlite_schema").execute(&anchor).await.map_err(|e| open_error(path, e))?;
        let reader = SqlitePoolOptions::new().max_connections(READERS).connect_lazy_with(reading);
        in_place.ensure_unchanged()?;
        let (last_change, lock_wait) = Default::default();
        Ok(Self { path: path.to_owned(), writer, reader, anchor, file_guard: in_place, last_change, lock_wait })
    }

    /// Closes all connections in an orderly way.
    pub async fn close(&self) {
        self.reader.close().await;
        self.anchor.close().await;
        self.writer.close().await;
    }

    /// Closes all connections in an orderly way and writes the checksum, so the next start can verify every byte.
    /// Returns `false` if no checksum was written, for instance because other processes use the ledger; the next start
    /// then checks the whole ledger instead.
    pub async fn close_with_checksum(&self) -> Result<bool> {
        self.reader.close().await;
        self.anchor.close().await;
        let sealed = health::checkpoint_with_checksum(&self.path, &self.writer).await;
        self.writer.close().await;
        health::clear_note(&self.path);
        sealed
    }

    /// The single connection that writes.
    pub fn writer(&self) -> &SqlitePool {
        &self.writer
    }

    /// The read-only connections. Fails if the files at the ledger's path were replaced.
    pub fn reader(&self) -> Result<SqlExecutor<'_>> {
        self.ensure_files_in_place()?;
        Ok(SqlExecutor::SqlitePool(&self.reader))
    }

    /// Begins a consistent read of several tables. It never writes, so a deferred `BEGIN` is right here.
    pub async fn begin_snapshot(&self) -> Result<Transaction<'static, Sqlite>> {
        self.ensure_files_in_place()?;
        Ok(self.reader.begin_with("BEGIN DEFERRED").await?)
    }

    /// Reads every page and looks for damage.
    pub async fn check_integrity(&self) -> Result<()> {
        health::check_database(&self.path, &self.reader).await
    }

    /// Checks that the open files are still the ones at the ledger's path. Takes microseconds.
    ///
    /// `Replaced` if somebody removed or replaced one.
    pub fn ensure_files_in_place(&self) -> Result<()> {
        self.file_guard.ensure_unchanged()
    }

    /// Same as [`SqliteStore::ensure_files_in_place`], and that nothing is missing of the changes that this process has seen.
    ///
    /// `Replaced` or `Overwritten`.
    pub async fn ensure_in_place(&self) -> Result<()> {
        self.ensure_files_in_place()?;
        let loss = self.last_change.find_loss(&self.reader).await?;
        self.refuse_overwritten(loss)
    }

    fn refuse_overwritten(&self, loss: Option<String>) -> Result<()> {
        let Some(what) = loss else { return Ok(()) };
        health::note_loss(&self.path, &what);
        Err(LedgerError::Overwritten { path: self.path.clone(), what })
    }

    /// Where a change is made.
    pub fn change_origin(&self) -> ChangeOrigin {
        ChangeOrigin::File(self.path.clone(), self.last_change.clone())
    }

    /// Whether changes can be made, as far as anybody knows.
    pub fn service_state(&self) -> ServiceState {
        match self.lock_wait.given_up(&self.path) {
            Some(holder) => ServiceState::Locked { by: describe_holder(holder.as_ref()) },
            None => ServiceState::Held,
        }
    }

    /// Who holds the lock that a change waits for at this moment.
    pub fn waited_for_lock(&self) -> Option<String> {
        self.lock_wait.waited_for()
    }

    /// Begins a change. It takes the write lock immediately. A deferred `BEGIN` that first reads and then writes fails
    /// with "database is locked" if another process wrote in between, whatever the busy timeout is.
    pub async fn begin_change(&self) -> Result<Transaction<'static, Sqlite>> {
        self.ensure_files_in_place()?;
        // Also what other processes have changed may not be missing.
        if let Some(noted) = health::noted_change(&self.path) {
            self.last_change.record(noted);
        }
        // One change has waited; the others need not wait as well.
        if let ServiceState::Locked { by } = self.service_state() {
            return Err(LedgerError::Locked { by });
        }
        let mut transaction = match self.take_write_lock().await {
            // SQLite itself rolled back an earlier change, as it may on a full disk, and the connection still expects
            // the end of that transaction.
            Err(sqlx::Error::InvalidSavePointStatement | sqlx::Error::BeginFailed) => {
                self.writer.acquire().await?.close().await?;
                self.take_write_lock().await
            }
            begun => begun,
        }
        .map_err(|error| name_holder(&self.path, &self.lock_wait, error.into()))?;
        let loss = self.last_change.find_loss(&mut *transaction).await?;
        self.refuse_overwritten(loss)?;
        health::remove_checksum(&self.path)
            .map_err(|source| LedgerError::Folder { path: self.path.clone(), source })?;
        Ok(transaction)
    }

    /// Takes the write lock, and notes who holds it meanwhile.
    async fn take_write_lock(&self) -> Result<Transaction<'static, Sqlite>, sqlx::Error> {
        let begin = self.writer.begin_with("BEGIN IMMEDIATE");
        tokio::pin!(begin);
        let begun = loop {
            tokio::select! {
                begun = &mut begin => break begun,
                () = tokio::time::sleep(TOLD_AFTER) => drop(self.lock_wait.note(&self.path, false)),
            }
        };
        self.lock_wait.end();
        begun
    }
}

/// Creates a pool with a single permanent connection. Waits while another process switches the file to WAL mode.
async fn connect_one(path: &Path, options: SqliteConnectOptions) -> Result<SqlitePool> {
    let pool = SqlitePoolOptions::new().max_connections(1).idle_timeout(None).max_lifetime(None);
    let mut attempt = 1;
    loop {
        match pool.clone().connect_with(options.clone()).await {
            Ok(connected) => return Ok(connected),
            Err(error) if sqlite_code(&error) == Some(SQLITE_BUSY) && attempt < OPEN_ATTEMPTS => attempt += 1,
            Err(error) => return Err(open_error(path, error)),
        }
        tokio::time::sleep(OPEN_PAUSE).await;
    }
}

/// An error that says only that the lock was not free in time says who holds it.
fn name_holder(path: &Path, wait: &LockWait, error: LedgerError) -> LedgerError {
    match &error {
        LedgerError::Sql(cause) if sqlite_code(cause) == Some(SQLITE_BUSY) => {
            LedgerError::Locked { by: describe_holder(wait.note(path, true).as_ref()) }
        }
        _ => error,
    }
}

fn open_error(path: &Path, error: sqlx::Error) -> LedgerError {
    let what = error.to_string();
    match name_holder(path, &LockWait::default(), error.into()) {
        LedgerError::Corrupt(_) => LedgerError::Damaged { path: path.to_owned(), what },
        LedgerError::Sql(error) => LedgerError::Open { path: path.to_owned(), error },
        other => other,
    }
}

/// Connection options. `FULL`: a committed change survives a power cut, as "exactly once" requires.
pub fn connect_options(path: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(path)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(BUSY_TIMEOUT)
        .pragma("cache_size", format!("-{CACHE_KIB}"))
        // A slow disk would bring whole migrations into the journal.
        .disable_statement_logging()
}
