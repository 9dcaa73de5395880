//! `nestd nodes`: the daemons that share the ledger.

use anyhow::Result;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::with_ledger_to_read,
            table::{TextTable, print_json, print_text},
            terminal::output_columns,
        },
    },
    tables::{NODE_COLUMNS, TimeView, list_farm_nodes},
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct NodesArgs {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &NodesArgs) -> Result<CommandExit> {
    let (nodes, view) = with_ledger_to_read(common, async |settings, ledger| {
        Ok((list_farm_nodes(ledger).await?, TimeView::current(&settings.time_zone)))
    })?;
    if args.json {
        return print_json(&nodes).map(|()| CommandExit::Success);
    }
    match nodes.is_empty() {
        true => print_text("No daemon runs.")?,
        false => print_text(&TextTable::of(NODE_COLUMNS, &nodes, &view).fit_columns(output_columns(false)))?,
    }
    Ok(CommandExit::Success)
}
