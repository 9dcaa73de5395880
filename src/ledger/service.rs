//! Which daemon serves a ledger. A file is served by whoever holds the lock beside it, a database on a server by
//! whoever holds its lease.

use std::time::Duration;

/// A daemon that wants to serve a ledger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServingNode {
    /// Its server and its state folder. One daemon alone can have these two, so that it takes its own lease again at once.
    pub owner: String,
    /// How long it may serve without a renewal.
    pub lease: Duration,
}

/// Whether a daemon may act on what its ledger says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ServiceState {
    /// It serves the ledger.
    Held,
    /// It cannot know for now, and takes and publishes nothing until it does.
    Unsure {
        /// Why.
        why: String,
    },
    /// Another daemon serves the ledger.
    TakenOver,
}
