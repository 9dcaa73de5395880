//! A search that ends the process (for example because the parts need more memory than there is) must not end it at
//! every start: each search is counted in the ledger before it starts, and a build whose searches never ended waits,
//! each time twice as long.

use std::time::Duration;

use anyhow::Result;
use jiff::SignedDuration;
use ledger::{BuildRow, Ledger, PartRow};

use super::desks::Shared;
use crate::alerts::{alert::AlertKind, alert_registry::AlertRegistry};

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

/// What follows from the searches for a build that had no end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CrashDecision {
    /// There were so few that they are taken for accidents.
    Begin,
    /// An alert names the parts. The wait, which was this long, is over.
    WarnAndBegin(Duration),
    /// An alert names the parts. The next search begins this long after a start.
    WarnAndWait(Duration),
}

/// Decides whether a search may begin after this many had no end. `running` = how long this process has run.
fn decide_after_crashes(begun: u32, running: SignedDuration) -> CrashDecision {
    let wait = wait_after_crashes(begun);
    match Duration::try_from(running) {
        _ if wait.is_zero() => CrashDecision::Begin,
        Ok(running) if running < wait => CrashDecision::WarnAndWait(wait),
        _ => CrashDecision::WarnAndBegin(wait),
    }
}

/// Whether a build must wait because too many of its searches had no end; an alert names its parts.
pub(crate) fn must_wait_after_crashes(
    shared: &mut Shared<'_>,
    build: &BuildRow,
    begun: u32,
    parts: &[&PartRow],
) -> bool {
    let decision = decide_after_crashes(begun, shared.date().duration_since(shared.lifecycle.started_at));
    let (CrashDecision::WarnAndBegin(wait) | CrashDecision::WarnAndWait(wait)) = decision else { return false };
    let about = format!("ended at build {}", build.id);
    shared.alerts.raise(AlertKind::NestingFails, &build.machine, &about, &describe_crashes(build, begun, wait, parts));
    matches!(decision, CrashDecision::WarnAndWait(_))
}

fn describe_crashes(build: &BuildRow, begun: u32, wait: Duration, parts: &[&PartRow]) -> String {
    let names: Vec<String> = parts.iter().take(10).map(|part| format!("{} ({})", part.id, part.name)).collect();
    let more =
        if parts.len() > names.len() { format!(" and {} more", parts.len() - names.len()) } else { String::new() };
    format!(
        "nestd ended {begun} times during a search for build {}: the next search begins {} s after a start. \
         Its parts are {}{more}; \
         `nestd cancel PART` takes one out",
        build.id,
        wait.as_secs(),
        names.join(", ")
    )
}

/// A search for a build has ended, with whatever result, and nestd is still running.
pub(crate) async fn record_search_end(ledger: &Ledger, alerts: &mut AlertRegistry, build: &BuildRow) -> Result<()> {
    alerts.clear(AlertKind::NestingFails, &build.machine, &format!("ended at build {}", build.id));
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

    #[test]
    fn a_build_waits_after_each_start_until_its_wait_is_over() {
        let secs = SignedDuration::from_secs;
        assert_eq!(decide_after_crashes(3, secs(0)), CrashDecision::Begin);
        assert_eq!(decide_after_crashes(5, secs(9)), CrashDecision::WarnAndWait(Duration::from_secs(10)));
        assert_eq!(decide_after_crashes(5, secs(10)), CrashDecision::WarnAndBegin(Duration::from_secs(10)));
        // The clock was set back: it cannot be known how long this process has run.
        assert_eq!(decide_after_crashes(5, secs(-1)), CrashDecision::WarnAndBegin(Duration::from_secs(10)));
    }
}
