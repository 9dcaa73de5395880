//! The wall clock may be set while parts wait. Durations (how long a part has waited) must not change; dates (due
//! dates, times of day) are not acted on until the new time has lasted for a while; and nothing is deleted soon after
//! the clock was set.

use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};

use super::time_source::{ClockReading, TimeSource};

/// Smaller differences between the clocks are drift.
pub(super) const CLOCK_JUMP: SignedDuration = SignedDuration::from_secs(30);
/// Dates are trusted again when the clock has not been set for this long; a wrong setting is usually corrected within
/// this time.
const TRUST_DATES_AFTER: Duration = Duration::from_secs(300);
/// Retention is trusted again after this time.
const TRUST_RETENTION_AFTER: Duration = Duration::from_secs(3600);

/// Detects when the wall clock is set.
pub struct WallClockMonitor {
    time: TimeSource,
    /// The wall clock, and the time since the machine started, at the last look.
    last_reading: (Timestamp, Duration),
    /// When the clock was last set; `None` = never, as known to this process.
    set_at: Option<Instant>,
}

impl WallClockMonitor {
    /// Looks at these clocks.
    pub fn with_reader(time: TimeSource) -> Self {
        let now = time.read_clocks();
        Self { time, last_reading: (now.date, now.since_boot), set_at: None }
    }

    /// By how much the clock was set since the last call, if it was.
    pub fn detect_jump(&mut self) -> Option<SignedDuration> {
        let ClockReading { date, since_boot, .. } = self.time.read_clocks();
        let now = (date, since_boot);
        let by_wall = now.0.duration_since(self.last_reading.0);
        let by_nature =
            SignedDuration::try_from(now.1.saturating_sub(self.last_reading.1)).unwrap_or(SignedDuration::ZERO);
        self.last_reading = now;
        let jump = by_wall.saturating_sub(by_nature);
        let is_set = jump.abs() >= CLOCK_JUMP;
        if is_set {
            self.mark_untrusted();
        }
        is_set.then_some(jump)
    }

    /// The clock may be wrong: dates and retention wait.
    pub fn mark_untrusted(&mut self) {
        self.set_at = Some(self.time.instant());
    }

    /// Whether dates may be acted on.
    pub fn is_date_trusted(&self) -> bool {
        self.set_at.is_none_or(|at| self.time.passed_since(at) >= TRUST_DATES_AFTER)
    }

    /// Whether files past their retention may be deleted.
    pub fn is_retention_trusted(&self) -> bool {
        self.set_at.is_none_or(|at| self.time.passed_since(at) >= TRUST_RETENTION_AFTER)
    }
}

#[cfg(test)]
mod tests {
    use super::{super::time_source::ClockHands, *};

    fn by_hand() -> (ClockHands, WallClockMonitor) {
        let (hands, time) = ClockHands::make();
        (hands, WallClockMonitor::with_reader(time))
    }

    #[test]
    fn time_that_passes_and_a_suspended_machine_are_no_jump() {
        let (hands, mut clock) = by_hand();
        for (passed, drift) in [(1, 0), (0, 0), (86_400, 0), (10, 1), (11, -1)] {
            hands.pass(Duration::from_secs(passed));
            hands.set_wall_clock_by(SignedDuration::from_secs(drift));
            assert_eq!(clock.detect_jump(), None);
        }
        assert!(clock.is_date_trusted() && clock.is_retention_trusted());
    }

    #[test]
    fn a_clock_that_is_set_back_or_forward_is_noticed_once_and_its_dates_wait() {
        for jump in [-86_400, 86_400, -60, 60] {
            let (hands, mut clock) = by_hand();
            hands.pass(Duration::from_secs(2));
            hands.set_wall_clock_by(SignedDuration::from_secs(jump));
            assert_eq!(clock.detect_jump(), Some(SignedDuration::from_secs(jump)));
            assert!(!clock.is_date_trusted() && !clock.is_retention_trusted());
            hands.pass(Duration::from_secs(2));
            assert_eq!(clock.detect_jump(), None);
        }
    }

    #[test]
    fn dates_are_believed_again_after_a_while_and_retention_later() {
        let (hands, mut clock) = by_hand();
        clock.mark_untrusted();
        hands.pass(TRUST_DATES_AFTER);
        assert!(clock.is_date_trusted() && !clock.is_retention_trusted());
        hands.pass(TRUST_RETENTION_AFTER - TRUST_DATES_AFTER);
        assert!(clock.is_retention_trusted());
    }
}
