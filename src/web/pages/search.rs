//! The page that says what a search found: orders, parts, customers, builds and machines, each kind by itself.

use std::sync::Arc;

use axum::extract::State;
use ledger::{NamedBuildRow, NamedPartRow};
use maud::{Markup, html};
use serde::{Deserialize, Serialize};

use crate::{
    farm::{FoundNames, FoundRows, search_names},
    tables::fields,
    web::{
        base::{
            error::HandlerResult,
            format::count,
            page::html_page,
            query::{Query, customer_address, order_address, query_string},
        },
        core::state::DashboardState,
        look::{chip::said, pieces::thumbnail},
    },
};

/// Rows of each kind on a page.
const USUAL_ROWS: usize = 20;
/// Rows of each kind on a page that shows more of them.
const MORE_ROWS: usize = 500;

/// What is searched.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(default)]
pub(crate) struct SearchQuestion {
    /// Part of a name, or a number.
    q: String,
    /// Set if more rows of each kind are shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    all: Option<String>,
}

/// The page of a search.
pub(crate) async fn show_found(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<SearchQuestion>,
) -> HandlerResult<Markup> {
    let settings = web.current_settings();
    let machines: Vec<&String> = settings.profiles.keys().collect();
    let most = if asked.all.is_some() { MORE_ROWS } else { USUAL_ROWS };
    let found = search_names(&web.ledger, &machines, &asked.q, most).await?;
    let more = query_string(&SearchQuestion { all: Some("yes".to_owned()), ..asked.clone() })?;
    let text = asked.q.trim();
    let content = html! {
        h1 { @if text.is_empty() { "Search" } @else { "Search: " (text) } }
        @if text.is_empty() { (search_help()) }
        @else if found.is_empty() { p role="status" { "Nothing has this in its name." } (search_help()) }
        @else { div.found { (found_kinds(&found, &format!("/search?{more}"))) } }
    };
    Ok(html_page("Search", "/search", None, &content))
}

fn search_help() -> Markup {
    html! {
        p { "Search for any part of the name of a part, file, order, customer, build or machine, in upper or lower case; of several words \
             a name must contain each. A number finds the build and the part with it: " code { "1182" } ", " code { "build 1182" } ", "
             code { "b1182" } ", " code { "P-17" } "." }
    }
}

fn found_kinds(found: &FoundNames, more: &str) -> Markup {
    let FoundNames { machines, orders, customers, builds, parts } = found;
    html! {
        (found_kind(orders, ("order", "orders"), more, |order| html! {
            a href=(order_address(&order.name)) { (order.name) } @if !order.customer.is_empty() { " " span.soft { (order.customer) } }
        }))
        (found_kind(customers, ("customer", "customers"), more, |customer| html! {
            a href=(customer_address(&customer.name)) { (customer.name) } " "
            span.soft { (count(customer.parts as u32, "part", "parts")) }
            @for order in &customer.orders { " " a href=(order_address(order)) { (order) } }
        }))
        (found_kind(builds, ("build", "builds"), more, build_entry))
        (found_kind(machines, ("machine", "machines"), more, |name| html! { a href=(format!("/#{name}")) { (name) } }))
        (found_kind(parts, ("part", "parts"), more, part_entry))
    }
}

fn build_entry(build: &NamedBuildRow) -> Markup {
    html! {
        a href=(format!("/builds/{}", build.id)) { "Build " (build.id) } " "
        span.soft { (build.machine) ", " (said(&build.state.to_string()))
            @if let Some(height) = fields::HEIGHT.with_unit(build.height_mm) { ", " (height) }
            @if let Some(copies) = build.copies { ", " (count(copies, "copy", "copies")) } }
    }
}

fn part_entry(part: &NamedPartRow) -> Markup {
    html! {
        a href=(format!("/parts/{}", part.id)) { (thumbnail(part.id)) (part.full_name()) } " "
        span.soft { "part " (part.id) ", " (said(&part.state.to_string())) " on " (part.machine) }
        @if !part.order_name.is_empty() { " order " a href=(order_address(&part.order_name)) { (part.order_name) } }
        @if !part.note.is_empty() { " " span.soft { (part.note) } }
    }
}

/// What was found of one kind; nothing if that is nothing.
fn found_kind<T>(found: &FoundRows<T>, (one, many): (&str, &str), more: &str, entry: impl Fn(&T) -> Markup) -> Markup {
    let left = found.total - found.rows.len();
    let number =
        if found.is_cut() { format!("{} {many} or more", found.total) } else { count(found.total as u32, one, many) };
    html! {
        @if found.total > 0 {
            section aria-label=(many) {
                h2 { (number) }
                ul { @for row in &found.rows { li { (entry(row)) } } }
                @if left > 0 {
                    p { a href=(more) { "Show more" } ": " (left) @if found.is_cut() { " or more" } " " (many) " are not shown." }
                }
            }
        }
    }
}
