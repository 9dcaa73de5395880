//! The source of the farm's time: the clocks of this machine, or clocks that a test controls.

use std::{
    fmt,
    sync::Arc,
    time::{Duration, Instant},
};

use jiff::Timestamp;

/// The readings of all clocks at one moment.
#[derive(Debug, Clone, Copy)]
pub struct ClockReading {
    /// The wall clock. People can set it.
    pub date: Timestamp,
    /// The monotonic clock. It never goes back.
    pub instant: Instant,
    /// Time since the machine started, including suspended time.
    pub since_boot: Duration,
}

/// Reads the clocks. A clone is cheap and reads the same clocks.
#[derive(Clone)]
pub struct TimeSource(Arc<dyn Fn() -> ClockReading + Send + Sync>);

impl Default for TimeSource {
    fn default() -> Self {
        Self::of_this_machine()
    }
}

impl fmt::Debug for TimeSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("TimeSource").field(&self.read_clocks()).finish()
    }
}

impl TimeSource {
    /// Uses the clocks of this machine.
    pub fn of_this_machine() -> Self {
        Self(Arc::new(|| {
            let up = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
            let (secs, nanos) = (u64::try_from(up.tv_sec).unwrap_or(0), u32::try_from(up.tv_nsec).unwrap_or(0));
            ClockReading { date: Timestamp::now(), instant: Instant::now(), since_boot: Duration::new(secs, nanos) }
        }))
    }

    /// Reads all clocks at once.
    pub fn read_clocks(&self) -> ClockReading {
        (self.0)()
    }

    /// The date and time of day.
    pub fn date(&self) -> Timestamp {
        self.read_clocks().date
    }

    /// The monotonic clock.
    pub fn instant(&self) -> Instant {
        self.read_clocks().instant
    }

    /// The time that has passed since a moment.
    pub fn passed_since(&self, moment: Instant) -> Duration {
        self.instant().saturating_duration_since(moment)
    }
}

/// Clocks that move only when a test advances them.
#[cfg(test)]
#[derive(Debug, Clone)]
pub struct ClockHands(Arc<std::sync::Mutex<ClockReading>>);

#[cfg(test)]
impl ClockHands {
    /// Returns clocks that show the time of their creation, and the time source that reads them.
    pub fn make() -> (Self, TimeSource) {
        let hands = Self(Arc::new(std::sync::Mutex::new(TimeSource::of_this_machine().read_clocks())));
        let read = hands.clone();
        (hands, TimeSource(Arc::new(move || *read.0.lock().expect("nobody panics while he holds it"))))
    }

    /// Advances all clocks.
    pub fn pass(&self, time: Duration) {
        let mut now = self.0.lock().expect("nobody panics while he holds it");
        now.instant += time;
        now.since_boot += time;
        now.date += time;
    }

    /// Changes only the wall clock, as if somebody set it.
    pub fn set_wall_clock_by(&self, jump: jiff::SignedDuration) {
        self.0.lock().expect("nobody panics while he holds it").date += jump;
    }
}
