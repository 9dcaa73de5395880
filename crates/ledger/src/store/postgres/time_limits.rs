//! How long the database lets a connection wait, work, or do nothing while others wait for it. The database itself enforces it: a
//! process that has died, sleeps, or is cut off without the connection having ended cannot. Who waits for an answer has a limit, too. What
//! reads or writes all rows has limits of its own (`sql::allow_whole_ledger`).

use std::time::Duration;

use sqlx::{PgConnection, postgres::PgConnectOptions};

use crate::{LedgerUser, ServerAddress, ServerError, base::error::Result};

/// A connection that does nothing within a transaction is ended after this time, which is well below a lease.
const IDLE_IN_CHANGE: &str = "10s";
/// A daemon tries again after this time, and an alert tells whom it waits for.
const DAEMON_WAITS: &str = "5s";
/// A command waits for longer than a dead connection can keep it.
const COMMAND_WAITS: &str = "20s";
/// A daemon's statements are short, and its service manager takes it for dead after 30 s.
const DAEMON_STATEMENT: Duration = Duration::from_secs(15);
/// On 100,000 waiting parts and a slow core, all statements of the slowest page together take half of this time.
const COMMAND_STATEMENT: Duration = Duration::from_secs(60);
/// Within this time after the limit of the database, an answer has come, or none comes.
const ANSWER_LATER: Duration = Duration::from_secs(5);
/// A packet without an answer ends the connection after this time, ms.
const UNANSWERED_MS: &str = "20000";
/// An idle connection is asked whether it lives after this time, and so often until it counts as dead, seconds.
const KEEPALIVES: [(&str, &str); 3] =
    [("tcp_keepalives_idle", "10"), ("tcp_keepalives_interval", "5"), ("tcp_keepalives_count", "3")];

/// Connections of the pages of a daemon.
const PAGES_CONNECTIONS: u32 = 2;
/// The connection on which it is told of changes.
const LISTENING_CONNECTIONS: u32 = 1;
/// Connection of its metrics and messages.
const MONITORING_CONNECTIONS: u32 = 1;
/// Connections of a command.
const COMMAND_CONNECTIONS: u32 = 2;

/// For whom a connection is made.
#[derive(Debug, Clone, Copy)]
pub enum ConnectionUser<'a> {
    /// The daemon of this node.
    Node(&'a str),
    /// A process that has a right of another kind: it renews that beside its work.
    RightHolder,
    /// Somebody who looks, and asks.
    Other(LedgerUser),
}

impl ConnectionUser<'_> {
    /// Within what time a statement is answered, unless the link to the server has fallen silent: neither the limits of the database nor
    /// its questions whether the connection lives reach whoever waits there.
    pub fn answered_within(self) -> Duration {
        self.statement_limit() + ANSWER_LATER
    }

    /// How many connections there may be. Those of a daemon, its pages and its monitoring are together as many as it may have.
    pub fn most_connections(self, server: &ServerAddress) -> u32 {
        match self {
            Self::Node(_) => {
                let others = PAGES_CONNECTIONS + MONITORING_CONNECTIONS + LISTENING_CONNECTIONS;
                server.connections().saturating_sub(others).max(2)
            }
            Self::RightHolder => COMMAND_CONNECTIONS + 1,
            Self::Other(LedgerUser::Command) => COMMAND_CONNECTIONS,
            Self::Other(LedgerUser::Pages) => PAGES_CONNECTIONS,
            Self::Other(LedgerUser::Monitoring) => MONITORING_CONNECTIONS,
        }
    }

    /// How long a statement waits for a lock.
    fn lock_timeout(self) -> &'static str {
        match self {
            Self::Node(_) => DAEMON_WAITS,
            Self::RightHolder | Self::Other(_) => COMMAND_WAITS,
        }
    }

    /// After what time the database ends a statement.
    fn statement_limit(self) -> Duration {
        match self {
            Self::Node(_) => DAEMON_STATEMENT,
            Self::RightHolder | Self::Other(_) => COMMAND_STATEMENT,
        }
    }
}

/// The limits, and a name by which `pg_stat_activity` shows whose connection it is.
pub fn limits_of(user: ConnectionUser<'_>) -> impl Fn(PgConnectOptions) -> PgConnectOptions + Send + Sync + use<> {
    let host = || rustix::system::uname().nodename().to_string_lossy().into_owned();
    let lock_timeout = user.lock_timeout();
    let name = match user {
        ConnectionUser::Node(node) => node.to_owned(),
        ConnectionUser::Other(LedgerUser::Pages) => format!("the pages on {}", host()),
        ConnectionUser::Other(LedgerUser::Monitoring) => format!("metrics and messages on {}", host()),
        ConnectionUser::RightHolder | ConnectionUser::Other(LedgerUser::Command) => {
            format!("a command on {}, process {}", host(), std::process::id())
        }
    };
    let statement = format!("{}s", user.statement_limit().as_secs());
    move |options| {
        let limits = [
            ("lock_timeout", lock_timeout),
            ("statement_timeout", &statement),
            ("idle_in_transaction_session_timeout", IDLE_IN_CHANGE),
            ("tcp_user_timeout", UNANSWERED_MS),
        ];
        options.application_name(&name).options(limits).options(KEEPALIVES)
    }
}

/// Fails if the limits of a connection are not in force: what stands between nestd and the database does not pass them on.
pub async fn ensure_kept(db: &mut PgConnection, user: ConnectionUser<'_>) -> Result<()> {
    let limit = sqlx::query_scalar("SELECT current_setting('lock_timeout')").fetch_one(db).await;
    let limit: String = limit.map_err(ServerError::mark_unreachable)?;
    match limit == user.lock_timeout() {
        true => Ok(()),
        false => Err(ServerError::Pooled(format!("lock_timeout is {limit}")).into()),
    }
}
