//! `nestd metrics`: prints the farm's metrics in the Prometheus format, even while no daemon runs.

use anyhow::Result;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{farm_context::with_ledger_to_read, table::print_as_is},
    },
    metrics::MetricsExporter,
};

/// Runs the command.
pub fn run(common: &CommonArgs) -> Result<CommandExit> {
    let text = with_ledger_to_read(common, async |settings, ledger| {
        MetricsExporter::default().render_text(ledger, settings).await
    })?;
    print_as_is(&text)?;
    Ok(CommandExit::Success)
}
