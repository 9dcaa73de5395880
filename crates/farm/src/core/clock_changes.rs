//! Keeps the ages of parts when the wall clock is set, also while the farm did not run.

use anyhow::Result;
use jiff::SignedDuration;
use ledger::Ledger;
use tracing::warn;

use super::desks::Shared;
use crate::process::wall_clock::CLOCK_JUMP;

/// If the last event in the ledger is older than this at the start, the farm did not run for long or the clock is
/// wrong.
const STALE_LEDGER_AGE: SignedDuration = SignedDuration::from_hours(48);

/// Adjusts the ages of parts if the clock was set. Until they are adjusted, the farm's date goes on as if it had not been set.
pub(crate) async fn handle_clock_change(shared: &mut Shared<'_>) -> Result<()> {
    let Some(jump) = shared.schedule.clock.detect_jump() else { return Ok(()) };
    let kept = keep_part_ages(shared.ledger, jump.by).await;
    if kept.is_err() {
        shared.schedule.clock.retract(jump);
    }
    kept
}

/// At the start: a last event in the future means that the clock was set back meanwhile. If the last event is old,
/// the farm did not run for long or the clock is wrong.
pub(crate) async fn compare_clock_with_ledger(shared: &mut Shared<'_>) -> Result<()> {
    // On a server, the clock of another node may have written it.
    if shared.ledger.file().is_none() {
        return Ok(());
    }
    let Some(last) = shared.ledger.last_event_at().await? else { return Ok(()) };
    let since = shared.date().duration_since(last.0);
    if since > STALE_LEDGER_AGE {
        shared.schedule.clock.mark_untrusted();
    }
    if since < -CLOCK_JUMP {
        shared.schedule.clock.mark_untrusted();
        return keep_part_ages(shared.ledger, since).await;
    }
    Ok(())
}

async fn keep_part_ages(ledger: &Ledger, jump: SignedDuration) -> Result<()> {
    warn!("The clock was set by {jump:#}; how long parts have waited is kept, dates wait for five minutes.");
    Ok(ledger.shift_claim_times(jump).await?)
}
