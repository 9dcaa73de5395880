//! Which processes serve a ledger. A file is served by the one daemon that holds the lock beside it. A database on a server is shared by
//! nodes: daemons on different servers, of which each holds the lease of its name, and serves machines of its own.

use std::{fmt, time::Duration};

/// Who uses a ledger on a server without a right to serve it: that has a limited number of connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LedgerUser {
    /// A command.
    Command,
    /// The pages of a daemon, and what programs ask it.
    Pages,
    /// Metrics and messages of a daemon.
    Monitoring,
}

/// A right that one process has at a time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ServingRight {
    /// To be the node of this name.
    Node(String),
    /// To be the node of this name while its folders are compared with the ledger, which has lost changes.
    RepairedNode(String),
    /// To have the whole ledger alone: no node serves it meanwhile.
    WholeLedger,
}

/// How the lease of the right is named in the database.
impl fmt::Display for ServingRight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(name) | Self::RepairedNode(name) => write!(f, "node {name}"),
            Self::WholeLedger => f.write_str("ledger"),
        }
    }
}

/// A process that wants to serve a ledger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServingNode {
    /// What it serves.
    pub right: ServingRight,
    /// Its server and its state folder. One daemon alone can have these two, so that it takes its own lease again at once.
    pub owner: String,
    /// How long it may serve without a renewal.
    pub lease: Duration,
}

/// The farm that all nodes of a ledger on a server are. Its claims are those of whichever node serves the machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedFarm {
    /// Its number, made of the database that holds the ledger.
    pub id: String,
    /// The database, and its timeline: one that went on after a standby has taken its place is told from that.
    pub database: String,
}

/// Who serves a ledger on a server now, by its leases.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LiveRights {
    /// Names of the nodes, in order.
    pub nodes: Vec<String>,
    /// Whether a process has the whole ledger alone.
    pub is_whole: bool,
}

/// Whether a daemon may act on what its ledger says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ServiceState {
    /// It serves the ledger.
    Held,
    /// Another process holds the write lock of the ledger: nothing is taken and published until it lets go.
    Locked {
        /// Which one, in words.
        by: String,
    },
    /// It cannot know for now, and takes and publishes nothing until it does.
    Unsure {
        /// Why.
        why: String,
    },
    /// The ledger has lost changes of other nodes, and waits for their repair.
    RepairDue {
        /// Of which.
        nodes: String,
    },
    /// Another process has its right.
    TakenOver,
    /// The ledger has lost changes that this daemon had committed.
    Behind,
}
