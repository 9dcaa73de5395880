//! Figures, rows, sheets and empty states.

use language::say;
use ledger::PartId;
use maud::{Markup, html};

use super::chip::Tone;

/// A number with its label, for a list of figures.
pub(crate) fn figure(value: &str, label: &str, tone: Option<Tone>) -> Markup {
    html! { li class=(format!("figure {}", tone.map_or("", Tone::class)).trim_end()) { b { (value) } (label) } }
}

/// A number that leads to what it counts.
pub(crate) fn figure_link(value: &str, label: &str, tone: Option<Tone>, address: &str) -> Markup {
    html! { li class=(format!("figure {}", tone.map_or("", Tone::class)).trim_end()) { a href=(address) { b { (value) } (label) } } }
}

/// A button that opens a sheet, and the sheet: what a form needs shows when somebody wants it. It works without a script. `id` = its name
/// on the page, `is_first` = it is what a person most probably does.
pub(crate) fn sheet(id: &str, label: &str, is_first: bool, content: &Markup) -> Markup {
    html! {
        button.first[is_first] type="button" popovertarget=(id) { (label) }
        div.sheet-box #(id) popover role="dialog" aria-label=(label) {
            div.sheet-head { h2 { (label) } button.close type="button" popovertarget=(id) popovertargetaction="hide" { (say!("close")) } }
            (content)
        }
    }
}

/// Width of the thumbnail of a part, pixels; pages show it half as wide.
pub(crate) const THUMBNAIL_WIDTH: u32 = 80;

/// A picture of a page in the colours of the page; `source` is its address on a light page. Paper is light.
pub(crate) fn themed_picture(source: &str, image: &Markup) -> Markup {
    let mark = if source.contains('?') { '&' } else { '?' };
    html! { picture { source media="screen and (prefers-color-scheme: dark)" srcset=(format!("{source}{mark}scheme=dark")); (image) } }
}

/// A small picture of a part; its name stands beside it.
pub(crate) fn thumbnail(part: PartId) -> Markup {
    let source = format!("/parts/{part}/picture?width={THUMBNAIL_WIDTH}");
    themed_picture(&source, &html! { img.thumbnail loading="lazy" width="40" height="30" alt="" src=(source); })
}

/// A row that leads to a page: all of it is the target.
pub(crate) fn row(address: &str, name: &str, more: &Markup) -> Markup {
    html! { li { a.row href=(address) { span.row-name { (name) } span.row-more { (more) } } } }
}

/// What to do where there is nothing to show.
pub(crate) fn empty(title: &str, text: &Markup, buttons: &Markup) -> Markup {
    html! { div.empty { h2 { (title) } p { (text) } div.buttons { (buttons) } } }
}
