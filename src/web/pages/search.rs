//! The page that says what a search found: orders, parts, customers, builds and machines, each kind by itself.

use std::{collections::BTreeMap, sync::Arc};

use axum::extract::State;
use farm::{FoundNames, FoundRows, MachinePlan, build_of_search, read_part_facts, search_names};
use language::{comma, say};
use ledger::{NamedBuildRow, NamedPartRow, PartId};
use maud::{Markup, html};
use serde::{Deserialize, Serialize};

use crate::{
    tables::fields,
    web::{
        base::{
            error::HandlerResult,
            page::html_page,
            query::{Query, customer_address, order_address, query_string},
        },
        core::state::DashboardState,
        look::{chip::state_text, pieces::thumbnail},
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
    let states: Vec<_> = found.parts.rows.iter().map(|part| (part.id, part.state)).collect();
    let text = asked.q.trim();
    let content = html! {
        h1 { @if text.is_empty() { (say!("search")) } @else { (say!("search-for-text", text = text)) } }
        @if text.is_empty() { (search_help()) }
        @else if found.is_empty() { p role="status" { (say!("nothing-found")) } (search_help()) }
        @else {
            @let plans = web.read_plans().await?;
            @let words = read_part_facts(&web.ledger, &states, &plans).await?;
            div.found { (found_kinds(&found, (&plans, &words), &format!("/search?{more}"))) }
        }
    };
    Ok(html_page(&say!("search"), "/search", None, &content))
}

fn search_help() -> Markup {
    html! {
        p { (say!("search-help")) " "
             code { "1182" } ", " code { "build 1182" } ", " code { "b1182" } ", " code { "P-17" } "." }
    }
}

fn found_kinds(found: &FoundNames, (plans, words): (&[MachinePlan], &BTreeMap<PartId, String>), more: &str) -> Markup {
    let FoundNames { machines, orders, customers, builds, parts } = found;
    html! {
        (found_kind(orders, FoundKind::Orders, more, |order| html! {
            a href=(order_address(&order.name)) { (order.name) } @if !order.customer.is_empty() { " " span.soft { (order.customer) } }
        }))
        (found_kind(customers, FoundKind::Customers, more, |customer| html! {
            a href=(customer_address(&customer.name)) { (customer.name) } " "
            span.soft { (say!("count-parts", count = customer.parts as u32)) }
            @for order in &customer.orders { " " a href=(order_address(order)) { (order) } }
        }))
        (found_kind(builds, FoundKind::Builds, more, |build| build_entry(build, plans)))
        (found_kind(machines, FoundKind::Machines, more, |name| html! { a href=(format!("/#{name}")) { (name) } }))
        (found_kind(parts, FoundKind::Parts, more, |part| part_entry(part, words)))
    }
}

fn build_entry(build: &NamedBuildRow, plans: &[MachinePlan]) -> Markup {
    html! {
        a href=(format!("/builds/{}", build.id)) { (say!("build-number", build = build.id.to_string())) } " "
        span.soft { (build.machine) (comma()) (state_text(&build_of_search(build, plans).word))
            @if let Some(height) = fields::HEIGHT.with_unit(build.height_mm) { (comma()) (height) }
            @if let Some(copies) = build.copies { (comma()) (say!("count-copies", count = copies)) } }
    }
}

fn part_entry(part: &NamedPartRow, words: &BTreeMap<PartId, String>) -> Markup {
    let word = words.get(&part.id).map(|word| state_text(word)).unwrap_or_default();
    html! {
        a href=(format!("/parts/{}", part.id)) { (thumbnail(part.id)) (part.full_name()) } " "
        span.soft { (say!("found-part", part = part.id.to_string(), state = word, machine = &part.machine)) }
        @if !part.order_name.is_empty() { " " (phrase!("order-of", order = html! { a href=(order_address(&part.order_name)) { (part.order_name) } })) }
        @if !part.note.is_empty() { " " span.soft { (part.note) } }
    }
}

/// What can be found.
#[derive(Clone, Copy)]
enum FoundKind {
    Orders,
    Customers,
    Builds,
    Machines,
    Parts,
}

impl FoundKind {
    /// Its name, and how many were found. `is_cut` = there may be more.
    fn heading(self, count: usize, is_cut: bool) -> (String, String) {
        let (name, number) = match self {
            Self::Orders => (say!("found-orders"), say!("count-orders", count = count)),
            Self::Customers => (say!("found-customers"), say!("count-customers", count = count)),
            Self::Builds => (say!("found-builds"), say!("count-builds", count = count)),
            Self::Machines => (say!("found-machines"), say!("count-machines", count = count)),
            Self::Parts => (say!("found-parts"), say!("count-parts", count = count)),
        };
        (name, if is_cut { say!("or-more", number = number) } else { number })
    }
}

/// What was found of one kind; nothing if that is nothing.
fn found_kind<T>(found: &FoundRows<T>, kind: FoundKind, more: &str, entry: impl Fn(&T) -> Markup) -> Markup {
    let left = found.total - found.rows.len();
    let (name, number) = kind.heading(found.total, found.is_cut());
    let left_text = if found.is_cut() { say!("or-more", number = left.to_string()) } else { left.to_string() };
    html! {
        @if found.total > 0 {
            section aria-label=(name) {
                h2 { (number) }
                ul { @for row in &found.rows { li { (entry(row)) } } }
                @if left > 0 {
                    p { (phrase!("more-not-shown", link = html! { a href=(more) { (say!("show-more")) } }, count = left_text, what = name)) }
                }
            }
        }
    }
}
