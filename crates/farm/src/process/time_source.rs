//! The source of the farm's time: the clocks of this machine, or clocks that a test controls.

use std::{
    fmt,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use jiff::{SignedDuration, Timestamp};

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

/// Reads the clocks. A clone is cheap, reads the same clocks, and tells the same date.
///
/// The date goes on from the last reading that was looked at ([`TimeSource::adopt`]), by the clock that only passes. So nobody acts on
/// a clock that was set before the ages of the parts were adjusted to it, and nothing is recorded by it.
#[derive(Clone)]
pub struct TimeSource {
    read: Arc<dyn Fn() -> ClockReading + Send + Sync>,
    adopted: Arc<Mutex<ClockReading>>,
}

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

impl ClockReading {
    /// The date at a later reading, if the wall clock is not set in between.
    fn date_at(&self, later: &Self) -> Timestamp {
        self.date + later.since_boot.saturating_sub(self.since_boot)
    }
}

impl TimeSource {
    /// Uses the clocks of this machine.
    pub fn of_this_machine() -> Self {
        Self::reading(|| {
            let up = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
            let (secs, nanos) = (u64::try_from(up.tv_sec).unwrap_or(0), u32::try_from(up.tv_nsec).unwrap_or(0));
            ClockReading { date: Timestamp::now(), instant: Instant::now(), since_boot: Duration::new(secs, nanos) }
        })
    }

    fn reading(read: impl Fn() -> ClockReading + Send + Sync + 'static) -> Self {
        let adopted = Arc::new(Mutex::new(read()));
        Self { read: Arc::new(read), adopted }
    }

    /// Reads all clocks at once.
    pub fn read_clocks(&self) -> ClockReading {
        (self.read)()
    }

    /// The date and time of day.
    pub fn date(&self) -> Timestamp {
        self.adopted_reading().date_at(&self.read_clocks())
    }

    /// By how much the wall clock differs at this reading from the date that is told.
    pub fn deviation(&self, reading: &ClockReading) -> SignedDuration {
        reading.date.duration_since(self.adopted_reading().date_at(reading))
    }

    /// From now on the date is that of this reading. Returns the reading that it went by before.
    pub fn adopt(&self, reading: ClockReading) -> ClockReading {
        std::mem::replace(&mut *self.adopted.lock().unwrap_or_else(PoisonError::into_inner), reading)
    }

    fn adopted_reading(&self) -> ClockReading {
        *self.adopted.lock().unwrap_or_else(PoisonError::into_inner)
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
pub struct ClockHands(Arc<Mutex<ClockReading>>);

#[cfg(test)]
impl ClockHands {
    /// Returns clocks that show the time of their creation, and the time source that reads them.
    pub fn make() -> (Self, TimeSource) {
        let hands = Self(Arc::new(Mutex::new(TimeSource::of_this_machine().read_clocks())));
        let read = hands.clone();
        (hands, TimeSource::reading(move || *read.0.lock().expect("nobody panics while he holds it")))
    }

    /// Advances all clocks.
    pub fn pass(&self, time: Duration) {
        let mut now = self.0.lock().expect("nobody panics while he holds it");
        now.instant += time;
        now.since_boot += time;
        now.date += time;
    }

    /// Changes only the wall clock, as if somebody set it.
    pub fn set_wall_clock_by(&self, jump: SignedDuration) {
        self.0.lock().expect("nobody panics while he holds it").date += jump;
    }
}
