//! What goes wrong with a ledger that is on a server, beyond what goes wrong with any ledger.

use thiserror::Error;

/// PostgreSQL's code for a lock that was not free in time.
const LOCK_TIMEOUT: &str = "55P03";

/// Why a ledger on a server cannot be used.
#[derive(Debug, Error)]
pub enum ServerError {
    /// Its address, the file with its password or this binary is wrong.
    #[error("the ledger {ledger} cannot be used: {what}")]
    Unusable {
        /// The address, without its password.
        ledger: String,
        /// What is wrong.
        what: String,
    },
    /// The server does not answer.
    #[error("the server of the ledger cannot be reached: {0}")]
    Unreachable(String),
    /// A connection pooler stands between nestd and the database.
    #[error(
        "what answers there is no PostgreSQL but a connection pooler, as PgBouncer is: it does not keep the limits of a connection ({0}). Name \
         the address of the database itself; `node.connections` limits how many connections nestd makes"
    )]
    Pooled(String),
    /// It was not this change's turn in time.
    #[error(
        "all changes of the ledger wait for the connection of {holder}. The database ends one that does nothing within 10 s: try again \
         then. Where it stays, look at the server of that connection; `SELECT pg_terminate_backend(..)` in the database, with the number \
         of the server process, ends it, and nothing is lost by that"
    )]
    ChangesWait {
        /// Whose it is, the process on the server, from where, what it does, and since when.
        holder: String,
    },
    /// Another daemon serves it.
    #[error(
        "another nestd serves this ledger: {owner}. Stop that one first; where it has ended without giving the ledger back, this one \
         can start in {secs} s"
    )]
    ServedByOther {
        /// Server and state folder of the other one.
        owner: String,
        /// Seconds until its right ends, unless it renews it.
        secs: i64,
    },
    /// A machine cannot be adopted, because its node serves it.
    #[error(
        "the machine {machine} is served by the node {node} ({owner}). If that node runs, remove the machine from its configuration and \
         reload it; if it has ended, its right ends within 30 s"
    )]
    NodeAlive {
        /// Machine.
        machine: String,
        /// Name of the node.
        node: String,
        /// Server and state folder of the node.
        owner: String,
    },
    /// Another daemon has taken it over.
    #[error("another nestd serves this ledger now; this one changes nothing more")]
    TakenOver,
    /// Nodes run that could not use the ledger after the migration.
    #[error(
        "this nestd changes the schema of the ledger, which the nestd of these could not use any more: {nodes}. Stop them, start this one, \
         and upgrade them before they start again"
    )]
    OlderNodes {
        /// The rights that they hold, with servers and state folders.
        nodes: String,
    },
    /// A migration found its tables in use.
    #[error(
        "the schema of the ledger is to be brought up to date, and another program reads it, perhaps pg_dump or `nestd backup`; this is \
         tried again until that one has ended"
    )]
    SchemaInUse,
    /// The database has lost changes of these nodes.
    #[error(
        "the server of the ledger has lost the last changes of {nodes}: nothing is taken or published until `nestd check --deep --repair` \
         was run there, or `nestd adopt` here for each machine of a node that is gone for good"
    )]
    RepairDue {
        /// Their names.
        nodes: String,
    },
    /// The database has lost changes that were committed.
    #[error(
        "the server of the ledger has lost the last changes of this nestd: a standby took its place without them, or a backup was put back"
    )]
    Behind,
}

impl ServerError {
    /// Whether the same operation can succeed later, without a change of it.
    pub fn is_transient(&self) -> bool {
        matches!(self, Self::Unreachable(_) | Self::ChangesWait { .. } | Self::RepairDue { .. } | Self::SchemaInUse)
    }

    /// Marks an error of PostgreSQL's driver that says that the server cannot be reached. SQLite has errors of the same kinds, for other
    /// reasons, so that this is told where the database is known.
    pub(crate) fn mark_unreachable(error: sqlx::Error) -> sqlx::Error {
        use sqlx::Error::{Io, PoolClosed, PoolTimedOut, Tls, WorkerCrashed};
        let what = match &error {
            Io(_) | Tls(_) | PoolClosed | WorkerCrashed => error.to_string(),
            PoolTimedOut => "no connection was made in time".to_owned(),
            // 08: connection; 57P: the server stops or starts; 53300: it has no connection left; 28: it does not let this user in; 25P03:
            // it has ended one that did nothing in a change; 57014: a statement took too long.
            other => match other.as_database_error().and_then(|error| error.code()) {
                Some(code) if code == "08P01" && error.to_string().contains("startup parameter") => {
                    return sqlx::Error::AnyDriverError(Box::new(Self::Pooled(error.to_string())));
                }
                Some(code) if code == "53300" => format!(
                    "all its connections are in use ({error}). Each node uses up to `node.connections`, and each command 2: raise \
                     max_connections there, or lower `node.connections` here"
                ),
                Some(code) if code.starts_with("28") => format!(
                    "it does not let nestd in ({error}). The password stands in `folders.ledger_password_file`, which is read again for \
                     each new connection"
                ),
                Some(code) if code.starts_with("08") || code.starts_with("57P") => error.to_string(),
                Some(code) if ["25P03", "57014"].contains(&&*code) => error.to_string(),
                Some(code) if code == LOCK_TIMEOUT => {
                    let holder =
                        "another connection, which keeps a table locked (`pg_locks` in the database says which)"
                            .to_owned();
                    return sqlx::Error::AnyDriverError(Box::new(Self::ChangesWait { holder }));
                }
                _ => return error,
            },
        };
        sqlx::Error::AnyDriverError(Box::new(Self::Unreachable(what)))
    }

    /// Whether a lock was not free in time.
    pub(crate) fn is_lock_timeout(error: &sqlx::Error) -> bool {
        error.as_database_error().and_then(|error| error.code()).is_some_and(|code| code == LOCK_TIMEOUT)
    }
}
