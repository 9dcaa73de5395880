//! The wall clock may be set while parts wait. What is measured in durations (how long a part has waited) must not notice;
//! what is said in dates (due dates, times of day) waits until the new time has stood for a while; and nothing is deleted
//! by a clock that was just set.

use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};

/// A smaller difference between the clocks is their drift.
pub(super) const JUMP: SignedDuration = SignedDuration::from_secs(30);
/// Dates are believed again when the clock has stood so long; who set it wrong sets it right within this time.
const DATES_AFTER: Duration = Duration::from_secs(300);
/// Retention is believed again after so long.
const RETENTION_AFTER: Duration = Duration::from_secs(3600);
/// The wall clock, and the time since the machine started (suspended time included), which nobody can set.
pub type Reader = Box<dyn Fn() -> (Timestamp, Duration) + Send>;

/// Notices when the wall clock is set.
pub struct Clock {
    read: Reader,
    last: (Timestamp, Duration),
    /// When it was set last, as far as this process knows.
    set_at: Option<Instant>,
}

impl Clock {
    /// The clocks of this machine.
    pub fn of_this_machine() -> Self {
        Self::reading(Box::new(|| {
            let up = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
            let (secs, nanos) = (u64::try_from(up.tv_sec).unwrap_or(0), u32::try_from(up.tv_nsec).unwrap_or(0));
            (Timestamp::now(), Duration::new(secs, nanos))
        }))
    }

    /// Clocks of a test's own.
    pub fn reading(read: Reader) -> Self {
        let last = read();
        Self { read, last, set_at: None }
    }

    /// By how much the clock was set since the last look, if it was.
    pub fn look(&mut self) -> Option<SignedDuration> {
        let now = (self.read)();
        let by_wall = now.0.duration_since(self.last.0);
        let by_nature = SignedDuration::try_from(now.1.saturating_sub(self.last.1)).unwrap_or(SignedDuration::ZERO);
        self.last = now;
        let jump = by_wall.saturating_sub(by_nature);
        let is_set = jump.abs() >= JUMP;
        if is_set {
            self.distrust();
        }
        is_set.then_some(jump)
    }

    /// The clock may be wrong: dates and retention wait.
    pub fn distrust(&mut self) {
        self.set_at = Some(Instant::now());
    }

    /// Whether dates may be acted on.
    pub fn knows_the_date(&self) -> bool {
        self.set_at.is_none_or(|at| at.elapsed() >= DATES_AFTER)
    }

    /// Whether what is past its retention may be deleted.
    pub fn may_delete(&self) -> bool {
        self.set_at.is_none_or(|at| at.elapsed() >= RETENTION_AFTER)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// Clocks that a test turns by hand: wall seconds, seconds since the start of the machine.
    fn by_hand() -> (Arc<Mutex<(i64, u64)>>, Clock) {
        let hands = Arc::new(Mutex::new((1_800_000_000, 1000)));
        let read = hands.clone();
        let clock = Clock::reading(Box::new(move || {
            let (wall, up) = *read.lock().unwrap();
            (Timestamp::from_second(wall).unwrap(), Duration::from_secs(up))
        }));
        (hands, clock)
    }

    fn turn(hands: &Mutex<(i64, u64)>, wall: i64, up: u64) {
        let mut hands = hands.lock().unwrap();
        *hands = (hands.0 + wall, hands.1 + up);
    }

    #[test]
    fn time_that_passes_and_a_suspended_machine_are_no_jump() {
        let (hands, mut clock) = by_hand();
        for (wall, up) in [(1, 1), (0, 0), (86_400, 86_400), (11, 10), (10, 11)] {
            turn(&hands, wall, up);
            assert_eq!(clock.look(), None);
        }
        assert!(clock.knows_the_date() && clock.may_delete());
    }

    #[test]
    fn a_clock_that_is_set_back_or_forward_is_noticed_once_and_its_dates_wait() {
        for jump in [-86_400, 86_400, -60, 60] {
            let (hands, mut clock) = by_hand();
            turn(&hands, jump + 2, 2);
            assert_eq!(clock.look(), Some(SignedDuration::from_secs(jump)));
            assert!(!clock.knows_the_date() && !clock.may_delete());
            turn(&hands, 2, 2);
            assert_eq!(clock.look(), None);
        }
    }

    #[test]
    fn dates_are_believed_again_after_a_while_and_retention_later() {
        let (_, mut clock) = by_hand();
        clock.set_at = Instant::now().checked_sub(DATES_AFTER);
        assert!(clock.knows_the_date() && !clock.may_delete());
        clock.set_at = Instant::now().checked_sub(RETENTION_AFTER);
        assert!(clock.may_delete());
    }
}
