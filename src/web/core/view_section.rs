//! The 3D view of a build and, beside it, its parts by order: each side shows what is pointed at on the other.

use std::collections::BTreeMap;

use farm::CakePart;
use language::{comma, say};
use maud::{Markup, html};

use super::picture::cake_picture;
use crate::{tables::CountedPart, web::base::assets::asset_address};

/// What the view of a build shows.
pub(crate) struct ViewSection {
    /// Number of the build.
    pub(crate) build: i64,
    /// Changes with the layout of the build. A report has none: it contains its scene and its picture.
    pub(crate) version: String,
    /// Its parts.
    pub(crate) parts: Vec<ViewedPart>,
}

/// A part in the list beside the view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ViewedPart {
    part: i64,
    name: String,
    order: String,
    due: String,
    copies: u32,
}

impl ViewedPart {
    /// A part of the ledger; `due` is its due date as people read it, "" = none.
    pub(crate) fn of_counted(counted: &CountedPart, due: String) -> Self {
        let (part, copies) = (&counted.part, counted.copies);
        Self { part: part.id.0, name: part.full_name(), order: part.terms.order_name.clone(), due, copies }
    }

    /// A part of a report.
    pub(crate) fn of_cake(part: &CakePart) -> Self {
        let copies = part.copies.len() as u32;
        Self { part: part.part, name: part.name.clone(), order: part.order.clone(), due: part.due.clone(), copies }
    }
}

/// What colours can mean.
fn colourings() -> [(&'static str, String); 5] {
    [
        ("part", say!("colour-part")),
        ("order", say!("colour-order")),
        ("due", say!("colour-due")),
        ("height", say!("colour-height")),
        ("step", say!("colour-step")),
    ]
}

impl ViewSection {
    /// The view, or a picture without JavaScript.
    pub(crate) fn to_markup(&self) -> Markup {
        let copies: u32 = self.parts.iter().map(|part| part.copies).sum();
        let has_pages = !self.version.is_empty();
        html! {
            section #view data-build=(self.build) data-copies=(copies) data-version=(self.version)
                data-script=[has_pages.then(|| asset_address("view.js"))] aria-label=(say!("view-3d")) {
                @if has_pages { noscript { p { (say!("view-needs-script")) " " } } }
                @else { noscript { p { (say!("view-needs-script-report")) } } }
                div.split {
                    div {
                        div.stage {
                            // Stands there until the view is drawn, and where it cannot be drawn.
                            @if has_pages { div.poster { (cake_picture(self.build)) } }
                            canvas tabindex="0" role="img" aria-label=(say!("view-keys", copies = copies)) {}
                            p #hover role="status" { (say!("view-hint")) }
                        }
                        (view_controls())
                    }
                    (self.part_list())
                }
            }
        }
    }

    /// The parts by order.
    fn part_list(&self) -> Markup {
        let mut orders: BTreeMap<&str, Vec<&ViewedPart>> = BTreeMap::new();
        for part in &self.parts {
            orders.entry(part.order.as_str()).or_default().push(part);
        }
        html! {
            div.view-list tabindex="0" role="group" aria-label=(say!("parts-by-order")) {
                @for (order, parts) in &orders {
                    @let copies: u32 = parts.iter().map(|part| part.copies).sum();
                    button.view-order type="button" data-order=(order) aria-pressed="false" {
                        b { @if order.is_empty() { (say!("no-order")) } @else { (order) } } " " span.soft { (say!("count-copies", count = copies)) }
                    }
                    @for part in parts {
                        button.view-part type="button" data-part=(part.part) aria-pressed="false" {
                            span.swatch {} " " (part.name) " "
                            span.soft { (part.copies) "\u{d7}" @if !part.due.is_empty() { (comma()) (phrase!("due-on", due = &part.due)) } }
                        }
                    }
                }
            }
        }
    }
}

fn view_controls() -> Markup {
    html! {
        div.controls {
            label { (say!("colour-by")) " " select #colour {
                @for (word, text) in colourings() { option value=(word) { (text) } }
            } }
            label { (say!("layers-up-to")) " " output #cut-mm { } input #cut type="range" min="0" max="1000" value="1000"; }
            label { (say!("explode")) input #explode type="range" min="0" max="100" value="0"; }
            button #home type="button" { (say!("whole-view")) }
        }
        p #legend {}
    }
}
