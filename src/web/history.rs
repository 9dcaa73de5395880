//! The history: builds with their heights, filtered and sorted, as a page, CSV or JSON of exactly what is shown.

use std::sync::Arc;

use axum::{
    extract::{Query, State},
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use jiff::{Timestamp, ToSpan, civil::Date, tz::TimeZone};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    asked::{known, query},
    chart,
    listing::table_of,
    page::page,
    problem::{Answer, Problem},
    state::Web,
    words::count,
};
use crate::{
    ledger::{BuildId, BuildState, HeightSum, HistoryQuery, HistoryRow, HistorySort},
    tables::{FieldDefinition, HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS, csv_of, fields},
};

/// Builds on a page.
const MOST_ROWS: u32 = 500;

/// What is asked for; empty fields ask for nothing.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(super) struct Asked {
    /// Of one machine profile.
    #[serde(skip_serializing_if = "String::is_empty")]
    profile: String,
    /// In one state.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "BuildState")]
    state: String,
    /// That hold a part of this file name or order.
    #[serde(skip_serializing_if = "String::is_empty")]
    part: String,
    /// From this day on, UTC.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(extend("format" = "date"))]
    since: String,
    /// Up to this day, UTC.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(extend("format" = "date"))]
    until: String,
    /// By this column; the newest first where it is not said.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(extend("enum" = SORTED.map(|(word, ..)| word)))]
    sort: String,
    /// Those that come after this build in that order: the last one of the page before.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(with = "i64")]
    after: String,
}

/// What a page can be sorted by beside the newest, with the field that it is sorted by.
const SORTED: [(&str, HistorySort, FieldDefinition); 4] = [
    ("height", HistorySort::Height, fields::HEIGHT),
    ("density", HistorySort::Density, fields::DENSITY),
    ("copies", HistorySort::Copies, fields::COPIES),
    ("profile", HistorySort::Profile, fields::PROFILE),
];

/// The rows of a page that are asked for, sorted.
pub(super) async fn rows(web: &Web, asked: &Asked) -> Answer<Vec<HistoryRow>> {
    Ok(page_of(web, asked).await?.0)
}

/// What is asked of the ledger.
fn query_of(asked: &Asked) -> Answer<HistoryQuery> {
    let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    Ok(HistoryQuery {
        since: day(&asked.since, 0)?,
        until: day(&asked.until, 1)?,
        profile: some(&asked.profile),
        state: known(&asked.state, "a state of a build")?,
        part: some(&asked.part),
        sort: SORTED.iter().find(|(word, ..)| *word == asked.sort).map_or(HistorySort::Newest, |&(_, sort, _)| sort),
        after: known::<i64>(&asked.after, "the number of a build")?.map(BuildId),
        limit: Some(MOST_ROWS + 1),
    })
}

/// The rows of a page, and whether there are more.
async fn page_of(web: &Web, asked: &Asked) -> Answer<(Vec<HistoryRow>, bool)> {
    let mut rows = web.ledger.history(&query_of(asked)?).await?;
    let more = rows.len() > MOST_ROWS as usize;
    rows.truncate(MOST_ROWS as usize);
    Ok((rows, more))
}

/// The first moment of a day, UTC, or of the day `later` days after it.
fn day(text: &str, later: i64) -> Answer<Option<Timestamp>> {
    if text.is_empty() {
        return Ok(None);
    }
    let moment = text.parse::<Date>().and_then(|date| date.checked_add(later.days())?.to_zoned(TimeZone::UTC));
    match moment {
        Ok(zoned) => Ok(Some(zoned.timestamp())),
        Err(_) => Err(Problem::Refused(StatusCode::BAD_REQUEST, format!("'{text}' is no date such as 2026-11-20"))),
    }
}

/// What the published builds come to that are asked for, on all pages.
pub(super) async fn sums(web: &Web, asked: &Asked) -> Answer<Vec<HeightSum>> {
    Ok(web.ledger.height_sums(&query_of(asked)?).await?)
}

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Markup> {
    let (rows, more) = page_of(&web, &asked).await?;
    let sums = HeightSum::with_all(sums(&web, &asked).await?);
    let next = rows.last().filter(|_| more).map(|last| Asked { after: last.build.to_string(), ..asked.clone() });
    let settings = web.settings();
    let next = next.map(|next| query(&next)).transpose()?;
    let query = query(&asked)?;
    let content = html! {
        h1 { "History" }
        (filters(&asked, settings.profiles.keys()))
        p { a href=(format!("/history.csv?{query}")) download { "CSV" } " · "
            a href=(format!("/history.json?{query}")) download { "JSON" } " of what is shown" }
        (sums_table(&sums))
        (chart::charts(&rows))
        (table(&rows, &asked))
        @if let Some(next) = next {
            p { a rel="next" href=(format!("/history?{next}")) { "The builds that come after these" } }
        }
    };
    Ok(page("History", "/history", None, &content))
}

fn filters<'a>(asked: &Asked, profiles: impl Iterator<Item = &'a String>) -> Markup {
    let states: Vec<String> =
        BuildState::ALL.iter().filter(|state| state.is_past_nesting()).map(BuildState::to_string).collect();
    html! {
        form.filters method="get" action="/history" {
            label { (fields::PROFILE.label) select name="profile" {
                option value="" { "all" }
                @for name in profiles { option value=(name) selected[*name == asked.profile] { (name) } }
            } }
            label { "Outcome" select name="state" {
                option value="" { "all" }
                @for state in &states { option value=(state) selected[*state == asked.state] { (state) } }
            } }
            label { "Part or order, whole name" input name="part" value=(asked.part); }
            label { "Since" input type="date" name="since" value=(asked.since); }
            label { "Until" input type="date" name="until" value=(asked.until); }
            label { "Sorted by" select name="sort" {
                option value="" { "newest first" }
                @for (word, _, field) in &SORTED { option value=(word) selected[*word == asked.sort] { (field.page_heading()) } }
            } }
            button type="submit" { "Show" }
        }
    }
}

fn sums_table(sums: &[HeightSum]) -> Markup {
    let caption = "What was published in that time".to_owned();
    html! { @if !sums.is_empty() { (table_of("Heights", Some(caption), HEIGHT_SUM_COLUMNS, sums)) } }
}

fn table(rows: &[HistoryRow], asked: &Asked) -> Markup {
    let order = match asked.sort.as_str() {
        "" => "the newest first".to_owned(),
        sort => format!("sorted by {sort}"),
    };
    let caption = format!("{}, {order}", count(rows.len() as u32, "build", "builds"));
    html! {
        @if rows.is_empty() { p { "No builds." } } @else { (table_of("Builds", Some(caption), HISTORY_COLUMNS, rows)) }
    }
}

/// What is shown, as CSV.
pub(super) async fn csv(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Response> {
    let text = csv_of(HISTORY_COLUMNS, &rows(&web, &asked).await?).map_err(anyhow::Error::from)?;
    let name = "attachment; filename=\"nestd-history.csv\"";
    Ok(([(header::CONTENT_TYPE, "text/csv; charset=utf-8"), (header::CONTENT_DISPOSITION, name)], text).into_response())
}

/// What is shown, as JSON.
pub(super) async fn json(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Response> {
    let name = "attachment; filename=\"nestd-history.json\"";
    let rows = rows(&web, &asked).await?;
    Ok(([(header::CONTENT_DISPOSITION, name)], axum::Json(rows)).into_response())
}
