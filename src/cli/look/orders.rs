//! `nestd orders`: orders and what became of their copies.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{OrderQuery, OrderState};

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::with_ledger_to_read,
            table::{TextTable, print_json, print_text},
        },
    },
    farm::{DatedOrder, read_plans},
    tables::{ORDER_COLUMNS, TimeView},
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct OrdersArgs {
    /// Only orders with this text anywhere in their names, in any case
    #[arg(long, value_name = "TEXT")]
    find: Option<String>,
    /// Orders in every state, not only open ones
    #[arg(long)]
    all: bool,
    /// Maximum number of orders
    #[arg(long, default_value_t = 50, value_name = "N")]
    limit: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &OrdersArgs) -> Result<CommandExit> {
    let state = (!args.all && args.find.is_none()).then_some(OrderState::Open);
    let query = OrderQuery { name: args.find.clone(), state, limit: args.limit };
    let (sheets, view) = with_ledger_to_read(common, async |settings, ledger| {
        let plans = read_plans(ledger, settings.profiles.values(), Timestamp::now()).await?;
        let orders = DatedOrder::of_plans(ledger.order_summaries(&query).await?, &plans);
        Ok((orders, TimeView::current(&settings.time_zone)))
    })?;
    if args.json {
        return print_json(&sheets).map(|()| CommandExit::Success);
    }
    match sheets.is_empty() {
        true => print_text("No such orders.")?,
        false => print_text(&TextTable::of(ORDER_COLUMNS, &sheets, &view).to_string())?,
    }
    Ok(CommandExit::Success)
}
