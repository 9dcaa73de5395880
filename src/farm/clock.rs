//! The wall clock may be set while parts wait. What is measured in durations (how long a part has waited) must not notice;
//! what is said in dates (due dates, times of day) waits until the new time has stood for a while; and nothing is deleted
//! by a clock that was just set.

use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};

use super::time_source::{ClockReading, TimeSource};

/// A smaller difference between the clocks is their drift.
pub(super) const JUMP: SignedDuration = SignedDuration::from_secs(30);
/// Dates are believed again when the clock has stood so long; who set it wrong sets it right within this time.
const DATES_AFTER: Duration = Duration::from_secs(300);
/// Retention is believed again after so long.
const RETENTION_AFTER: Duration = Duration::from_secs(3600);

/// Notices when the wall clock is set.
pub struct Clock {
    time: TimeSource,
    /// The wall clock, and the time since the machine started, at the last look.
    last: (Timestamp, Duration),
    /// When it was set last, as far as this process knows.
    set_at: Option<Instant>,
}

impl Clock {
    /// Looks at these clocks.
    pub fn reading(time: TimeSource) -> Self {
        let now = time.read_clocks();
        Self { time, last: (now.date, now.since_boot), set_at: None }
    }

    /// By how much the clock was set since the last look, if it was.
    pub fn look(&mut self) -> Option<SignedDuration> {
        let ClockReading { date, since_boot, .. } = self.time.read_clocks();
        let now = (date, since_boot);
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
        self.set_at = Some(self.time.instant());
    }

    /// Whether dates may be acted on.
    pub fn knows_the_date(&self) -> bool {
        self.set_at.is_none_or(|at| self.time.passed_since(at) >= DATES_AFTER)
    }

    /// Whether what is past its retention may be deleted.
    pub fn may_delete(&self) -> bool {
        self.set_at.is_none_or(|at| self.time.passed_since(at) >= RETENTION_AFTER)
    }
}

#[cfg(test)]
mod tests {
    use super::{super::time_source::ClockHands, *};

    fn by_hand() -> (ClockHands, Clock) {
        let (hands, time) = ClockHands::make();
        (hands, Clock::reading(time))
    }

    #[test]
    fn time_that_passes_and_a_suspended_machine_are_no_jump() {
        let (hands, mut clock) = by_hand();
        for (passed, drift) in [(1, 0), (0, 0), (86_400, 0), (10, 1), (11, -1)] {
            hands.pass(Duration::from_secs(passed));
            hands.set_wall_clock_by(SignedDuration::from_secs(drift));
            assert_eq!(clock.look(), None);
        }
        assert!(clock.knows_the_date() && clock.may_delete());
    }

    #[test]
    fn a_clock_that_is_set_back_or_forward_is_noticed_once_and_its_dates_wait() {
        for jump in [-86_400, 86_400, -60, 60] {
            let (hands, mut clock) = by_hand();
            hands.pass(Duration::from_secs(2));
            hands.set_wall_clock_by(SignedDuration::from_secs(jump));
            assert_eq!(clock.look(), Some(SignedDuration::from_secs(jump)));
            assert!(!clock.knows_the_date() && !clock.may_delete());
            hands.pass(Duration::from_secs(2));
            assert_eq!(clock.look(), None);
        }
    }

    #[test]
    fn dates_are_believed_again_after_a_while_and_retention_later() {
        let (hands, mut clock) = by_hand();
        clock.distrust();
        hands.pass(DATES_AFTER);
        assert!(clock.knows_the_date() && !clock.may_delete());
        hands.pass(RETENTION_AFTER - DATES_AFTER);
        assert!(clock.may_delete());
    }
}
