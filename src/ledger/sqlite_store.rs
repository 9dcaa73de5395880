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

use super::{
    LedgerError,
    error::Result,
    file_guard::LedgerFileGuard,
    health, location, schema,
    sql::SqlExecutor,
    sqlite_code::{SQLITE_BUSY, sqlite_code},
};

/// Time that a writer waits for another process before it gives up. Changes take milliseconds.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
/// Number of read-only connections.
const READERS: u32 = 4;
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
}

impl SqliteStore {
    /// Opens the file at `path`. Creates it and its folder if there is none, and migrates the schema.
    pub async fn open(path: &Path) -> Result<Self> {
        let folder = location::parent_folder(path);
        std::fs::create_dir_all(folder).map_err(|source| LedgerError::Folder { path: path.to_owned(), source })?;
        location::reject_network_location(path)?;
        let options = connect_options(path).create_if_missing(true).journal_mode(SqliteJournalMode::Wal);
        let store = Self::connect(path, options).await?;
        schema::bring_up_to_date(path, &store.writer).await?;
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
        location::reject_network_location(path)?;
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
        Ok(Self { path: path.to_owned(), writer, reader, anchor, file_guard: in_place })
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

    /// Begins a change. It takes the write lock immediately. A deferred `BEGIN` that first reads and then writes fails
    /// with "database is locked" if another process wrote in between, whatever the busy timeout is.
    pub async fn begin_change(&self) -> Result<Transaction<'static, Sqlite>> {
        self.ensure_files_in_place()?;
        let transaction = match self.writer.begin_with("BEGIN IMMEDIATE").await {
            // SQLite itself rolled back an earlier change, as it may on a full disk, and the connection still expects
            // the end of that transaction.
            Err(sqlx::Error::InvalidSavePointStatement | sqlx::Error::BeginFailed) => {
                self.writer.acquire().await?.close().await?;
                self.writer.begin_with("BEGIN IMMEDIATE").await?
            }
            begun => begun?,
        };
        health::remove_checksum(&self.path)
            .map_err(|source| LedgerError::Folder { path: self.path.clone(), source })?;
        Ok(transaction)
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

fn open_error(path: &Path, error: sqlx::Error) -> LedgerError {
    let what = error.to_string();
    match LedgerError::from(error) {
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
        // A slow disk would bring whole migrations into the journal.
        .disable_statement_logging()
}
