//! The age of a lease renewal, by two clocks that nobody can set: the monotonic clock stops while the machine sleeps,
//! the clock since boot does not. The larger age counts.
//!
//! `NESTD_TEST_HURRY` divides the times of a lease, so that tests need not wait. It is for tests only.

use std::{sync::OnceLock, time::Duration};

use rustix::time::{ClockId, clock_gettime};

/// Interval of the renewals.
const RENEWAL_INTERVAL: Duration = Duration::from_secs(4);
/// A lease that was not renewed for this long is no longer valid.
const LEASE_DURATION: Duration = Duration::from_secs(10);
/// A daemon on another server whose number has not changed for this long is dead.
const TAKEOVER_DELAY: Duration = Duration::from_secs(15);

/// A daemon that does not renew its right to a ledger on a server for this long has lost it.
const LEDGER_LEASE: Duration = Duration::from_secs(30);

/// A daemon that does not renew its right to a ledger on a server for this long has lost it.
pub fn ledger_lease() -> Duration {
    LEDGER_LEASE / test_speedup()
}

/// Interval of the renewals.
pub fn renewal_interval() -> Duration {
    RENEWAL_INTERVAL / test_speedup()
}

/// A daemon on another server whose number has not changed for this long is dead.
pub fn takeover_delay() -> Duration {
    TAKEOVER_DELAY / test_speedup()
}

fn test_speedup() -> u32 {
    static SPEEDUP: OnceLock<u32> = OnceLock::new();
    let asked = || std::env::var("NESTD_TEST_HURRY").ok()?.parse().ok().filter(|&times| times > 0);
    *SPEEDUP.get_or_init(|| asked().unwrap_or(1))
}

/// A moment, by both clocks.
#[derive(Debug, Clone, Copy)]
pub struct LeaseTimestamp {
    monotonic: Duration,
    since_boot: Duration,
}

impl LeaseTimestamp {
    /// The current moment.
    pub fn now() -> Self {
        Self { monotonic: read_clock(ClockId::Monotonic), since_boot: read_clock(ClockId::Boottime) }
    }

    /// Whether a lease renewed at this moment is still valid.
    pub fn is_valid(self) -> bool {
        self.lease_age() < LEASE_DURATION / test_speedup()
    }

    /// A moment that is no longer valid.
    #[cfg(test)]
    pub fn long_ago() -> Self {
        Self { monotonic: Duration::ZERO, since_boot: Duration::ZERO }
    }

    fn lease_age(self) -> Duration {
        let now = Self::now();
        now.monotonic.saturating_sub(self.monotonic).max(now.since_boot.saturating_sub(self.since_boot))
    }
}

fn read_clock(clock: ClockId) -> Duration {
    let now = clock_gettime(clock);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec.unsigned_abs() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_counts_until_either_clock_says_that_it_is_old() {
        let now = LeaseTimestamp::now();
        assert!(now.is_valid());
        // As after a suspend: only the clock since boot continued.
        assert!(!LeaseTimestamp { since_boot: now.since_boot.saturating_sub(LEASE_DURATION), ..now }.is_valid());
        assert!(!LeaseTimestamp { monotonic: now.monotonic.saturating_sub(LEASE_DURATION), ..now }.is_valid());
    }
}
