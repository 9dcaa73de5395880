//! The page that lists orders, the page of one order with its lines and builds, and both as JSON.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State},
};
use farm::{DatedOrder, MachinePlan, OrderFact, OrderWord, RiskCause, copy_counts, customer_note};
use jiff::Timestamp;
use language::{colon, say};
use ledger::{
    EventRow, LineCopies, OrderLine, OrderQuery, OrderRow, OrderState, OrderSummary, OrderedLine, UtcTimestamp,
};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::costs::{CostQuestion, cost_figure};
use crate::{
    tables::{
        BUILD_PAGE_KEYS, BuiltCopies, GivenDate, ORDER_BUILD_COLUMNS, ORDER_COLUMNS, ORDER_EVENT_COLUMNS,
        ORDER_LINE_COLUMNS, PromisedDate, TimeView, closing_text, fields, gathered_events, order_copies_text,
    },
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            listing::{table_of, table_of_keys},
            page::html_page,
            query::{Query, customer_address, order_address, parse_field},
        },
        core::state::DashboardState,
        forms::{finish_forms::finishing_section, order_forms::order_forms},
        look::{
            chip::{chip, state_text},
            pieces::empty,
            times::{due_of, promise_of, time_of},
        },
        paper::label_form::order_labels,
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
    /// Any part of the name of a customer, in upper or lower case.
    customer: String,
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
    /// Number of its lines of which it is not known how many copies are wanted.
    lines_without_number: u32,
    /// What became of its copies.
    #[serde(flatten)]
    copies: LineCopies,
    /// The same in words.
    #[serde(skip)]
    copies_text: String,
    /// How it stands, when it is done, and whether that is late.
    #[serde(flatten)]
    fact: OrderFact,
    /// What can be sent to its customer.
    customer_note: String,
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
    let limit =
        parse_field::<u32>(&filter.limit, &say!("a-number-of-orders"))?.unwrap_or(USUAL_ORDERS).clamp(1, MAX_ORDERS);
    let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let query = OrderQuery {
        name: some(&filter.find),
        customer: some(&filter.customer),
        state: parse_field(&filter.state, &say!("a-state-of-order"))?,
        limit: limit + 1,
        ..OrderQuery::default()
    };
    let mut orders = web.ledger.order_summaries(&query).await?;
    let more = orders.len() > limit as usize;
    orders.truncate(limit as usize);
    let (plans, now) = (web.read_plans().await?, Timestamp::now());
    Ok((orders.into_iter().map(|order| DatedOrder::of_plans(order, &plans, now)).collect(), more))
}

/// An order with its lines; an error if there is none of that name.
async fn read_order(web: &DashboardState, name: &str) -> HandlerResult<OrderResponse> {
    let arriving = web.ledger.arriving_lines_of_order(name).await?;
    let order = match web.ledger.find_order(name).await? {
        None if arriving.is_empty() => return Err(HandlerError::NotFound(say!("order-named", order = name))),
        None => OrderRow::arriving(name),
        Some(order) => order,
    };
    let lines = web.ledger.order_lines(name).await?;
    let (plans, now) = (web.read_plans().await?, Timestamp::now());
    let dated = DatedOrder::of_plans(OrderSummary::of_lines(order, &lines), &plans, now);
    let customer_note = customer_note(&dated, &web.current_settings().time_zone, now);
    let DatedOrder { order: summary, fact } = dated;
    let copies_text = order_copies_text(&summary);
    let OrderSummary { order, lines_without_number, due_at, due_text, copies, .. } = summary;
    let mut with_builds = Vec::with_capacity(lines.len());
    for line in lines {
        let builds = BuiltCopies::of_line(&line, &web.ledger.placements_of_part(line.part).await?, &plans);
        with_builds.push(OrderLineResource { line: line_of_plans(line, &plans), builds });
    }
    Ok(OrderResponse {
        order,
        lines_without_number,
        due_at,
        due_text,
        copies,
        copies_text,
        fact,
        customer_note,
        lines: with_builds,
        arriving,
    })
}

/// A line with what became of its copies according to the plans.
fn line_of_plans(line: OrderLine, plans: &[MachinePlan]) -> OrderLine {
    OrderLine { copies: copy_counts(&line.copies, plans, |planned| planned.part == line.part), ..line }
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

/// The page that lists orders: by due date, and those that are over last.
pub(crate) async fn list_orders(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<OrderFilter>,
) -> HandlerResult<Markup> {
    let (orders, more) = read_orders(&web, &filter).await?;
    let caption = match more {
        true => say!("first-orders", count = orders.len()),
        false => say!("count-orders", count = orders.len()),
    };
    let states = [(OrderState::Open, "under way"), (OrderState::Short, "short"), (OrderState::Complete, "done")];
    let content = html! {
        h1 { (say!("nav-orders")) }
        form.filters method="get" action="/orders" {
            label { (say!("name-contains")) input name="find" value=(filter.find); }
            label { (say!("customer-contains")) input name="customer" value=(filter.customer); }
            label { (fields::STATE.said()) select name="state" {
                option value="" { (say!("all")) }
                @for (state, word) in states { option value=(state) selected[state.to_string() == filter.state] { (state_text(word)) } }
            } }
            button type="submit" { (say!("show")) }
        }
        @if orders.is_empty() {
            (empty(&say!("no-such-orders"), &html! { (say!("no-such-orders-text")) }, &html! {
                a.button href="/orders" { (say!("all-orders")) }
            }))
        }
        @else { (table_of(&say!("nav-orders"), Some(caption), ORDER_COLUMNS, &orders, &web.time_view())) }
    };
    Ok(html_page(&say!("nav-orders"), "/orders", None, &content))
}

/// The page of an order.
pub(crate) async fn show_order(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Markup> {
    let mut order = read_order(&web, &name).await?;
    let (lines, builds): (Vec<OrderLine>, Vec<Vec<BuiltCopies>>) =
        std::mem::take(&mut order.lines).into_iter().map(|line| (line.line, line.builds)).unzip();
    let builds = BuiltCopies::by_build(builds.concat());
    let waiting: u32 = lines.iter().map(|line| line.copies.waiting).sum();
    let events = order_events(&web, &lines).await?;
    let view = web.time_view();
    let cost = cost_figure(&web, CostQuestion::of_order(&name)).await?;
    let emails = web.ledger.emails_of_order(&name).await?;
    let content = html! {
        h1 { (say!("order-title", order = &name)) " " (chip(order.fact.word.word())) }
        (order_summary(&order, &view))
        @if let Some((cost, address)) = &cost { p { (phrase!("order-costs", cost = html! { a href=(address) { (cost) } })) } }
        (order_forms(&web, (&order.order, &emails), &lines, order.arriving.len()))
        section.card aria-label=(fields::CUSTOMER_NOTE.said()) {
            h2 { (say!("send-to-customer")) }
            p #customer-note { (order.customer_note) }
            button type="button" data-copies="customer-note" hidden { (say!("copy-text")) }
        }
        h2 { (fields::LINES.said()) }
        (table_of(&fields::LINES.said(), Some(say!("count-lines", count = lines.len())), ORDER_LINE_COLUMNS, &lines, &view))
        @if !order.arriving.is_empty() { p { (say!("lines-arrive", count = order.arriving.len())) } }
        div.buttons.acts { (order_labels(&name)) }
        h2 { (say!("where-copies-are")) }
        @if waiting > 0 { p { (say!("copies-wait-for-build", count = waiting)) } }
        @if builds.is_empty() { p { (say!("order-in-no-build")) } }
        @else { (table_of_keys((&fields::BUILDS.said(), None), ORDER_BUILD_COLUMNS, &BUILD_PAGE_KEYS, &builds, &view)) }
        (finishing_section(&web, &web.ledger.finishing_of_order(&name).await?, &order_address(&name)))
        h2 { (say!("what-happened-who")) }
        (table_of(&say!("events"), None, ORDER_EVENT_COLUMNS, &events, &view))
    };
    Ok(html_page(&say!("order-title", order = &name), "/orders", Some("copy.js"), &content))
}

/// The newest events of the parts of an order that say something, newest first.
async fn order_events(web: &DashboardState, lines: &[OrderLine]) -> HandlerResult<Vec<EventRow>> {
    let mut events = Vec::new();
    for line in lines {
        events.extend(web.ledger.events_of_part(line.part).await?);
    }
    // Of a step without a word, where the copies are says the same.
    events.retain(|event| !event.detail.is_empty());
    events.sort_by_key(|event| std::cmp::Reverse(event.id));
    events.truncate(MAX_EVENTS);
    Ok(gathered_events(events))
}

/// How the order stands.
fn order_summary(order: &OrderResponse, view: &TimeView) -> Markup {
    let customer = &order.order.customer;
    html! {
        p class=[(order.fact.word == OrderWord::Short).then_some("warn")] {
            @if !customer.is_empty() {
                (phrase!("order-for", customer = html! { a href=(customer_address(customer)) { (customer) } })) " "
            }
            (phrase!("order-since", copies = &order.copies_text, time = time_of(order.order.opened_at, view)))
            @if let Some(due) = GivenDate::new(order.due_at, &order.due_text) { " " (phrase!("order-due", due = due_of(&due, view))) }
            @if let Some(promise) = PromisedDate::of_order(&order.fact) {
                @let time = promise_of(&promise, view);
                " " @match promise.is_estimated {
                    false => (phrase!("order-done", time = time)),
                    true if view.now().is_some_and(|now| promise.done_at.0 <= now) => (phrase!("order-should-be-done", time = time)),
                    true => (phrase!("order-expected", time = time)),
                }
            }
            @if let Some(closed) = closing_text(&order.order, view) { " " (say!("order-closed", how = closed)) }
        }
        @if order.fact.word == OrderWord::Short {
            p { (say!("order-short-text")) }
        }
        // That its date has passed, the date says.
        @if order.fact.is_at_risk && !order.fact.risk_reason.is_empty() && order.fact.risk_cause != Some(RiskCause::Passed) {
            p.bad role="status" { b { (state_text(order.fact.word.word())) } (colon()) (view.near_times(&order.fact.risk_reason)) (say!("sign-stop")) }
        }
    }
}
