//! The page that lists orders, the page of one order with its lines and builds, and both as JSON.

use std::sync::Arc;

use axum::{
    Form, Json,
    extract::{Path, Query, State},
    response::Response,
};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    command::{answer_page, check_form_key, send_commands},
    error::{HandlerError, HandlerResult},
    format::count,
    listing::table_of,
    page::html_page,
    query::{order_address, parse_field},
    request_user::RequestUser,
    state::DashboardState,
};
use crate::{
    ledger::{
        CommandArgument, CommandKind, NewCommand, OrderLine, OrderQuery, OrderState, OrderSummary, PartState,
        ReprintTarget,
    },
    tables::{BuiltCopies, GivenDate, ORDER_BUILD_COLUMNS, ORDER_COLUMNS, ORDER_LINE_COLUMNS, TimeView, fields},
};

/// Orders on a page unless asked otherwise.
const USUAL_ORDERS: u32 = 200;
/// Greatest number of orders on a page.
const MAX_ORDERS: u32 = 500;

/// The filter of a request; empty fields do not filter.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(super) struct OrderFilter {
    /// Any part of the name, in upper or lower case.
    find: String,
    /// In one state.
    #[schemars(with = "OrderState")]
    state: String,
    /// Greatest number of orders, 1 to 500; 200 unless given.
    #[schemars(with = "u32")]
    limit: String,
}

/// An order with its lines.
#[derive(Serialize, JsonSchema)]
pub(super) struct OrderResponse {
    /// The order and the sums over its lines.
    #[serde(flatten)]
    summary: OrderSummary,
    /// Its lines, oldest first.
    lines: Vec<OrderLineResource>,
}

/// A line of an order: a part, what became of its copies, and the builds that hold them.
#[derive(Serialize, JsonSchema)]
pub(super) struct OrderLineResource {
    /// The line.
    #[serde(flatten)]
    line: OrderLine,
    /// The builds that hold copies of it, oldest first.
    builds: Vec<BuiltCopies>,
}

/// The form of a button that concerns a whole order.
#[derive(Debug, Deserialize)]
pub(super) struct OrderButtonForm {
    key: String,
}

/// The orders that match the filter, and whether more may follow.
async fn read_orders(web: &DashboardState, filter: &OrderFilter) -> HandlerResult<(Vec<OrderSummary>, bool)> {
    let limit = parse_field::<u32>(&filter.limit, "a number of orders")?.unwrap_or(USUAL_ORDERS).clamp(1, MAX_ORDERS);
    let query = OrderQuery {
        name: Some(filter.find.trim().to_owned()).filter(|text| !text.is_empty()),
        state: parse_field(&filter.state, "a state of an order")?,
        limit: limit + 1,
    };
    let mut orders = web.ledger.order_summaries(&query).await?;
    let more = orders.len() > limit as usize;
    orders.truncate(limit as usize);
    Ok((orders, more))
}

/// An order with its lines; an error if there is none of that name.
async fn read_order(web: &DashboardState, name: &str) -> HandlerResult<OrderResponse> {
    let order =
        web.ledger.find_order(name).await?.ok_or_else(|| HandlerError::NotFound(format!("order named '{name}'")))?;
    let lines = web.ledger.order_lines(name).await?;
    let summary = OrderSummary::of_lines(order, &lines);
    let mut with_builds = Vec::with_capacity(lines.len());
    for line in lines {
        let builds = BuiltCopies::of_line(&line, &web.ledger.placements_of_part(line.part).await?);
        with_builds.push(OrderLineResource { line, builds });
    }
    Ok(OrderResponse { summary, lines: with_builds })
}

/// The orders as JSON.
pub(super) async fn get_orders(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<OrderFilter>,
) -> HandlerResult<Json<Vec<OrderSummary>>> {
    Ok(Json(read_orders(&web, &filter).await?.0))
}

/// An order with its lines as JSON.
pub(super) async fn get_order(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Json<OrderResponse>> {
    Ok(Json(read_order(&web, &name).await?))
}

/// The page that lists orders, open ones first.
pub(super) async fn list_orders(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<OrderFilter>,
) -> HandlerResult<Markup> {
    let (orders, more) = read_orders(&web, &filter).await?;
    let caption = count(orders.len() as u32, "order", "orders") + if more { ", the first of more" } else { "" };
    let states = [OrderState::Open, OrderState::Complete, OrderState::Short].map(|state| state.to_string());
    let content = html! {
        h1 { "Orders" }
        form.filters method="get" action="/orders" {
            label { "Name contains" input name="find" value=(filter.find); }
            label { (fields::STATE.label) select name="state" {
                option value="" { "all" }
                @for state in &states { option value=(state) selected[*state == filter.state] { (state) } }
            } }
            button type="submit" { "Show" }
        }
        p { "Open orders come first. Copies wanted are those that wait, are in builds, were printed, are good, or were refused." }
        @if orders.is_empty() { p { "No orders." } }
        @else { (table_of("Orders", Some(caption), ORDER_COLUMNS, &orders, &web.time_view())) }
    };
    Ok(html_page("Orders", "/orders", None, &content))
}

/// The page of an order.
pub(super) async fn show_order(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Markup> {
    let OrderResponse { summary, lines } = read_order(&web, &name).await?;
    let (lines, builds): (Vec<OrderLine>, Vec<Vec<BuiltCopies>>) =
        lines.into_iter().map(|line| (line.line, line.builds)).unzip();
    let mut builds = builds.concat();
    builds.sort_by_key(|row| (row.build.0, row.part.0));
    let view = web.time_view();
    let content = html! {
        h1 { "Order " (name) ": " (summary.order.state) }
        (state_sentence(&summary, &view))
        (order_buttons(&web, &name, &lines))
        h2 { "Lines" }
        (table_of("Lines", Some(count(lines.len() as u32, "line", "lines")), ORDER_LINE_COLUMNS, &lines, &view))
        h2 { "Builds" }
        @if builds.is_empty() { p { "No copy of it is in a build yet." } }
        @else { (table_of("Builds", None, ORDER_BUILD_COLUMNS, &builds, &view)) }
    };
    Ok(html_page(&format!("Order {name}"), "/orders", None, &content))
}

/// How far the order is.
fn state_sentence(summary: &OrderSummary, view: &TimeView) -> Markup {
    let copies = &summary.copies;
    let wanted = count(copies.wanted, "copy", "copies");
    html! {
        p class=[(summary.order.state == OrderState::Short).then_some("warn")] {
            (copies.good) " good of " (wanted) " wanted, since " (view.time_text(summary.order.opened_at)) "."
            @if let Some(due) = GivenDate::new(summary.due_at, &summary.due_text) { " Due " (view.due_text(&due)) "." }
        }
    }
}

/// The buttons that concern the whole order. Each is folded away, so that nobody presses it by mistake.
fn order_buttons(web: &DashboardState, name: &str, lines: &[OrderLine]) -> Markup {
    let printed = lines.iter().any(|line| line.copies.printed + line.copies.good > 0);
    let waiting = lines.iter().filter(|line| line.state == PartState::Waiting).count() as u32;
    let address = order_address(name);
    html! {
        @if web.orders && printed {
            details { summary { "Print again" }
                p { "Every printed copy of this order counts as bad and waits again, first in line, with all that was asked." }
                form.tell method="post" action=(format!("{address}/reprint")) {
                    input type="hidden" name="key" value=(web.form_key);
                    button type="submit" { "Print every printed copy again" }
                }
            }
        }
        @if web.orders && waiting > 0 {
            details { summary { "Cancel" }
                p { (count(waiting, "part waits", "parts wait")) ". Copies that are in builds already stay there." }
                form.tell method="post" action=(format!("{address}/cancel")) {
                    input type="hidden" name="key" value=(web.form_key);
                    button type="submit" { "Cancel what waits" }
                }
            }
        }
    }
}

/// Puts every printed copy of an order back among the waiting ones.
pub(super) async fn post_reprint(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
    Form(form): Form<OrderButtonForm>,
) -> HandlerResult<Response> {
    check_form_key(&web, &form.key)?;
    let back = order_address(&name);
    let report = web.ledger.reprint_copies(&ReprintTarget::Order(name), &by).await;
    answer_page(report.map(|report| report.sentences()), &back)
}

/// Cancels what waits of an order.
pub(super) async fn post_cancel(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    RequestUser(by): RequestUser,
    Form(form): Form<OrderButtonForm>,
) -> HandlerResult<Response> {
    check_form_key(&web, &form.key)?;
    let lines = web.ledger.order_lines(&name).await?;
    let cancel = |line: &OrderLine| NewCommand {
        kind: CommandKind::Cancel,
        profile: String::new(),
        part: Some(line.part),
        argument: CommandArgument { copies: waiting_of_several(line), edit: None },
        asked_by: by.clone(),
    };
    let commands = lines.iter().filter(|line| line.state == PartState::Waiting).map(cancel).collect();
    send_commands(&web, commands, &order_address(&name)).await
}

/// The waiting copies of a line, if others of it are in builds; `None` = all copies wait.
fn waiting_of_several(line: &OrderLine) -> Option<u32> {
    (line.copies.waiting < line.copies.wanted).then_some(line.copies.waiting)
}
