//! The wall clock may be set while parts wait. Durations (how long a part has waited) must not change; dates (due
//! dates, times of day) are not acted on until the new time has lasted for a while; and nothing is deleted soon after
//! the clock was set.

use std::time::{Duration, Instant};

use jiff::SignedDuration;

use super::time_source::{ClockReading, TimeSource};

/// Smaller differences between the clocks are drift.
pub(crate) const CLOCK_JUMP: SignedDuration = SignedDuration::from_secs(30);
/// Dates are trusted again when the clock has not been set for this long; a wrong setting is usually corrected within
/// this time.
const TRUST_DATES_AFTER: Duration = Duration::from_secs(300);
/// Retention is trusted again after this time.
const TRUST_RETENTION_AFTER: Duration = Duration::from_secs(3600);

/// Notices when the wall clock is set.
pub struct WallClockMonitor {
    time: TimeSource,
    /// When the clock was last set; `None` = never, as known to this process.
    set_at: Option<Instant>,
}

/// The wall clock was set.
#[derive(Debug, Clone, Copy)]
pub struct ClockJump {
    /// By how much.
    pub by: SignedDuration,
    /// What the date went by before.
    before: ClockReading,
}

impl WallClockMonitor {
    /// Looks at these clocks. They are right at the start.
    pub fn with_reader(time: TimeSource) -> Self {
        time.adopt(time.read_clocks());
        Self { time, set_at: None }
    }

    /// Whether the clock was set since the last call. From now on the date is that of the clock.
    pub fn detect_jump(&mut self) -> Option<ClockJump> {
        let now = self.time.read_clocks();
        let by = self.time.deviation(&now);
        let before = self.time.adopt(now);
        let is_set = by.abs() >= CLOCK_JUMP;
        if is_set {
            self.mark_untrusted();
        }
        is_set.then_some(ClockJump { by, before })
    }

    /// The ages of the parts could not be adjusted to a clock that was set: the date goes on as before, and the next look finds it set
    /// again.
    pub fn retract(&mut self, jump: ClockJump) {
        self.time.adopt(jump.before);
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
            assert!(clock.detect_jump().is_none());
        }
        assert!(clock.is_date_trusted() && clock.is_retention_trusted());
    }

    #[test]
    fn a_clock_that_is_set_back_or_forward_is_noticed_once_and_its_dates_wait() {
        for jump in [-86_400, 86_400, -60, 60] {
            let (hands, mut clock) = by_hand();
            hands.pass(Duration::from_secs(2));
            hands.set_wall_clock_by(SignedDuration::from_secs(jump));
            assert_eq!(clock.detect_jump().unwrap().by, SignedDuration::from_secs(jump));
            assert!(!clock.is_date_trusted() && !clock.is_retention_trusted());
            hands.pass(Duration::from_secs(2));
            assert!(clock.detect_jump().is_none());
        }
    }

    #[test]
    fn the_date_goes_on_as_before_until_a_set_clock_is_noticed_and_after_it_was_retracted() {
        let (hands, mut clock) = by_hand();
        let (time, day) = (clock.time.clone(), SignedDuration::from_hours(24));
        let began = time.date();
        hands.pass(Duration::from_secs(2));
        hands.set_wall_clock_by(day);
        assert_eq!(time.date().duration_since(began), SignedDuration::from_secs(2));
        let jump = clock.detect_jump().unwrap();
        assert_eq!(time.date().duration_since(began), day + SignedDuration::from_secs(2));
        clock.retract(jump);
        hands.pass(Duration::from_secs(3));
        assert_eq!(time.date().duration_since(began), SignedDuration::from_secs(5));
        assert_eq!(clock.detect_jump().unwrap().by, day);
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
