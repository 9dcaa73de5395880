//! The history page: builds with their heights, filtered and sorted. The shown rows are also available as CSV and
//! JSON.

use std::sync::Arc;

use axum::{
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use farm::DatedBuild;
use jiff::{Timestamp, ToSpan, civil::Date};
use language::say;
use ledger::{BuildId, BuildState, HeightSummary, HistoryQuery, HistorySort};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use settings::FarmZone;

use crate::{
    tables::{FieldDefinition, HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS, HISTORY_PAGE_KEYS, TimeView, csv_of, fields},
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            listing::{table_of, table_of_keys},
            page::html_page,
            query::{Query, parse_field, query_string},
        },
        core::state::DashboardState,
        figures::chart,
        look::{chip::state_text, pieces::empty},
    },
};

/// Spans of time that are one click away, days.
const QUICK_SPANS: [i64; 3] = [7, 30, 90];
/// Greatest number of builds on a page.
const MAX_ROWS: u32 = 500;

/// The filter of a request; empty fields do not filter.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct HistoryFilter {
    /// Only builds of this machine.
    #[serde(skip_serializing_if = "String::is_empty")]
    machine: String,
    /// Only builds in this state.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "BuildState")]
    state: String,
    /// Only builds that contain a part with this file name or order.
    #[serde(skip_serializing_if = "String::is_empty")]
    part: String,
    /// Only builds from this day on, in the time zone of the farm.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(extend("format" = "date"))]
    since: String,
    /// Only builds up to and including this day, in the time zone of the farm.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(extend("format" = "date"))]
    until: String,
    /// Sort by this column; newest first if empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(extend("enum" = SORT_COLUMNS.map(|(word, ..)| word)))]
    sort: String,
    /// Only builds after this build in the sort order: the last build of the previous page.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "i64")]
    after: String,
}

/// The possible sort columns, besides newest first, each with its field.
const SORT_COLUMNS: [(&str, HistorySort, FieldDefinition); 4] = [
    ("height", HistorySort::Height, fields::HEIGHT),
    ("density", HistorySort::Density, fields::DENSITY),
    ("copies", HistorySort::Copies, fields::COPIES),
    ("machine", HistorySort::Machine, fields::MACHINE),
];

/// The sorted rows of one page.
pub(crate) async fn list_rows(web: &DashboardState, filter: &HistoryFilter) -> HandlerResult<Vec<DatedBuild>> {
    Ok(read_page(web, filter).await?.0)
}

/// Translates the filter into a query of the ledger.
fn ledger_query(web: &DashboardState, filter: &HistoryFilter) -> HandlerResult<HistoryQuery> {
    let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let zone = &web.current_settings().time_zone;
    Ok(HistoryQuery {
        since: parse_day(&filter.since, 0, zone)?,
        until: parse_day(&filter.until, 1, zone)?,
        machine: some(&filter.machine),
        state: parse_field(&filter.state, &say!("a-state-of-build"))?,
        part: some(&filter.part),
        sort: SORT_COLUMNS
            .iter()
            .find(|(word, ..)| *word == filter.sort)
            .map_or(HistorySort::Newest, |&(_, sort, _)| sort),
        after: parse_field::<i64>(&filter.after, &say!("the-number-of-build"))?.map(BuildId),
        limit: Some(MAX_ROWS + 1),
    })
}

/// The rows of one page, and whether more rows follow.
async fn read_page(web: &DashboardState, filter: &HistoryFilter) -> HandlerResult<(Vec<DatedBuild>, bool)> {
    let mut rows = web.ledger.read_history(&ledger_query(web, filter)?).await?;
    let more = rows.len() > MAX_ROWS as usize;
    rows.truncate(MAX_ROWS as usize);
    let settings = web.current_settings();
    Ok((DatedBuild::of_rows(&web.ledger, settings.profiles.values(), rows, Timestamp::now()).await?, more))
}

/// Parses a date; returns the start of the day that is `later` days after it.
fn parse_day(text: &str, later: i64, zone: &FarmZone) -> HandlerResult<Option<Timestamp>> {
    if text.is_empty() {
        return Ok(None);
    }
    let moment =
        text.parse::<Date>().and_then(|date| date.checked_add(later.days())?.to_zoned(zone.time_zone().clone()));
    match moment {
        Ok(zoned) => Ok(Some(zoned.timestamp())),
        Err(_) => Err(HandlerError::Refused(StatusCode::BAD_REQUEST, say!("is-no-date", text = text))),
    }
}

/// The sums of the published builds that match the filter, over all pages.
pub(crate) async fn read_height_sums(
    web: &DashboardState,
    filter: &HistoryFilter,
) -> HandlerResult<Vec<HeightSummary>> {
    Ok(web.ledger.height_summaries(&ledger_query(web, filter)?).await?)
}

/// The history page.
pub(crate) async fn show_history(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<HistoryFilter>,
) -> HandlerResult<Markup> {
    let (rows, more) = read_page(&web, &filter).await?;
    let sums = HeightSummary::with_total(read_height_sums(&web, &filter).await?);
    let next =
        rows.last().filter(|_| more).map(|last| HistoryFilter { after: last.row.build.to_string(), ..filter.clone() });
    let settings = web.current_settings();
    let view = web.time_view();
    let next = next.map(|next| query_string(&next)).transpose()?;
    let query = query_string(&filter)?;
    let content = html! {
        h1 { (say!("nav-history")) }
        (filter_form(&filter, Timestamp::now().to_zoned(settings.time_zone.time_zone().clone()).date(), settings.profiles.keys()))
        (sums_table(&sums, &view))
        (chart::history_charts(rows.iter().map(|dated| &dated.row), &settings.time_zone))
        (history_table(&rows, &filter, &view))
        p.links { a href=(format!("/history.csv?{query}")) download { (say!("csv-all-columns")) }
            a href=(format!("/history.json?{query}")) download { "JSON" } }
        @if let Some(next) = next {
            p { a rel="next" href=(format!("/history?{next}")) { (say!("next-builds")) } }
        }
    };
    Ok(html_page(&say!("nav-history"), "/history", None, &content))
}

fn filter_form<'a>(filter: &HistoryFilter, today: Date, machines: impl Iterator<Item = &'a String>) -> Markup {
    let states: Vec<String> =
        BuildState::ALL.iter().filter(|state| state.is_past_nesting()).map(BuildState::to_string).collect();
    html! {
        form.filters method="get" action="/history" {
            label { (fields::MACHINE.said()) select name="machine" {
                option value="" { (say!("all-machines")) }
                @for name in machines { option value=(name) selected[*name == filter.machine] { (name) } }
            } }
            label { (fields::OUTCOME.said()) select name="state" {
                option value="" { (say!("all")) }
                @for state in &states { option value=(state) selected[*state == filter.state] { (state_text(state)) } }
            } }
            label { (say!("part-or-order")) input name="part" value=(filter.part); }
            label { (fields::SINCE.said()) input type="date" name="since" value=(filter.since); }
            label { (say!("until")) input type="date" name="until" value=(filter.until); }
            label { (say!("sorted-by-what")) select name="sort" {
                option value="" { (say!("newest-first")) }
                @for (word, _, field) in &SORT_COLUMNS { option value=(word) selected[*word == filter.sort] { (field.page_heading()) } }
            } }
            button type="submit" { (say!("show")) }
            span { @for days in QUICK_SPANS {
                @let since = today.saturating_sub(days.days());
                a href=(format!("/history?since={since}")) { (say!("days", days = days)) } " "
            } }
        }
    }
}

fn sums_table(sums: &[HeightSummary], view: &TimeView) -> Markup {
    let caption = say!("published-in-time");
    html! { @if !sums.is_empty() { (table_of(&say!("heights"), Some(caption), HEIGHT_SUM_COLUMNS, sums, view)) } }
}

fn history_table(rows: &[DatedBuild], filter: &HistoryFilter, view: &TimeView) -> Markup {
    let order = match filter.sort.as_str() {
        "" => say!("the-newest-first"),
        sort => say!("sorted-by", sort = sort),
    };
    let caption = language::join_names([say!("count-builds", count = rows.len()), order]);
    html! {
        @if rows.is_empty() { (empty(&say!("no-builds"), &html! { (say!("none-matches")) }, &html! { a.button href="/history" { (say!("all-builds")) } })) }
        @else { (table_of_keys((&fields::BUILDS.said(), Some(caption)), HISTORY_COLUMNS, &HISTORY_PAGE_KEYS, rows, view)) }
    }
}

/// The shown builds as CSV.
pub(crate) async fn download_csv(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<HistoryFilter>,
) -> HandlerResult<Response> {
    let text = csv_of(HISTORY_COLUMNS, &list_rows(&web, &filter).await?).map_err(anyhow::Error::from)?;
    let name = "attachment; filename=\"nestd-history.csv\"";
    Ok(([(header::CONTENT_TYPE, "text/csv; charset=utf-8"), (header::CONTENT_DISPOSITION, name)], text).into_response())
}

/// The shown builds as JSON.
pub(crate) async fn download_json(
    State(web): State<Arc<DashboardState>>,
    Query(filter): Query<HistoryFilter>,
) -> HandlerResult<Response> {
    let name = "attachment; filename=\"nestd-history.json\"";
    let rows = list_rows(&web, &filter).await?;
    Ok(([(header::CONTENT_DISPOSITION, name)], axum::Json(rows)).into_response())
}
