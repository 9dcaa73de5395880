//! The connections of a process to the database: how many there may be, and with which password a new one is made.

use std::{
    os::unix::fs::MetadataExt,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant, SystemTime},
};

use sqlx::{
    ConnectOptions, Connection, PgConnection, PgPool, Postgres, pool::PoolConnection, postgres::PgConnectOptions,
    postgres::PgPoolOptions,
};
use tokio::sync::Notify;

use super::time_limits::{self, ConnectionUser};
use crate::{LedgerError, ServerAddress, ServerError, base::error::Result};

/// How long a statement waits for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// A connection that gives no sign of life within this time gives its place to a new one.
const SIGN_OF_LIFE: Duration = Duration::from_secs(2);
/// How long it may take to find out why no connection was made.
const EXPLAIN_TIMEOUT: Duration = Duration::from_secs(2);

/// The connections of a process. Clones are the same ones.
#[derive(Clone)]
pub struct ServerConnections {
    pool: PgPool,
    login: Arc<Login>,
    doubt: Doubt,
}

/// What a new connection is made with.
struct Login {
    server: ServerAddress,
    /// For whom the connections are, as the database sees it.
    options: Box<dyn Fn(PgConnectOptions) -> PgConnectOptions + Send + Sync>,
    /// The file of the password when it was read last.
    read: Mutex<Option<FileState>>,
}

/// Tells a file from the one that stood there before.
type FileState = (u64, u64, Option<SystemTime>);

/// When a connection last gave no sign of life. Those that were made before are taken for dead with it: to ask each of them would cost the
/// time of one again.
#[derive(Debug, Clone, Default)]
struct Doubt {
    since: Arc<Mutex<Option<Instant>>>,
    /// Wakes whoever has a connection of its own.
    is_new: Arc<Notify>,
}

impl Doubt {
    /// Whether a connection of this age was made after the last doubt.
    fn clears(&self, age: Duration) -> bool {
        let since = *self.since.lock().unwrap_or_else(PoisonError::into_inner);
        since.is_none_or(|since| age < since.elapsed())
    }

    async fn is_alive(&self, db: &mut PgConnection) -> bool {
        let is_alive = matches!(tokio::time::timeout(SIGN_OF_LIFE, db.ping()).await, Ok(Ok(())));
        if !is_alive {
            *self.since.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
            self.is_new.notify_one();
        }
        is_alive
    }
}

impl Login {
    /// The state of the file of the password; `None` = there is none, or it cannot be looked at.
    fn file_state(&self) -> Option<FileState> {
        let meta = std::fs::metadata(self.server.password_file()?).ok()?;
        Some((meta.ino(), meta.len(), meta.modified().ok()))
    }

    fn connect_options(&self) -> Result<PgConnectOptions> {
        // A slow server would bring whole migrations into the journal.
        Ok((self.options)(self.server.connect_options()?).disable_statement_logging())
    }
}

impl ServerConnections {
    /// Connects. Fails by name at what passes the limits of a connection on to nobody, as PgBouncer does.
    pub async fn open(server: &ServerAddress, user: ConnectionUser<'_>) -> Result<Self> {
        let login =
            Login { server: server.clone(), options: Box::new(time_limits::limits_of(user)), read: Mutex::default() };
        *login.read.lock().unwrap_or_else(PoisonError::into_inner) = login.file_state();
        let options = login.connect_options()?;
        let pool = PgPoolOptions::new().max_connections(user.most_connections(server)).acquire_timeout(CONNECT_TIMEOUT);
        let doubt = Doubt::default();
        let (taken, released) = (doubt.clone(), doubt.clone());
        let pool = pool.test_before_acquire(false).before_acquire(move |db, known| {
            let doubt = taken.clone();
            Box::pin(async move { Ok(doubt.clears(known.age) && doubt.is_alive(db).await) })
        });
        let pool = pool.after_release(move |db, _| {
            let doubt = released.clone();
            Box::pin(async move { Ok(doubt.is_alive(db).await) })
        });
        let opened = Self { pool: pool.connect_lazy_with(options), login: Arc::new(login), doubt };
        let mut first = opened.acquire().await?;
        time_limits::ensure_kept(&mut first, user).await?;
        Ok(opened)
    }

    /// The connections, each new one of which has the password that stands in its file now.
    pub fn pool(&self) -> &PgPool {
        let now = self.login.file_state();
        let mut read = self.login.read.lock().unwrap_or_else(PoisonError::into_inner);
        // Without the file, the password that was in it may still be right.
        if now.is_some()
            && *read != now
            && let Ok(options) = self.login.connect_options()
        {
            self.pool.set_connect_options(options);
            *read = now;
        }
        &self.pool
    }

    /// Waits until one of them gives no sign of life.
    pub async fn in_doubt(&self) {
        self.doubt.is_new.notified().await;
    }

    /// One more connection beside these.
    pub fn separate_one(&self) -> Result<PgPool> {
        let one = PgPoolOptions::new().max_connections(1).acquire_timeout(CONNECT_TIMEOUT);
        Ok(one.connect_lazy_with(self.login.connect_options()?))
    }

    /// Takes a connection. The error says why there is none.
    pub async fn acquire(&self) -> Result<PoolConnection<Postgres>> {
        match self.pool().acquire().await {
            Ok(connection) => Ok(connection),
            Err(sqlx::Error::PoolTimedOut) => Err(self.why_none().await),
            Err(error) => Err(ServerError::mark_unreachable(error).into()),
        }
    }

    /// Why no connection was made in time. The driver tries again and again where the server has none left, and does not say so.
    async fn why_none(&self) -> LedgerError {
        let tried =
            async { PgConnection::connect_with(&self.login.connect_options()?).await.map_err(LedgerError::from) };
        let error = match tokio::time::timeout(EXPLAIN_TIMEOUT, tried).await {
            Ok(Err(LedgerError::Sql(error))) => error,
            Ok(Err(error)) => return error,
            Ok(Ok(connection)) => {
                drop(connection);
                sqlx::Error::PoolTimedOut
            }
            Err(_) => sqlx::Error::PoolTimedOut,
        };
        ServerError::mark_unreachable(error).into()
    }
}
