//! Figures, rows and empty states.

use maud::{Markup, html};

use super::chip::Tone;

/// A number with its label, for a list of figures.
pub(crate) fn figure(value: &str, label: &str, tone: Option<Tone>) -> Markup {
    html! { li class=(format!("figure {}", tone.map_or("", Tone::class)).trim_end()) { b { (value) } (label) } }
}

/// A row that leads to a page: all of it is the target.
pub(crate) fn row(address: &str, name: &str, more: &Markup) -> Markup {
    html! { li { a.row href=(address) { span.row-name { (name) } span.row-more { (more) } } } }
}

/// What to do where there is nothing to show.
pub(crate) fn empty(title: &str, text: &Markup, buttons: &Markup) -> Markup {
    html! { div.empty { h2 { (title) } p { (text) } div.buttons { (buttons) } } }
}
