//! Takes in the ends of jobs, in the event loop and while the farm stops.

use std::time::Instant;

use jobs::LoopEvent;

use super::farm::Farm;
use crate::{alerts::alert::AlertKind, process::systemd};

/// Takes in one event of the loop. A halted farm ignores it.
pub(crate) async fn handle_event(farm: &mut Farm, event: LoopEvent<Farm>) {
    if farm.lifecycle.is_halted {
        return;
    }
    if let Err(failure) = event.apply_to(farm).await {
        farm.report_failure(AlertKind::StepFails, "", "taking in what a job has done", &failure);
    }
    farm.halt_if_asked();
}

/// Takes in the results of jobs until none runs, or until the deadline.
pub(crate) async fn wait_for_jobs(farm: &mut Farm, deadline: Instant) {
    while !farm.jobs.is_idle() {
        let left = deadline.saturating_duration_since(Instant::now());
        match tokio::time::timeout(left, farm.jobs.next_event()).await {
            Ok(Some(event)) => handle_event(farm, event).await,
            _ => break,
        }
        systemd::notify_watchdog();
    }
}
