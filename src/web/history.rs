//! The history: builds with their heights, filtered and sorted, as a page, CSV or JSON of exactly what is shown.

use std::sync::Arc;

use axum::{
    extract::{Query, State},
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use jiff::{Timestamp, ToSpan, civil::Date, tz::TimeZone};
use maud::{Markup, html};
use serde::{Deserialize, Serialize};

use super::{
    asked::{known, query},
    chart,
    page::page,
    problem::{Answer, Problem},
    state::Web,
    words::{count, number, or_dash, percent, text, time},
};
use crate::ledger::{BuildId, HeightSum, HistoryQuery, HistoryRow, HistorySort};

/// Builds on a page.
const MOST_ROWS: u32 = 500;

/// What is asked for; empty fields ask for nothing.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Asked {
    #[serde(skip_serializing_if = "String::is_empty")]
    profile: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    state: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    part: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    since: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    until: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    sort: String,
    /// The last build of the page before.
    #[serde(skip_serializing_if = "String::is_empty")]
    after: String,
}

/// Columns that a page can be sorted by.
const SORTED: [(&str, &str); 5] = [
    ("build", "Build"),
    ("height", "Height, mm"),
    ("density", "Density"),
    ("copies", "Copies"),
    ("profile", "Profile"),
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
        sort: match asked.sort.as_str() {
            "height" => HistorySort::Height,
            "density" => HistorySort::Density,
            "copies" => HistorySort::Copies,
            "profile" => HistorySort::Profile,
            _ => HistorySort::Newest,
        },
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
    let states = ["verified", "published", "printing", "complete", "interrupted", "failed"];
    html! {
        form.filters method="get" action="/history" {
            label { "Profile" select name="profile" {
                option value="" { "all" }
                @for name in profiles { option value=(name) selected[*name == asked.profile] { (name) } }
            } }
            label { "Outcome" select name="state" {
                option value="" { "all" }
                @for state in states { option value=(state) selected[state == asked.state] { (state) } }
            } }
            label { "Part or order, whole name" input name="part" value=(asked.part); }
            label { "Since" input type="date" name="since" value=(asked.since); }
            label { "Until" input type="date" name="until" value=(asked.until); }
            label { "Sorted by" select name="sort" {
                option value="" { "newest first" }
                @for (value, label) in &SORTED[1..] { option value=(value) selected[*value == asked.sort] { (label) } }
            } }
            button type="submit" { "Show" }
        }
    }
}

fn sums_table(sums: &[HeightSum]) -> Markup {
    html! {
        @if !sums.is_empty() {
            div.wide tabindex="0" role="region" aria-label="Heights" {
                table {
                    caption { "What was published in that time" }
                    thead { tr { th scope="col" { "Machine" } th.n scope="col" { "Height, mm" } th.n scope="col" { "Builds" }
                        th.n scope="col" { "Copies" } th.n scope="col" { "Mean density" } } }
                    tbody { @for sum in sums { tr {
                        td { (sum.profile) } td.n { b { (number(Some(sum.height_mm), 2)) } } td.n { (sum.builds) } td.n { (sum.copies) }
                        td.n { (percent(sum.mean_density)) }
                    } } }
                }
            }
        }
    }
}

fn table(rows: &[HistoryRow], asked: &Asked) -> Markup {
    html! {
        @if rows.is_empty() { p { "No builds." } }
        @else {
            div.wide tabindex="0" role="region" aria-label="Builds" {
                table {
                    caption { (count(rows.len() as u32, "build", "builds"))
                        @if asked.sort.is_empty() { ", the newest first" } @else { ", sorted by " (asked.sort) } }
                    thead { tr {
                        th scope="col" { "Build" } th scope="col" { "Profile" } th scope="col" { "State" }
                        th scope="col" { "Time (UTC)" } th.n scope="col" { "Height, mm" } th.n scope="col" { "Bound, mm" }
                        th.n scope="col" { "Density" } th.n scope="col" { "Used" } th.n scope="col" { "Layers" } th.n scope="col" { "Copies" }
                        th.n scope="col" { "Proved, mm" } th scope="col" { "File or reason" }
                    } }
                    tbody { @for row in rows { tr {
                        td { a href=(format!("/builds/{}", row.build)) { (row.build) } }
                        td { (row.profile) } td { (row.state) } td { (time(Some(row.at))) }
                        td.n { (number(row.height_mm, 2)) } td.n { (number(row.lower_bound_mm, 2)) }
                        td.n { (percent(row.density)) } td.n { (percent(row.used())) } td.n { (or_dash(row.layers)) } td.n { (or_dash(row.copies)) }
                        td.n { (number(row.clearance_proved_mm, 3)) }
                        td { (row.file_name.as_deref().unwrap_or_else(|| text(&row.reason))) }
                    } } }
                }
            }
        }
    }
}

/// What is shown, as CSV.
pub(super) async fn csv(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Response> {
    let text = HistoryRow::csv(&rows(&web, &asked).await?).map_err(anyhow::Error::from)?;
    let name = "attachment; filename=\"nestd-history.csv\"";
    Ok(([(header::CONTENT_TYPE, "text/csv; charset=utf-8"), (header::CONTENT_DISPOSITION, name)], text).into_response())
}

/// What is shown, as JSON.
pub(super) async fn json(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Response> {
    let name = "attachment; filename=\"nestd-history.json\"";
    let rows = rows(&web, &asked).await?;
    Ok(([(header::CONTENT_DISPOSITION, name)], axum::Json(rows)).into_response())
}
