//! What builds cost and which order bears what, of a month, an order or a build; also as CSV and JSON.

use std::sync::Arc;

use axum::{
    Json,
    extract::State,
    http::header,
    response::{IntoResponse, Response},
};
use farm::CostReport;
use jiff::Timestamp;
use language::say;
use ledger::{BuildId, CostQuery};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use settings::PriceSum;

use super::month::FarmMonth;
use crate::{
    tables::{COST_SHARE_COLUMNS, ORDER_COST_COLUMNS, csv_of, fields},
    web::{
        base::{
            error::HandlerResult,
            format::prose_with_code,
            listing::table_of,
            page::html_page,
            query::{Query, parse_field, query_string},
        },
        core::state::DashboardState,
        look::pieces::{empty, figure},
    },
};

/// Which builds are asked for; what is empty does not filter.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct CostQuestion {
    /// Builds published in this month, such as 2026-10, in the time zone of the farm. If nothing is asked, the current one.
    #[serde(skip_serializing_if = "String::is_empty")]
    at: String,
    /// What this order bears.
    #[serde(skip_serializing_if = "String::is_empty")]
    order: String,
    /// One build, by its number.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "i64")]
    build: String,
}

impl CostQuestion {
    /// What the ledger is asked, and the month of it.
    fn read(&self, web: &DashboardState) -> HandlerResult<(CostQuery, Option<FarmMonth>)> {
        let zone = web.current_settings().time_zone.clone();
        let is_all_time = self.at.is_empty() && !(self.order.is_empty() && self.build.is_empty());
        let month = (!is_all_time).then(|| FarmMonth::parse(&self.at, &zone, Timestamp::now())).transpose()?;
        let span = month.as_ref().map(FarmMonth::span);
        let query = CostQuery {
            since: span.map(|(since, _)| since),
            until: span.map(|(_, until)| until),
            build: parse_field::<i64>(&self.build, &say!("the-number-of-build"))?.map(BuildId),
            order_name: Some(self.order.clone()).filter(|order| !order.is_empty()),
        };
        Ok((query, month))
    }
}

async fn read_costs(web: &DashboardState, query: &CostQuery) -> HandlerResult<CostReport> {
    Ok(CostReport::read(&web.ledger, query, &web.current_settings().profiles).await?)
}

/// What one order bears of all builds, or a build costs; empty where nothing has a price. A link leads to the costs.
pub(super) async fn cost_figure(web: &DashboardState, of: CostQuestion) -> HandlerResult<Option<(String, String)>> {
    let (query, _) = of.read(web)?;
    let report = read_costs(web, &query).await?;
    let sums = if of.order.is_empty() { report.totals } else { report.sums_of_order(&of.order) };
    let address = format!("/costs?{}", query_string(&of)?);
    Ok((!sums.is_empty()).then(|| (join_sums(&sums), address)))
}

impl CostQuestion {
    /// The costs of one order.
    pub(super) fn of_order(name: &str) -> Self {
        Self { order: name.to_owned(), ..Self::default() }
    }

    /// The cost of one build.
    pub(super) fn of_build(build: BuildId) -> Self {
        Self { build: build.to_string(), ..Self::default() }
    }
}

fn join_sums(sums: &[PriceSum]) -> String {
    language::join_names(sums.iter().map(ToString::to_string))
}

/// The page of costs.
pub(crate) async fn show_costs(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<CostQuestion>,
) -> HandlerResult<Markup> {
    let (query, month) = asked.read(&web)?;
    let report = read_costs(&web, &query).await?;
    let (address, view) = (query_string(&asked)?, web.time_view());
    let content = html! {
        h1 { (say!("costs")) }
        form.filters method="get" action="/costs" {
            label { (say!("nav-month")) input type="month" name="at" value=(month.as_ref().map(FarmMonth::key).unwrap_or_default()) pattern="[0-9]{4}-[0-9]{2}" placeholder="2026-10"; }
            label { (fields::ORDER.said()) input name="order" value=(asked.order); }
            label { (fields::BUILD.said()) input name="build" value=(asked.build) inputmode="numeric"; }
            button type="submit" { (say!("show")) }
        }
        @if report.shares.is_empty() { (empty(&say!("no-builds"), &html! { (say!("none-matches")) }, &html! { a.button href="/costs" { (say!("this-month")) } })) }
        @else {
            @if report.totals.is_empty() { p.note { (prose_with_code(&say!("no-prices"))) } }
            @else { ul.figures { @for sum in &report.totals { (figure(&sum.to_string(), &say!("figure-cost"), None)) } } }
            (table_of(&say!("costs-by-order"), Some(say!("costs-by-order")), ORDER_COST_COLUMNS, &report.orders, &view))
            p.soft { (say!("costs-text")) }
            (table_of(&say!("costs-by-build"), Some(say!("costs-by-build")), COST_SHARE_COLUMNS, &report.shares, &view))
            p.links {
                a href=(format!("/costs.csv?{address}")) download { (say!("csv-by-order")) }
                a href=(format!("/costs-by-build.csv?{address}")) download { (say!("csv-by-build")) }
                a href=(format!("/costs.json?{address}")) download { "JSON" }
            }
        }
    };
    Ok(html_page(&say!("costs"), "/month", None, &content))
}

fn csv_file(name: &str, text: Result<String, csv::Error>) -> HandlerResult<Response> {
    let text = text.map_err(anyhow::Error::from)?;
    let name = format!("attachment; filename=\"{name}\"");
    let head = [(header::CONTENT_TYPE, "text/csv; charset=utf-8".to_owned()), (header::CONTENT_DISPOSITION, name)];
    Ok((head, text).into_response())
}

/// What each order bears, as CSV.
pub(crate) async fn download_csv(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<CostQuestion>,
) -> HandlerResult<Response> {
    let report = read_costs(&web, &asked.read(&web)?.0).await?;
    csv_file("nestd-costs.csv", csv_of(ORDER_COST_COLUMNS, &report.orders))
}

/// What each order bears of each build, as CSV.
pub(crate) async fn download_shares_csv(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<CostQuestion>,
) -> HandlerResult<Response> {
    let report = read_costs(&web, &asked.read(&web)?.0).await?;
    csv_file("nestd-costs-by-build.csv", csv_of(COST_SHARE_COLUMNS, &report.shares))
}

/// The costs as JSON.
pub(crate) async fn get_costs(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<CostQuestion>,
) -> HandlerResult<Json<CostReport>> {
    Ok(Json(read_costs(&web, &asked.read(&web)?.0).await?))
}
