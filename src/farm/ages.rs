//! The ages of parts are kept when the wall clock is set, also while the farm did not run.

use anyhow::Result;
use jiff::SignedDuration;
use tracing::warn;

use super::{clock::JUMP, farm::Farm};

/// A ledger whose last event is older than this at the start was asleep, or the clock is wrong.
const LONG_ASLEEP: SignedDuration = SignedDuration::from_hours(48);

impl Farm {
    /// Keeps the ages of parts when the clock was set.
    pub(super) async fn look_at_clock(&mut self) -> Result<()> {
        match self.schedule.clock.look() {
            Some(jump) => self.clock_was_set(jump).await,
            None => Ok(()),
        }
    }

    /// At the start: a last event in the future means that the clock was set back meanwhile; one long ago, that the farm
    /// slept or the clock is wrong.
    pub(super) async fn compare_clock_with_ledger(&mut self) -> Result<()> {
        let Some(last) = self.ledger.last_event_at().await? else { return Ok(()) };
        let since = self.date().duration_since(last.0);
        if since > LONG_ASLEEP {
            self.schedule.clock.distrust();
        }
        if since < -JUMP {
            self.schedule.clock.distrust();
            return self.clock_was_set(since).await;
        }
        Ok(())
    }

    async fn clock_was_set(&mut self, jump: SignedDuration) -> Result<()> {
        warn!("The clock was set by {jump:#}; how long parts have waited is kept, dates wait for five minutes.");
        Ok(self.ledger.keep_ages(jump).await?)
    }
}
