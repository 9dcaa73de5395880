//! What a process knows of its own lease. The rules are pure, so that all interleavings of several nodes can be tried.
//!
//! The database counts the changes of each owner, in the same transactions. A count below what the owner knows to be committed says that
//! the database is an older one: a standby that took its place without the last changes, or a backup.

use std::time::Duration;

/// A lease as its owner sees it. Times are of a clock that nobody sets and that runs while the machine sleeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LeaseWatch {
    epoch: i64,
    /// Until when its owner may act; `None` = never again.
    until: Option<Duration>,
    /// Number of the last change that is known to be committed.
    committed: i64,
    /// Whether the database has lost changes.
    is_behind: bool,
}

/// Epoch of a lease and number of its owner's last change, as the database has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LeaseRecord {
    /// Epoch.
    pub epoch: i64,
    /// Number of the last change.
    pub changes: i64,
}

impl LeaseWatch {
    /// A lease that was granted upon a request that was sent at `sent_at`. The database grants it later than that, so
    /// that it ends there later than here.
    pub fn granted(granted: LeaseRecord, sent_at: Duration, lease: Duration) -> Self {
        let LeaseRecord { epoch, changes } = granted;
        Self { epoch, until: Some(sent_at + lease), committed: changes, is_behind: false }
    }

    /// A change was committed.
    pub fn confirm_change(&mut self, number: i64) {
        self.committed = self.committed.max(number);
    }

    /// Number of the last change that is known to be committed.
    pub fn committed(self) -> i64 {
        self.committed
    }

    /// Compares the lease with what the database has of it. `committed` = what was known to be committed when the database was asked.
    /// Returns whether the lease is still the own one, and the database has all changes.
    pub fn compare(&mut self, found: Option<LeaseRecord>, committed: i64) -> bool {
        match found {
            Some(found) if found.epoch > self.epoch => self.until = None,
            Some(found) if found.epoch == self.epoch && found.changes >= committed => return true,
            _ => (self.until, self.is_behind) = (None, true),
        }
        false
    }

    /// Whether the database has lost changes of this process.
    pub fn is_behind(self) -> bool {
        self.is_behind
    }

    /// The epoch of the lease.
    pub fn epoch(self) -> i64 {
        self.epoch
    }

    /// The lease was renewed upon a request that was sent at `sent_at`, perhaps after it had lapsed.
    pub fn renew(&mut self, sent_at: Duration, lease: Duration) {
        self.until = self.until.map(|until| until.max(sent_at + lease));
    }

    /// Whether the lease is the own one no more. A request without an answer says nothing of this kind.
    pub fn is_lost(self) -> bool {
        self.until.is_none()
    }

    /// Whether the owner may act now.
    pub fn may_act(self, now: Duration) -> bool {
        self.until.is_some_and(|until| now < until)
    }
}
