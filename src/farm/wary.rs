//! Parts on which a search ends the process (they take more memory than there is) must not end it at every start: each search
//! is counted in the ledger before it is begun, and one that has never come to its end waits, each time twice as long.

use std::time::Duration;

use anyhow::Result;

use super::{attention::Attention, farm::Farm};
use crate::ledger::{BuildRow, PartRow};

/// So many searches without an end are an accident: kills, power cuts.
const ACCIDENTS: u32 = 3;
/// After one more, the next is begun so long after the start.
const FIRST_WAIT: Duration = Duration::from_secs(5);
/// After many.
const LONGEST_WAIT: Duration = Duration::from_secs(600);

/// How long after the start a search is begun that was begun so often without an end.
fn wait_after(begun: u32) -> Duration {
    match begun.saturating_sub(ACCIDENTS) {
        0 => Duration::ZERO,
        more => FIRST_WAIT.saturating_mul(1 << (more - 1).min(16)).min(LONGEST_WAIT),
    }
}

impl Farm {
    /// Whether a build was begun so often without an end that it waits now; people are told which parts are in it.
    pub(super) fn is_wary(&mut self, build: &BuildRow, begun: u32, parts: &[&PartRow]) -> bool {
        let wait = wait_after(begun);
        if wait.is_zero() {
            return false;
        }
        let names: Vec<String> = parts.iter().take(10).map(|part| format!("{} ({})", part.id, part.name)).collect();
        let more =
            if parts.len() > names.len() { format!(" and {} more", parts.len() - names.len()) } else { String::new() };
        let detail = format!(
            "nestd ended {begun} times while it searched for build {}: it begins again {} s after a start. Its parts are {}{more}; \
             `nestd cancel PART` takes one out",
            build.id,
            wait.as_secs(),
            names.join(", ")
        );
        self.notices.raise(Attention::NestingFails, &build.profile, &format!("ended at build {}", build.id), &detail);
        let running = self.date().duration_since(self.life.started_at);
        Duration::try_from(running).is_ok_and(|running| running < wait)
    }

    /// A search for a build came to its end, whatever it found; nestd is still there.
    pub(super) async fn has_ended_well(&mut self, build: &BuildRow) -> Result<()> {
        self.notices.clear(Attention::NestingFails, &build.profile, &format!("ended at build {}", build.id));
        Ok(self.ledger.end_search(build.id).await?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_that_ends_the_process_waits_longer_each_time_and_kills_now_and_then_cost_nothing() {
        let waits = [0, 3, 4, 5, 6, 20].map(|begun| wait_after(begun).as_secs());
        assert_eq!(waits, [0, 0, 5, 10, 20, 600]);
    }
}
