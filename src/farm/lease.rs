//! How old a look at a folder is, by clocks that cannot lie: the monotonic one stands still while the machine sleeps, the one
//! since boot goes on. The older age counts.
//!
//! `NESTD_TEST_HURRY` divides the times of a lease, so that tests need not wait for it; for nothing else.

use std::{sync::OnceLock, time::Duration};

use rustix::time::{ClockId, clock_gettime};

/// Between two beats.
const BEAT_EVERY: Duration = Duration::from_secs(4);
/// A look at a folder that is older proves nothing any more.
const HOLDS_FOR: Duration = Duration::from_secs(10);
/// A number of a daemon on another server that has not moved for so long belongs to nobody.
const DEAD_AFTER: Duration = Duration::from_secs(15);

/// Between two beats.
pub fn beat_every() -> Duration {
    BEAT_EVERY / hurry()
}

/// A number of a daemon on another server that has not moved for so long belongs to nobody.
pub fn dead_after() -> Duration {
    DEAD_AFTER / hurry()
}

fn hurry() -> u32 {
    static HURRY: OnceLock<u32> = OnceLock::new();
    let asked = || std::env::var("NESTD_TEST_HURRY").ok()?.parse().ok().filter(|&times| times > 0);
    *HURRY.get_or_init(|| asked().unwrap_or(1))
}

/// A moment, by both clocks.
#[derive(Debug, Clone, Copy)]
pub struct Stamp {
    monotonic: Duration,
    since_boot: Duration,
}

impl Stamp {
    /// Now.
    pub fn now() -> Self {
        Self { monotonic: read(ClockId::Monotonic), since_boot: read(ClockId::Boottime) }
    }

    /// Whether a look at this moment still counts.
    pub fn holds(self) -> bool {
        self.age() < HOLDS_FOR / hurry()
    }

    /// One that proves nothing any more.
    #[cfg(test)]
    pub fn long_ago() -> Self {
        Self { monotonic: Duration::ZERO, since_boot: Duration::ZERO }
    }

    fn age(self) -> Duration {
        let now = Self::now();
        now.monotonic.saturating_sub(self.monotonic).max(now.since_boot.saturating_sub(self.since_boot))
    }
}

fn read(clock: ClockId) -> Duration {
    let now = clock_gettime(clock);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec.unsigned_abs() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_counts_until_either_clock_says_that_it_is_old() {
        let now = Stamp::now();
        assert!(now.holds());
        // As after a suspend: only the clock since boot went on.
        assert!(!Stamp { since_boot: now.since_boot.saturating_sub(HOLDS_FOR), ..now }.holds());
        assert!(!Stamp { monotonic: now.monotonic.saturating_sub(HOLDS_FOR), ..now }.holds());
    }
}
