//! A search that ends the process (for example because the parts need more memory than there is) must not end it at
//! every start: each search is counted in the ledger before it starts, and a build whose searches never ended waits,
//! each time twice as long.

use std::time::Duration;

use anyhow::Result;

use super::{alert::AlertKind, alert_registry::AlertRegistry, farm::Farm};
use crate::ledger::Ledger;
use crate::ledger::{BuildRow, PartRow};

/// This many searches without an end are taken for accidents: kills, power cuts.
const TOLERATED_CRASHES: u32 = 3;
/// Wait after the start for one more search without an end.
const FIRST_WAIT: Duration = Duration::from_secs(5);
/// Maximum wait.
const LONGEST_WAIT: Duration = Duration::from_secs(600);

/// How long after the start a search may begin if this many searches had no end.
fn wait_after_crashes(begun: u32) -> Duration {
    match begun.saturating_sub(TOLERATED_CRASHES) {
        0 => Duration::ZERO,
        more => FIRST_WAIT.saturating_mul(1 << (more - 1).min(16)).min(LONGEST_WAIT),
    }
}

/// Whether a build must wait because too many of its searches had no end; an alert names its parts.
pub(super) fn must_wait_after_crashes(farm: &mut Farm, build: &BuildRow, begun: u32, parts: &[&PartRow]) -> bool {
    let wait = wait_after_crashes(begun);
    if wait.is_zero() {
        return false;
    }
    let names: Vec<String> = parts.iter().take(10).map(|part| format!("{} ({})", part.id, part.name)).collect();
    let more =
        if parts.len() > names.len() { format!(" and {} more", parts.len() - names.len()) } else { String::new() };
    let detail = format!(
        "nestd ended {begun} times during a search for build {}: the next search begins {} s after a start. \
         Its parts are {}{more}; \
         `nestd cancel PART` takes one out",
        build.id,
        wait.as_secs(),
        names.join(", ")
    );
    farm.alerts.raise(AlertKind::NestingFails, &build.profile, &format!("ended at build {}", build.id), &detail);
    let running = farm.date().duration_since(farm.lifecycle.started_at);
    Duration::try_from(running).is_ok_and(|running| running < wait)
}

/// A search for a build has ended, with whatever result, and nestd is still running.
pub(super) async fn record_search_end(ledger: &Ledger, alerts: &mut AlertRegistry, build: &BuildRow) -> Result<()> {
    alerts.clear(AlertKind::NestingFails, &build.profile, &format!("ended at build {}", build.id));
    Ok(ledger.end_search(build.id).await?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_that_ends_the_process_waits_longer_each_time_and_kills_now_and_then_cost_nothing() {
        let waits = [0, 3, 4, 5, 6, 20].map(|begun| wait_after_crashes(begun).as_secs());
        assert_eq!(waits, [0, 0, 5, 10, 20, 600]);
    }
}
