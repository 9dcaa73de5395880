//! The page that lists orders, the page of one order with its lines and builds, and both as JSON.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State},
};
use jiff::Timestamp;
use ledger::{
    EventRow, LineCopies, OrderLine, OrderQuery, OrderRow, OrderState, OrderSummary, OrderedLine, UtcTimestamp,
};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    farm::{DatedOrder, MachinePlan, OrderFact, order_fact, read_plans},
    tables::{
        BuiltCopies, GivenDate, ORDER_BUILD_COLUMNS, ORDER_COLUMNS, ORDER_EVENT_COLUMNS, ORDER_LINE_COLUMNS, TimeView,
        fields,
    },
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            format::count,
            listing::table_of,
            page::html_page,
            query::{Query, parse_field},
        },
        core::state::DashboardState,
        forms::order_forms::{line_forms, order_buttons, order_forms},
    },
};

/// Events of an order on its page.
const MAX_EVENTS: usize = 200;
/// Orders on a page unless asked otherwise.
const USUAL_ORDERS: u32 = 200;
/// Greatest number of orders on a page.
const MAX_ORDERS: u32 = 500;

/// The filter of a request; empty fields do not filter.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct OrderFilter {
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
pub(crate) struct OrderResponse {
    /// Its row.
    #[serde(flatten)]
    order: OrderRow,
    /// The earliest due date among the lines that are not good.
    due_at: Option<UtcTimestamp>,
    /// That date as it was given, "" = none.
    due_text: String,
    /// What became of its copies.
    #[serde(flatten)]
    copies: LineCopies,
    /// When it is done, and whether that is late.
    #[serde(flatten)]
    fact: OrderFact,
    /// Its lines, oldest first.
    lines: Vec<OrderLineResource>,
    /// Lines that came by request and are no parts yet.
    arriving: Vec<OrderedLine>,
}

/// A line of an order: a part, what became of its copies, and the builds that hold them.
#[derive(Serialize, JsonSchema)]
pub(crate) struct OrderLineResource {
    /// The line.
    #[serde(flatten)]
    line: OrderLine,
    /// The builds that hold copies of it, oldest first.
    builds: Vec<BuiltCopies>,
}

/// The orders that match the filter, and whether more may follow.
async fn read_orders(web: &DashboardState, filter: &OrderFilter) -> HandlerResult<(Vec<DatedOrder>, bool)> {
    let limit = parse_field::<u32>(&filter.limit, "a number of orders")?.unwrap_or(USUAL_ORDERS).clamp(1, MAX_ORDERS);
    let query = OrderQuery {
        name: Some(filter.find.trim().to_owned()).filter(|text| !text.is_empty()),
        state: parse_field(&filter.state, "a state of an order")?,
        limit: limit + 1,
    };
    let mut orders = web.ledger.order_summaries(&query).await?;
    let more = orders.len() > limit as usize;
    orders.truncate(limit as usize);
    Ok((DatedOrder::of_plans(orders, &plans_of(web).await?), more))
}

/// The plans of all machines.
async fn plans_of(web: &DashboardState) -> HandlerResult<Vec<MachinePlan>> {
    Ok(read_plans(&web.ledger, web.current_settings().profiles.values(), Timestamp::now()).await?)
}

/// An order with its lines; an error if there is none of that name.
async fn read_order(web: &DashboardState, name: &str) -> HandlerResult<OrderResponse> {
    let arriving = web.ledger.arriving_lines_of_order(name).await?;
    let order = match web.ledger.find_order(name).await? {
        None if arriving.is_empty() => return Err(HandlerError::NotFound(format!("order named '{name}'"))),
        None => OrderRow::arriving(name),
        Some(order) => order,
    };
    let lines = web.ledger.order_lines(name).await?;
    let summary = OrderSummary::of_lines(order, &lines);
    let fact = order_fact(&summary, &plans_of(web).await?);
    let OrderSummary { order, lines: _, due_at, due_text, copies } = summary;
    let mut with_builds = Vec::with_capacity(lines.len());
    for line in lines {
        let builds = BuiltCopies::of_line(&line, &web.ledger.placements_of_part(line.part).await?);
        with_builds.push(OrderLineResource { line, builds });
    }
    Ok(OrderResponse { order, due_at, due_text, copies, fact, lines: with_builds, arriving })
}

/// The orders as JSON.
pub(crate) async fn get_orders(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<OrderFilter>,
) -> HandlerResult<Json<Vec<DatedOrder>>> {
    Ok(Json(read_orders(&web, &filter).await?.0))
}

/// An order with its lines as JSON.
pub(crate) async fn get_order(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Json<OrderResponse>> {
    Ok(Json(read_order(&web, &name).await?))
}

/// The page that lists orders, open ones first.
pub(crate) async fn list_orders(
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
pub(crate) async fn show_order(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Markup> {
    let mut order = read_order(&web, &name).await?;
    let (lines, builds): (Vec<OrderLine>, Vec<Vec<BuiltCopies>>) =
        std::mem::take(&mut order.lines).into_iter().map(|line| (line.line, line.builds)).unzip();
    let mut builds = builds.concat();
    builds.sort_by_key(|row| (row.build.0, row.part.0));
    let waiting: u32 = lines.iter().map(|line| line.copies.waiting).sum();
    let parts = web.ledger.parts_of_order(&name).await?;
    let events = order_events(&web, &lines).await?;
    let view = web.time_view();
    let content = html! {
        h1 { "Order " (name) ": " (order.order.state) }
        (state_sentence(&order, &view))
        (order_buttons(&web, &name, &lines, order.arriving.len()))
        (order_forms(&web, &name, &lines))
        h2 { "Lines" }
        (table_of("Lines", Some(count(lines.len() as u32, "line", "lines")), ORDER_LINE_COLUMNS, &lines, &view))
        (line_forms(&web, &lines, &parts))
        @if !order.arriving.is_empty() { p { (count(order.arriving.len() as u32, "line", "lines")) " more came by request and will be here in a moment." } }
        h2 { "Where the copies are" }
        @if waiting > 0 { p { (count(waiting, "copy waits", "copies wait")) " for a build." } }
        @if builds.is_empty() { p { "No copy of it is in a build yet." } }
        @else { (table_of("Builds", None, ORDER_BUILD_COLUMNS, &builds, &view)) }
        h2 { "What happened, and who did it" }
        (table_of("Events", None, ORDER_EVENT_COLUMNS, &events, &view))
    };
    Ok(html_page(&format!("Order {name}"), "/orders", None, &content))
}

/// The newest events of the parts of an order, newest first.
async fn order_events(web: &DashboardState, lines: &[OrderLine]) -> HandlerResult<Vec<EventRow>> {
    let mut events = Vec::new();
    for line in lines {
        events.extend(web.ledger.events_of_part(line.part).await?);
    }
    events.sort_by_key(|event| std::cmp::Reverse(event.id));
    events.truncate(MAX_EVENTS);
    Ok(events)
}

/// How far the order is.
fn state_sentence(order: &OrderResponse, view: &TimeView) -> Markup {
    let copies = &order.copies;
    let wanted = count(copies.wanted, "copy", "copies");
    html! {
        p class=[(order.order.state == OrderState::Short).then_some("warn")] {
            (copies.good) " good of " (wanted) " wanted, since " (view.time_text(order.order.opened_at)) "."
            @if let Some(due) = GivenDate::new(order.due_at, &order.due_text) { " Due " (view.due_text(&due)) "." }
            @if let Some(done) = order.fact.done_at { " Done about " (view.near_text(done)) " if nothing more arrives." }
        }
        @if let Some(risk) = order.fact.risk_word() {
            p.bad role="status" { b { (risk) } ": " (order.fact.risk_reason) "." }
        }
    }
}
