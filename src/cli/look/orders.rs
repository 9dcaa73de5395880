//! `nestd orders`: orders and what became of their copies.

use anyhow::Result;
use farm::{DatedOrder, read_plans};
use jiff::Timestamp;
use ledger::OrderQuery;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::with_ledger_to_read,
            table::{TextTable, print_fitted, print_json, print_text},
            terminal::output_columns,
        },
    },
    tables::{LEAST_ORDER_COLUMNS, ORDER_COLUMNS, TimeView},
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct OrdersArgs {
    /// Only orders with this text anywhere in their names, in any case
    #[arg(long, value_name = "TEXT")]
    find: Option<String>,
    /// Only orders of customers with this text anywhere in their names, in any case
    #[arg(long, value_name = "TEXT")]
    customer: Option<String>,
    /// Also orders that are done or closed
    #[arg(long)]
    all: bool,
    /// Maximum number of orders
    #[arg(long, default_value_t = 50, value_name = "N")]
    limit: u32,
    /// Print all columns, however wide the terminal is
    #[arg(long)]
    wide: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &OrdersArgs) -> Result<CommandExit> {
    let is_filtered = args.find.is_some() || args.customer.is_some();
    let (name, customer) = (args.find.clone(), args.customer.clone());
    let query =
        OrderQuery { name, customer, is_asking: !args.all && !is_filtered, limit: args.limit, ..OrderQuery::default() };
    let (sheets, view) = with_ledger_to_read(common, async |settings, ledger| {
        let now = Timestamp::now();
        let plans = read_plans(ledger, settings.profiles.values(), now).await?;
        let orders = ledger.order_summaries(&query).await?.into_iter();
        let orders: Vec<DatedOrder> = orders.map(|order| DatedOrder::of_plans(order, &plans, now)).collect();
        Ok((orders, TimeView::current(&settings.time_zone)))
    })?;
    if args.json {
        return print_json(&sheets).map(|()| CommandExit::Success);
    }
    match sheets.is_empty() {
        true => print_text("No such orders.")?,
        false => {
            let table = TextTable::of(ORDER_COLUMNS, &sheets, &view).wrapping(&["name", "customer", "copies", "done"]);
            print_fitted(&table.fit_essentials(output_columns(args.wide), LEAST_ORDER_COLUMNS), args.wide)?;
        }
    }
    Ok(CommandExit::Success)
}
