//! What a process knows of its own lease. The rules are pure, so that all interleavings of several nodes can be tried.

use std::time::Duration;

/// A lease as its owner sees it. Times are of a clock that nobody sets and that runs while the machine sleeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LeaseWatch {
    epoch: i64,
    /// Until when its owner may act; `None` = another node has the lease.
    until: Option<Duration>,
}

impl LeaseWatch {
    /// A lease that was granted upon a request that was sent at `sent_at`. The database grants it later than that, so
    /// that it ends there later than here.
    pub fn granted(epoch: i64, sent_at: Duration, lease: Duration) -> Self {
        Self { epoch, until: Some(sent_at + lease) }
    }

    /// The epoch of the lease.
    pub fn epoch(self) -> i64 {
        self.epoch
    }

    /// The lease was renewed upon a request that was sent at `sent_at`, perhaps after it had lapsed.
    pub fn renew(&mut self, sent_at: Duration, lease: Duration) {
        self.until = self.until.map(|until| until.max(sent_at + lease));
    }

    /// Another node has the lease. A request without an answer says nothing of this kind.
    pub fn lose(&mut self) {
        self.until = None;
    }

    /// Whether another node has the lease.
    pub fn is_lost(self) -> bool {
        self.until.is_none()
    }

    /// Whether the owner may act now.
    pub fn may_act(self, now: Duration) -> bool {
        self.until.is_some_and(|until| now < until)
    }
}
