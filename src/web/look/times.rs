//! Times as people say them; the exact one is for programs, and shows when one points at it.

use ledger::UtcTimestamp;
use maud::{Markup, html};

use super::chip::{Tone, chip_of};
use crate::tables::{GivenDate, PromisedDate, TimeView};

/// A time: `today 15:32`.
pub(crate) fn time_of(at: UtcTimestamp, view: &TimeView) -> Markup {
    html! { time datetime=(at) title=(view.time_text(at)) { (view.near_text(at)) } }
}

/// A time that nobody told: `about today 15:32`.
pub(crate) fn estimate_of(at: UtcTimestamp, view: &TimeView) -> Markup {
    phrase!("about-time", time = time_of(at, view))
}

/// A due date: `Fri 4 Dec`.
pub(crate) fn due_of(due: &GivenDate, view: &TimeView) -> Markup {
    html! { time datetime=(due.due_at) title=(view.due_text(due)) { (view.near_due_text(due)) } }
}

/// When something will be done, with a chip that says by how much that is late.
pub(crate) fn promise_of(promise: &PromisedDate, view: &TimeView) -> Markup {
    html! {
        @if promise.is_estimated { (estimate_of(promise.done_at, view)) } @else { (time_of(promise.done_at, view)) }
        @if let Some(late) = promise.late_text() { " " (chip_of(Tone::Wrong, &late)) }
    }
}
