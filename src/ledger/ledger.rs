//! The ledger itself: opening it, its one writer and its readers.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use jiff::Timestamp;
use sqlx::{
    Sqlite, SqlitePool, Transaction,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous},
};

use super::{
    LedgerError, Utc,
    change::Change,
    error::{Result, SQLITE_BUSY, sqlite_code},
    health,
    in_place::InPlace,
    place, schema, truth,
};

/// A writer waits so long for another process before it gives up; changes take milliseconds.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
/// Connections that only read.
const READERS: u32 = 4;
/// Turning a fresh file into WAL mode cannot wait for a lock, so opening is tried so often ...
const OPEN_ATTEMPTS: u32 = 100;
/// ... with this pause.
const OPEN_PAUSE: Duration = Duration::from_millis(50);

/// The database of a farm. Cloning is cheap and gives another handle of the same ledger.
#[derive(Clone)]
pub struct Ledger {
    path: PathBuf,
    writer: SqlitePool,
    reader: SqlitePool,
    /// One connection that nobody uses: SQLite removes the files beside the ledger when its last connection is closed, and the
    /// others are closed and made anew as they are needed.
    anchor: SqlitePool,
    in_place: Arc<InPlace>,
    clock: Arc<dyn Fn() -> Timestamp + Send + Sync>,
}

impl Ledger {
    /// Opens the ledger at `path`; makes the file and its folder when there is none, brings its schema up to date.
    ///
    /// # Errors
    /// A network file system, a schema newer than this binary, or SQLite's own trouble.
    pub async fn open(path: &Path) -> Result<Self> {
        let folder = place::folder(path);
        std::fs::create_dir_all(folder).map_err(|source| LedgerError::Folder { path: path.to_owned(), source })?;
        place::refuse_network(path)?;
        let options = options(path).create_if_missing(true).journal_mode(SqliteJournalMode::Wal);
        let ledger = Self::connect(path, options).await?;
        schema::bring_up_to_date(path, &ledger.writer).await?;
        Ok(ledger)
    }

    /// Opens the ledger as [`Ledger::open`] does, but only when it is whole: for the daemon, which relies on it.
    ///
    /// # Errors
    /// As [`Ledger::open`], and `Damaged`.
    pub async fn open_whole(path: &Path) -> Result<Self> {
        if path.exists() || health::seal_of(path).exists() {
            let is_sealed = health::look_at_files(path).await?;
            if !is_sealed && health::holds_something(path) {
                let ledger = Self::connect(path, options(path)).await?;
                let checked = health::check_all(path, &ledger.writer).await;
                ledger.close().await;
                checked?;
            }
        }
        Self::open(path).await
    }

    /// Looks at the files of a ledger that no daemon serves; `true` = its seal vouches for every byte.
    ///
    /// # Errors
    /// `Damaged` when they are not as they were left.
    pub async fn look_at_files(path: &Path) -> Result<bool> {
        health::look_at_files(path).await
    }

    /// Whether the ledger is whole, as [`Ledger::open_whole`] sees it; for one that is open. Reads the whole file.
    ///
    /// # Errors
    /// `Damaged` when it is not.
    pub async fn check_whole(&self) -> Result<()> {
        health::check_all(&self.path, &self.reader).await
    }

    /// Opens a ledger that is there and up to date; for faces, which must not make or change one.
    ///
    /// # Errors
    /// As [`Ledger::open`], and `Missing` or `OlderSchema`.
    pub async fn open_existing(path: &Path) -> Result<Self> {
        if !path.is_file() {
            return Err(LedgerError::Missing { path: path.to_owned() });
        }
        place::refuse_network(path)?;
        let ledger = Self::connect(path, options(path)).await?;
        schema::demand(path, &ledger.writer).await?;
        Ok(ledger)
    }

    pub(super) async fn connect(path: &Path, options: SqliteConnectOptions) -> Result<Self> {
        // A connection that only reads must say so: a query that writes by mistake would bypass the one writer.
        let reading = options.clone().create_if_missing(false).pragma("query_only", "ON");
        health::clear_note(path);
        let in_place = Arc::new(InPlace::of(path));
        let writer = connect_one(path, options).await?;
        let anchor = connect_one(path, reading.clone()).await?;
        // SQLite opens the file when it is first asked.
        sqlx::query("SELECT count(*) FROM sqlite_schema").execute(&anchor).await.map_err(|e| not_opened(path, e))?;
        let reader = SqlitePoolOptions::new().max_connections(READERS).connect_lazy_with(reading);
        in_place.demand()?;
        Ok(Self { path: path.to_owned(), writer, reader, anchor, in_place, clock: Arc::new(Timestamp::now) })
    }

    /// The same ledger with another clock, for tests that turn time by hand.
    pub fn with_clock(self, clock: impl Fn() -> Timestamp + Send + Sync + 'static) -> Self {
        Self { clock: Arc::new(clock), ..self }
    }

    /// Where the ledger is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Ends all work in order.
    pub async fn close(&self) {
        self.reader.close().await;
        self.anchor.close().await;
        self.writer.close().await;
    }

    /// Ends all work in order and seals the ledger: the next start knows it by every byte. Without a seal, for instance
    /// because others use the ledger, the next start looks through it instead.
    pub async fn close_sealed(&self) -> Result<bool> {
        self.reader.close().await;
        self.anchor.close().await;
        let sealed = health::seal(&self.path, &self.writer).await;
        self.writer.close().await;
        health::clear_note(&self.path);
        sealed
    }

    /// The time by this ledger's clock.
    pub(super) fn now(&self) -> Utc {
        Utc((self.clock)())
    }

    /// The one connection that writes.
    pub(super) fn writer(&self) -> &SqlitePool {
        &self.writer
    }

    /// Connections that only read, as long as they read what stands in the ledger's place.
    pub(super) fn reader(&self) -> Result<&SqlitePool> {
        self.demand_in_place()?;
        Ok(&self.reader)
    }

    /// Whether the files that are open are those that stand in the ledger's place; takes microseconds.
    ///
    /// # Errors
    /// `Replaced` when somebody removed or replaced one.
    pub fn demand_in_place(&self) -> Result<()> {
        self.in_place.demand()
    }

    /// Begins a change. It takes the write lock at once: a deferred `BEGIN` that turns from reading to writing fails
    /// with "database is locked" when another process has written in between, whatever the busy timeout says.
    pub(super) async fn change(&self) -> Result<Change> {
        self.demand_in_place()?;
        let transaction = match self.writer.begin_with("BEGIN IMMEDIATE").await {
            // SQLite itself took an earlier change back, as it may on a full disk, and the connection still waits for its end.
            Err(sqlx::Error::InvalidSavePointStatement | sqlx::Error::BeginFailed) => {
                self.writer.acquire().await?.close().await?;
                self.writer.begin_with("BEGIN IMMEDIATE").await?
            }
            begun => begun?,
        };
        health::break_seal(&self.path).map_err(|source| LedgerError::Folder { path: self.path.clone(), source })?;
        Ok(Change::new(transaction, self.now(), self.path.clone()))
    }

    /// Begins to read several tables as of one moment. It never writes, so that a deferred `BEGIN` is right here.
    pub(super) async fn snapshot(&self) -> Result<Transaction<'static, Sqlite>> {
        Ok(self.reader()?.begin_with("BEGIN DEFERRED").await?)
    }

    /// Looks at every row and says in sentences what does not agree; empty = all is well.
    pub async fn faults(&self) -> Result<Vec<String>> {
        truth::faults(&mut *self.snapshot().await?).await
    }
}

impl std::fmt::Debug for Ledger {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Ledger").field("path", &self.path).finish_non_exhaustive()
    }
}

/// A pool of one connection that stays; waits while another process turns the file into WAL mode.
async fn connect_one(path: &Path, options: SqliteConnectOptions) -> Result<SqlitePool> {
    let pool = SqlitePoolOptions::new().max_connections(1).idle_timeout(None).max_lifetime(None);
    let mut attempt = 1;
    loop {
        match pool.clone().connect_with(options.clone()).await {
            Ok(connected) => return Ok(connected),
            Err(error) if sqlite_code(&error) == Some(SQLITE_BUSY) && attempt < OPEN_ATTEMPTS => attempt += 1,
            Err(error) => return Err(not_opened(path, error)),
        }
        tokio::time::sleep(OPEN_PAUSE).await;
    }
}

fn not_opened(path: &Path, error: sqlx::Error) -> LedgerError {
    let what = error.to_string();
    match LedgerError::from(error) {
        LedgerError::Corrupt(_) => LedgerError::Damaged { path: path.to_owned(), what },
        LedgerError::Sql(error) => LedgerError::Open { path: path.to_owned(), error },
        other => other,
    }
}

/// FULL: a committed change survives a power cut, as "exactly once" needs.
pub(super) fn options(path: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(path)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(BUSY_TIMEOUT)
}
