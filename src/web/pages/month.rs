//! The report of a month: what each machine made, against the month before; what came late, and what failed.

use std::{collections::BTreeMap, sync::Arc};

use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use farm::{CostReport, DateRisk, dates_at_risk, read_late_parts};
use jiff::{
    Timestamp, ToSpan,
    civil::{Date, date},
};
use language::{colon, comma, say};
use ledger::{BuildState, CostQuery, HistoryQuery, HistoryRow, LatePart};
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use settings::FarmZone;

use super::farm::risk_row;
use crate::{
    tables::{GivenDate, MONTH_COLUMNS, MachineOutput, TimeView, csv_of, fields, people_columns},
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            format::DASH,
            listing::heading,
            page::html_page,
            query::{Query, order_address},
        },
        core::state::DashboardState,
        figures::chart::weekly_bars,
        look::{
            chip::{Tone, chip},
            pieces::{figure, figure_link},
            times::{due_of, time_of},
        },
    },
};

/// Which month is asked for.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct MonthQuestion {
    /// The month, such as 2026-10, in the time zone of the farm; the current one if empty.
    at: String,
}

/// What a month came to.
#[derive(Serialize, JsonSchema)]
pub(crate) struct MonthResponse {
    /// The month, such as 2026-10.
    month: String,
    /// What each machine made, and their sum if there are several.
    machines: Vec<MachineOutput>,
    /// The same for the month before; for a month that is not over, for as many days of it.
    before: Vec<MachineOutput>,
    /// Parts with a due date in this month that came late or are late. Where nobody told that a print ended, that is an estimate.
    late: Vec<LatePart>,
    /// Due dates in this month that will be missed, according to the plan.
    will_be_late: Vec<DateRisk>,
    /// Builds of this month that failed or were interrupted.
    failed: Vec<HistoryRow>,
}

/// A month of a farm.
pub(super) struct FarmMonth {
    first: Date,
    zone: FarmZone,
}

impl FarmMonth {
    pub(super) fn parse(text: &str, zone: &FarmZone, now: Timestamp) -> HandlerResult<Self> {
        let today = now.to_zoned(zone.time_zone().clone()).date();
        let first = match text.trim() {
            "" => Some(today.first_of_month()),
            text => {
                format!("{text}-01").parse::<Date>().ok().filter(|first| first.strftime("%Y-%m").to_string() == text)
            }
        };
        let in_range = first.filter(|first| (date(1970, 2, 1)..date(9990, 1, 1)).contains(first));
        let wrong = || HandlerError::Refused(StatusCode::BAD_REQUEST, say!("is-no-month", text = text));
        Ok(Self { first: in_range.ok_or_else(wrong)?, zone: zone.clone() })
    }

    /// The month that is this many months later.
    fn later(&self, months: i64) -> Self {
        Self { first: self.first.saturating_add(months.months()), zone: self.zone.clone() }
    }

    fn begins_at(&self) -> Timestamp {
        let begin = self.first.to_zoned(self.zone.time_zone().clone());
        begin.map_or(Timestamp::MIN, |begin| begin.timestamp())
    }

    pub(super) fn span(&self) -> (Timestamp, Timestamp) {
        (self.begins_at(), self.later(1).begins_at())
    }

    /// What it is compared with: the month before, or as much of it as is over of a month that is not.
    fn span_before(&self, now: Timestamp) -> (Timestamp, Timestamp) {
        let (begins_at, until) = self.later(-1).span();
        match self.is_over(now) {
            true => (begins_at, until),
            false => (begins_at, until.min(begins_at + now.duration_since(self.begins_at()))),
        }
    }

    fn is_over(&self, now: Timestamp) -> bool {
        self.later(1).begins_at() <= now
    }

    pub(super) fn key(&self) -> String {
        self.first.strftime("%Y-%m").to_string()
    }

    fn name(&self) -> String {
        language::month_text(self.first.month(), self.first.year())
    }
}

/// The builds of a span of time, and what each machine made.
async fn read_output(
    web: &DashboardState,
    (since, until): (Timestamp, Timestamp),
) -> HandlerResult<(Vec<HistoryRow>, Vec<MachineOutput>)> {
    let query = HistoryQuery { since: Some(since), until: Some(until), ..HistoryQuery::default() };
    let rows = web.ledger.read_history(&query).await?;
    let bad = web.ledger.bad_copies_between(since, until).await?;
    let settings = web.current_settings();
    let hours: BTreeMap<String, f64> =
        settings.profiles.iter().map(|(name, profile)| (name.clone(), profile.space.print_hours_per_mm)).collect();
    let costed = CostQuery { since: Some(since), until: Some(until), ..CostQuery::default() };
    let powder = CostReport::read(&web.ledger, &costed, &settings.profiles).await?.powder_of_machines();
    let machines = MachineOutput::of_history(&rows, &bad, &hours, &powder);
    Ok((rows, machines))
}

async fn read_month(
    web: &DashboardState,
    month: &FarmMonth,
    now: Timestamp,
) -> HandlerResult<(Vec<HistoryRow>, MonthResponse)> {
    let (rows, machines) = read_output(web, month.span()).await?;
    let (_, before) = read_output(web, month.span_before(now)).await?;
    let (settings, plans) = (web.current_settings(), web.read_plans().await?);
    let late = read_late_parts(&web.ledger, &settings.profiles, &plans, month.span(), now).await?;
    let span = month.begins_at()..month.later(1).begins_at();
    let is_new = |risk: &DateRisk| !late.iter().any(|part| risk.numbers.contains(&part.part));
    let mut will_be_late = dates_at_risk(plans);
    will_be_late.retain(|risk| risk.is_late && span.contains(&risk.due_at.0) && is_new(risk));
    let is_bad = |state: BuildState| matches!(state, BuildState::Failed | BuildState::Interrupted);
    let failed = |row: &&HistoryRow| is_bad(row.state) && row.withdrawn_at.is_none();
    let failed = rows.iter().filter(failed).cloned().collect();
    Ok((rows, MonthResponse { month: month.key(), machines, before, late, will_be_late, failed }))
}

/// The days of all weeks that have a day of a month, and the builds of these days.
async fn read_weeks(web: &DashboardState, month: &FarmMonth) -> HandlerResult<((Date, Date), Vec<HistoryRow>)> {
    let monday = |day: Date| day.saturating_sub(i64::from(day.weekday().to_monday_zero_offset()).days());
    let last = month.later(1).first.saturating_sub(1.days());
    let days = (monday(month.first), monday(last).saturating_add(7.days()));
    let at = |day: Date| day.to_zoned(month.zone.time_zone().clone()).map(|begin| begin.timestamp()).ok();
    let query = HistoryQuery { since: at(days.0), until: at(days.1), ..HistoryQuery::default() };
    Ok((days, web.ledger.read_history(&query).await?))
}

/// The page of a month.
pub(crate) async fn show_month(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<MonthQuestion>,
) -> HandlerResult<Markup> {
    let now = Timestamp::now();
    let month = FarmMonth::parse(&asked.at, &web.current_settings().time_zone, now)?;
    let (_, report) = read_month(&web, &month, now).await?;
    let (weeks, rows) = read_weeks(&web, &month).await?;
    let (before, after, view) = (month.later(-1), month.later(1), web.time_view());
    let content = html! {
        h1 { (month.name()) }
        (month_links(&month, &before, (after.begins_at() <= now).then_some(&after)))
        (figures(&report))
        (output_table(&report, &if month.is_over(now) { before.name() } else { say!("as-many-days", month = before.name()) }))
        p.soft { (say!("month-text")) }
        (weekly_bars(&say!("height-by-week"), &rows, weeks, &month.zone, &|row| row.measures.height_mm))
        (late_section(&report, &view))
        (failed_section(&report.failed, &view))
        p.links {
            a href=(format!("/month.csv?at={}", month.key())) { "CSV" }
            a href=(format!("/month.json?at={}", month.key())) { "JSON" }
            a href=(format!("/costs?at={}", month.key())) { (say!("costs")) }
        }
    };
    Ok(html_page(&month.name(), "/month", None, &content))
}

/// The month in numbers: those of all machines.
fn figures(report: &MonthResponse) -> Markup {
    let late = report.late.len() + report.will_be_late.len();
    html! {
        @if let Some(all) = report.machines.last() {
            ul.figures {
                (figure(&all.builds.to_string(), &say!("figure-builds", count = all.builds), None))
                (figure(&all.copies.to_string(), &say!("figure-copies-made", count = all.copies), None))
                @if let Some(litres) = fields::PART_LITRES.with_unit(all.part_litres) { (figure(&litres, &say!("figure-of-parts"), None)) }
                @if let Some(hours) = all.print_hours.and_then(|hours| fields::PRINT_HOURS.with_unit(hours)) { (figure(&hours, &say!("figure-machine-time"), None)) }
                @if let Some(share) = all.yield_share.and_then(|share| fields::YIELD.with_unit(share)) { (figure(&share, &say!("figure-yield"), None)) }
                (figure_link(&late.to_string(), &say!("figure-late-parts"), (late > 0).then_some(Tone::Wrong), "#late"))
                (figure_link(&report.failed.len().to_string(), &say!("figure-failed", count = report.failed.len()), (!report.failed.is_empty()).then_some(Tone::Wrong), "#failed"))
            }
        }
    }
}

/// The builds that failed, each with why.
fn failed_section(failed: &[HistoryRow], view: &TimeView) -> Markup {
    html! {
        h2 #failed { (say!("failed-builds")) }
        @if failed.is_empty() { p { (say!("none")) } }
        @else { ul { @for row in failed { li {
            (phrase!("link-on-machine", link = html! { a href=(format!("/builds/{}", row.build)) { (say!("build-number", build = row.build.to_string())) } }, machine = &row.machine)) " " (chip(&row.state.to_string()))
            (comma()) (time_of(row.at, view))
            @if let Some(height) = fields::HEIGHT.with_unit(row.measures.height_mm) { (comma()) (height) }
            @if let Some(copies) = row.measures.copies { (comma()) (say!("count-copies", count = copies)) }
            @if !row.result.reason.is_empty() { (colon()) (language::told(&row.result.reason)) }
        } } } }
    }
}

fn month_links(month: &FarmMonth, before: &FarmMonth, after: Option<&FarmMonth>) -> Markup {
    html! {
        form.filters method="get" action="/month" {
            a.button rel="prev" href=(format!("/month?at={}", before.key())) { (before.name()) }
            @if let Some(after) = after { a.button rel="next" href=(format!("/month?at={}", after.key())) { (after.name()) } }
            label { (say!("nav-month")) input type="month" name="at" value=(month.key()) pattern="[0-9]{4}-[0-9]{2}" placeholder="2026-10"; }
            button type="submit" { (say!("show")) }
        }
    }
}

/// A row per machine, each figure with that of the month before.
fn output_table(report: &MonthResponse, before: &str) -> Markup {
    let columns = people_columns(MONTH_COLUMNS, &[report.machines.as_slice(), &report.before].concat());
    html! {
        div.wide.listed tabindex="0" role="region" aria-label=(fields::MACHINES.said()) {
            table {
                caption { (say!("month-caption", before = before)) }
                thead { tr { @for column in &columns { (heading(&column.field)) } } }
                tbody { @for machine in &report.machines {
                    @let last = report.before.iter().find(|other| other.machine == machine.machine);
                    tr { @for column in &columns {
                        td class=(if column.field.is_number() { "n" } else { "title" }) data-of=(column.field.page_heading()) {
                            (column.field.plain_text(&(column.value)(machine)).unwrap_or_else(|| DASH.to_owned()))
                            @if column.field.is_number() {
                                " " small.soft { (last.and_then(|last| column.field.plain_text(&(column.value)(last))).unwrap_or_else(|| DASH.to_owned())) }
                            }
                        }
                    } }
                } }
            }
        }
    }
}

fn late_section(report: &MonthResponse, view: &TimeView) -> Markup {
    let late = &report.late;
    let mut orders: BTreeMap<&str, Vec<&LatePart>> = BTreeMap::new();
    for part in late {
        orders.entry(part.order_name.as_str()).or_default().push(part);
    }
    html! {
        h2 #late { (say!("late")) }
        @if late.is_empty() && report.will_be_late.is_empty() { p { (say!("nothing-late")) } }
        @if !report.will_be_late.is_empty() {
            ul.rows { @for risk in &report.will_be_late { (risk_row(risk, view)) } }
        }
        @if !late.is_empty() {
            p { (say!("late-text", parts = late.len(), orders = orders.len())) }
            ul { @for (order, parts) in &orders { li {
                @if order.is_empty() { (say!("without-order")) } @else { a href=(order_address(order)) { (order) } }
                ul { @for part in parts { li {
                    (phrase!("link-on-machine", link = html! { a href=(format!("/parts/{}", part.part)) { (part.name) } }, machine = &part.machine))
                    @if let Some(due) = GivenDate::new(Some(part.due_at), &part.due_text) { (comma()) (phrase!("due-on", due = due_of(&due, view))) }
                    @match part.done_at {
                        Some(at) if part.is_estimated => { (comma()) (phrase!("done-about-untold", time = time_of(at, view))) }
                        Some(at) => { (comma()) (phrase!("done-at", time = time_of(at, view))) }
                        None => { " " (chip(&part.state.to_string())) }
                    }
                } } }
            } } }
        }
    }
}

/// What each machine made, as CSV.
pub(crate) async fn download_csv(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<MonthQuestion>,
) -> HandlerResult<Response> {
    let month = FarmMonth::parse(&asked.at, &web.current_settings().time_zone, Timestamp::now())?;
    let (_, machines) = read_output(&web, month.span()).await?;
    let text = csv_of(MONTH_COLUMNS, &machines).map_err(anyhow::Error::from)?;
    let name = format!("attachment; filename=\"nestd-{}.csv\"", month.key());
    Ok(([(header::CONTENT_TYPE, "text/csv; charset=utf-8".to_owned()), (header::CONTENT_DISPOSITION, name)], text)
        .into_response())
}

/// The month as JSON.
pub(crate) async fn get_month(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<MonthQuestion>,
) -> HandlerResult<Json<MonthResponse>> {
    let now = Timestamp::now();
    let month = FarmMonth::parse(&asked.at, &web.current_settings().time_zone, now)?;
    Ok(Json(read_month(&web, &month, now).await?.1))
}
