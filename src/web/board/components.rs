//! All components on one page: for whoever makes a page, and for the tests in a browser.

use axum::extract::State;
use jiff::{SignedDuration, Timestamp};
use maud::{Markup, html};
use std::sync::Arc;

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
    };
    html_page("Components", "/components", None, &content)
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
