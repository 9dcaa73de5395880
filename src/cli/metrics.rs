//! `nestd metrics`: the farm's numbers as Prometheus reads them, also while no daemon runs.

use anyhow::Result;

use super::{Common, Exit, reach::look_at_ledger, table::say};
use crate::metrics::Metrics;

/// Runs the command.
pub fn run(common: &Common) -> Result<Exit> {
    let text = look_at_ledger(common, async |settings, ledger| Metrics::default().text(ledger, settings).await)?;
    say(&text)?;
    Ok(Exit::Success)
}
