//! How long the database lets a connection wait, work, or do nothing while others wait for it. The database itself enforces it: a
//! process that has died, sleeps, or is cut off without the connection having ended cannot. Who waits for an answer has a limit, too. What
//! reads or writes all rows has limits of its own (`sql::allow_whole_ledger`).

use std::time::Duration;

use sqlx::postgres::PgConnectOptions;

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

/// For whom a connection is made.
#[derive(Debug, Clone, Copy)]
pub enum ConnectionUser<'a> {
    /// The daemon of this node.
    Node(&'a str),
    /// A command, or whatever else is no node.
    Command,
}

impl ConnectionUser<'_> {
    /// Within what time a statement is answered, unless the link to the server has fallen silent: neither the limits of the database nor
    /// its questions whether the connection lives reach whoever waits there.
    pub fn answered_within(self) -> Duration {
        self.statement_limit() + ANSWER_LATER
    }

    /// After what time the database ends a statement.
    fn statement_limit(self) -> Duration {
        match self {
            Self::Node(_) => DAEMON_STATEMENT,
            Self::Command => COMMAND_STATEMENT,
        }
    }
}

/// The options with the limits, and with a name by which `pg_stat_activity` shows whose connection it is.
pub fn limit(options: PgConnectOptions, user: ConnectionUser<'_>) -> PgConnectOptions {
    let (name, lock_timeout) = match user {
        ConnectionUser::Node(node) => (node.to_owned(), DAEMON_WAITS),
        ConnectionUser::Command => {
            let host = rustix::system::uname().nodename().to_string_lossy().into_owned();
            (format!("a command on {host}, process {}", std::process::id()), COMMAND_WAITS)
        }
    };
    let statement = format!("{}s", user.statement_limit().as_secs());
    let limits = [
        ("lock_timeout", lock_timeout),
        ("statement_timeout", &statement),
        ("idle_in_transaction_session_timeout", IDLE_IN_CHANGE),
        ("tcp_user_timeout", UNANSWERED_MS),
    ];
    options.application_name(&name).options(limits).options(KEEPALIVES)
}
