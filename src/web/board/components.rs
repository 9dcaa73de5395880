//! All components on one page: for whoever makes a page, and for the tests in a browser.

use std::{collections::BTreeMap, sync::Arc};

use axum::extract::State;
use farm::{DatesKept, PlanStage, PlannedBuild};
use jiff::{SignedDuration, Timestamp};
use ledger::{BuildId, UtcTimestamp};
use maud::{Markup, html};
use settings::FarmZone;

use super::{
    axis::TimeAxis,
    job::{Job, JobSetting, later_job},
};
use crate::{
    tables::{GivenDate, TimeView},
    web::{
        base::page::html_page,
        core::state::DashboardState,
        look::{
            chip::{Tone, chip, chip_of},
            pieces::{empty, figure, row},
            times::{due_of, time_of},
        },
    },
};

/// The page.
pub(crate) async fn show_components(State(web): State<Arc<DashboardState>>) -> Markup {
    let view = web.time_view();
    let content = html! {
        // For who makes pages: it stays English.
        div lang="en" translate="no" {
        h1 { "Components" }
        p.soft { "What the pages are made of." }
        h2 { "Chips" }
        div.rows { @for tone in Tone::ALL { div.row {
            @for word in tone.words() { (chip(word)) }
        } } }
        h2 { "Times" }
        (times(&view))
        h2 { "Figures" }
        ul.figures {
            (figure("3 of 6", "printers print", None)) (figure("214", "copies wait", None))
            (figure("2", "late", Some(Tone::Wrong))) (figure("1", "tight", Some(Tone::Tight)))
        }
        h2 { "Rows" }
        ul.rows {
            (row("/orders", "A-17", &html! { (chip("late")) " 3 of 12 copies are good" }))
            (row("/history", "Build 1182 on mjf-5200", &html! { (chip("printing")) " 184.2 mm, 40 copies" }))
        }
        h2 { "Builds on the board" }
        (builds(&view, &web.current_settings().time_zone))
        h2 { "Buttons and fields" }
        div.buttons {
            button.first type="button" { "What comes next" } button type="button" { "Something else" } a.button href="/help" { "Another page" }
            button type="button" disabled { "Not now" }
        }
        div.tell {
            label { "A field" input value="bracket.stl"; }
            label { "A choice" select { option { "any way" } option { "upright" } } }
            label.check { input type="checkbox" checked; "A yes" }
        }
        h2 { "Messages" }
        p.bad role="status" { "Build 7 failed: the bed moved." }
        p.ok { "Build 8 is complete." }
        details { summary { "Details" } p { "What only some need." } }
        h2 { "Nothing there" }
        (empty("No orders yet", &html! { "An order begins with its first file." }, &html! { a.button.first href="/" { "Add files" } }))
        }
    };
    html_page("Components", "/components", None, &content)
}

/// Builds in each of their stages, with dates that are kept, and not.
fn builds(view: &TimeView, zone: &FarmZone) -> Markup {
    let now = view.now().unwrap_or_else(Timestamp::now);
    let (axis, layouts) = (TimeAxis::new(now, zone), BTreeMap::new());
    let setting = JobSetting { axis: &axis, view, layouts: &layouts };
    let at = |hours: i64| UtcTimestamp(now.checked_add(SignedDuration::from_hours(hours)).unwrap_or(now));
    let build = |(number, stage, dates, begins): (i64, PlanStage, DatesKept, i64)| PlannedBuild {
        build: Some(BuildId(number)),
        stage,
        printer: Some("left".to_owned()),
        copies: 40,
        height_mm: 184.2,
        is_nested: stage != PlanStage::Later,
        fires_at: (stage >= PlanStage::Open).then(|| at(begins - 1)),
        fires_by: None,
        begins_at: Some(at(begins)),
        printed_at: Some(at(begins + 6)),
        ends_at: Some(at(begins + 11)),
        dates,
        awaits_release: number == 15,
        parts: Vec::new(),
    };
    let shown = [
        (11, PlanStage::Ended, DatesKept::Kept, -13),
        (12, PlanStage::Printing, DatesKept::Kept, -1),
        (13, PlanStage::Queued, DatesKept::Tight, 11),
        (14, PlanStage::Made, DatesKept::NoDate, 23),
        (15, PlanStage::Made, DatesKept::Kept, 35),
        (16, PlanStage::Open, DatesKept::Late, 47),
        (17, PlanStage::Later, DatesKept::Kept, 59),
    ];
    let shown = shown.map(build);
    html! {
        div.board {
            (axis.draw())
            div.machine { div.machine-head { h3 { "mjf-5200 " (chip("printing")) } }
                div.lanes { div.lane { div.track {
                    (axis.lines())
                    ol.jobs aria-label="Builds of left" { @for job in shown.iter().filter_map(|build| Job::on_axis(build, &axis, at(0))) { (job.draw(&setting, None)) } }
                } }
                ol.jobs.later aria-label="Later builds" { (later_job(&shown[5], &setting)) } }
            }
        }
    }
}

/// Times near and far.
fn times(view: &TimeView) -> Markup {
    let now = view.now().unwrap_or_else(Timestamp::now);
    let after = |hours: i64| now.checked_add(SignedDuration::from_hours(hours)).unwrap_or(now);
    let day = |hours: i64| after(hours).strftime("%F").to_string();
    let due = |hours: i64| GivenDate { due_at: after(hours).into(), text: day(hours) };
    html! {
        div.rows {
            div.row { @for hours in [-30, 0, 20, 120, 9000] { span { (time_of(after(hours).into(), view)) } } }
            div.row { @for (hours, word) in [(0, "late"), (24, "tight"), (120, "kept")] {
                span { (chip(word)) " due " (due_of(&due(hours), view)) }
            } span { (chip_of(Tone::Idle, "no date")) } }
        }
    }
}
