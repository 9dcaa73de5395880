//! The pick map of a cake: what comes out, one after the other. Made for paper; `pick` shows it.

use std::sync::Arc;

use glam::DVec2;
use maud::{Markup, html};
use solids::Bounds;

use super::{
    footprint::footprint,
    labels::{Label, apart},
    listing::{cell, heading},
    words::count,
};
use crate::{
    farm::{Cake, CakePart, Standing},
    ledger::DrawnOut,
    tables::{PICK_COLUMNS, PickList, PickedCopy, TableColumn, for_people, goes_down},
};

/// Corners of a footprint are no closer, mm.
const COARSE_MM: f64 = 1.5;

/// Thickness of a band of the map, mm.
const BAND_MM: f64 = 10.0;

/// Copies of a sheet of the map when they come in a proved order.
const OF_SHEET: usize = 16;

/// A pick map as it is kept.
#[derive(Clone)]
pub(super) struct Map {
    pub(super) copies: usize,
    pub(super) sheets: Markup,
    pub(super) list: Arc<PickList>,
}

impl Map {
    /// The map of the cake of a build, with links to its parts.
    pub(super) fn of(cake: &Cake, number_of_build: i64) -> Self {
        let (picks, is_proved) = in_order(cake);
        let copies = (1..).zip(&picks).map(|(number, pick)| listed(number, pick)).collect();
        let list = Arc::new(PickList { build: number_of_build, is_proved, copies });
        let sheets = sheets(cake, (&picks, is_proved), true);
        Self { copies: cake.copies(), sheets, list }
    }
}

/// A copy to take out of the cake.
struct Pick<'c> {
    part: &'c CakePart,
    copy: u32,
    /// `None` when the original of its part is not there any more.
    bounds: Option<Bounds>,
    /// What it covers, from above.
    footprint: Vec<DVec2>,
    drawn: Option<DrawnOut>,
}

impl Pick<'_> {
    fn top_mm(&self) -> Option<f64> {
        self.bounds.map(|bounds| bounds.max.z)
    }

    fn low_mm(&self) -> Option<f64> {
        self.bounds.map(|bounds| bounds.min.z)
    }

    fn center_mm(&self) -> Option<DVec2> {
        self.bounds.map(|bounds| 0.5 * (bounds.min + bounds.max).truncate())
    }
}

fn listed(number: usize, pick: &Pick<'_>) -> PickedCopy {
    let center_mm = pick.center_mm();
    PickedCopy {
        number,
        part: pick.part.part,
        name: pick.part.name.clone(),
        order: pick.part.order.clone(),
        copy: pick.copy,
        top_mm: pick.top_mm(),
        bottom_mm: pick.low_mm(),
        center_x_mm: center_mm.map(|c| c.x),
        center_y_mm: center_mm.map(|c| c.y),
        way: pick.drawn.map(|drawn| drawn.way),
    }
}

/// What the picture beside a map shows.
pub(super) const PICTURE: &str = "The build, seen from the front, a little from the right and from above";

/// A whole map of a cake without links.
pub(super) fn map(cake: &Cake) -> Markup {
    let (picks, is_proved) = in_order(cake);
    sheets(cake, (&picks, is_proved), false)
}

/// Sheet by sheet; parts are links where there are pages.
fn sheets(cake: &Cake, (picks, is_proved): (&[Pick<'_>], bool), has_pages: bool) -> Markup {
    let sheets = if is_proved { by_number(picks) } else { by_height(picks) };
    let mut first = 1;
    html! {
        p { (if is_proved { PROVED } else { BY_HEIGHT }) " x from the left, y from the front, top and bottom from the floor." }
        @if picks.iter().any(|pick| pick.drawn.is_some_and(|drawn| goes_down(drawn.way))) { p { (DOWN) } }
        @if cake.missing() > 0 {
            p.bad { (count(cake.missing() as u32, "part is", "parts are"))
                " listed without a place: the originals are no longer kept." }
        }
        @for (title, band) in sheets {
            section.band {
                h2 { (title) }
                div.sheet {
                    (plan(first, band, cake.volume_mm.x, cake.volume_mm.y))
                    div.wide tabindex="0" role="region" aria-label=(format!("Copies: {title}")) { table {
                        thead { tr { th scope="col" { "Done" } @for column in columns(is_proved) { (heading(&column.field)) } } }
                        tbody { @for (number, pick) in (first..).zip(band) { (row(&listed(number, pick), is_proved, has_pages)) } }
                    } }
                }
            }
            @let () = first += band.len();
        }
    }
}

/// How to read a map in the proved order.
const PROVED: &str = "Each copy comes out on a straight line past all that are listed after it, as it was proved on the triangles; \
    the way says whereto.";
/// What is said of ways through the floor of the cake.
const DOWN: &str = "Copies that go down come out when the cake is lifted or turned.";
/// How to read a map without one.
const BY_HEIGHT: &str = "By height, from the top down; whether each comes out past the others is not said here.";

/// The copies in the proved order where that is known of them all, else from the top down; says which.
fn in_order(cake: &Cake) -> (Vec<Pick<'_>>, bool) {
    let mut picks = picks(cake);
    let is_proved = !picks.is_empty() && picks.iter().all(|pick| pick.drawn.is_some());
    match is_proved {
        true => picks.sort_by_key(|pick| pick.drawn.map(|drawn| drawn.place)),
        // Half an order is none.
        false => picks.iter_mut().for_each(|pick| pick.drawn = None),
    }
    (picks, is_proved)
}

fn by_number<'p, 'c>(picks: &'p [Pick<'c>]) -> Vec<(String, &'p [Pick<'c>])> {
    let title =
        |number: usize, sheet: &[Pick<'_>]| format!("{} to {}", number * OF_SHEET + 1, number * OF_SHEET + sheet.len());
    picks.chunks(OF_SHEET).enumerate().map(|(number, sheet)| (title(number, sheet), sheet)).collect()
}

fn by_height<'p, 'c>(picks: &'p [Pick<'c>]) -> Vec<(String, &'p [Pick<'c>])> {
    let layer = |pick: &Pick<'_>| pick.top_mm().map(|top_mm| (top_mm / BAND_MM).floor() as i64);
    let title = |band: &[Pick<'_>]| match layer(&band[0]) {
        Some(layer) => format!("From {} mm down", BAND_MM as i64 * (layer + 1)),
        None => "Originals no longer kept".to_owned(),
    };
    picks.chunk_by(|a, b| layer(a) == layer(b)).map(|band| (title(band), band)).collect()
}

/// A row of the list, with a box to tick.
fn row(copy: &PickedCopy, is_proved: bool, has_pages: bool) -> Markup {
    html! { tr {
        td { "\u{2610}" }
        @for column in columns(is_proved) { (cell(&column.field, &(column.value)(copy), has_pages)) }
    } }
}

/// The columns of the list; without a proved order nobody knows the way.
fn columns(is_proved: bool) -> impl Iterator<Item = &'static TableColumn<PickedCopy>> {
    for_people(PICK_COLUMNS).filter(move |column| is_proved || column.key != "way")
}

/// What the copies of a sheet cover, from above, with their numbers, the first of which is `first`; the front is below.
fn plan(first: usize, band: &[Pick<'_>], x_mm: f64, y_mm: f64) -> Markup {
    let unit = x_mm.max(y_mm) / 100.0;
    let corner = |p: &DVec2| format!("{:.1},{:.1}", p.x, y_mm - p.y);
    let corners = |pick: &Pick<'_>| pick.footprint.iter().map(corner).collect::<Vec<_>>().join(" ");
    let label = |(number, pick): (usize, &Pick<'_>)| {
        let center = pick.center_mm()?;
        Some(Label::new(number.to_string(), DVec2::new(center.x, y_mm - center.y), 4.5 * unit))
    };
    let labels = apart((first..).zip(band).filter_map(label).collect(), DVec2::new(x_mm, y_mm));
    let rim = 3.0 * unit;
    html! {
        svg.plan viewBox=(format!("{:.1} {:.1} {:.1} {:.1}", -rim, -rim, x_mm + 2.0 * rim, y_mm + 2.0 * rim + 5.0 * unit)) role="img"
            aria-label="What they cover, from above, with their numbers" {
            rect.grid x="0" y="0" width=(x_mm) height=(y_mm) {}
            @for pick in band { polygon.covers points=(corners(pick)) {} }
            @for label in &labels { @if label.is_shifted() {
                line.leader x1=(format!("{:.1}", label.of.x)) y1=(format!("{:.1}", label.of.y))
                    x2=(format!("{:.1}", label.at.x)) y2=(format!("{:.1}", label.at.y)) stroke-width=(format!("{:.2}", 0.3 * unit)) {}
            } }
            @for label in &labels {
                text.number x=(format!("{:.1}", label.at.x)) y=(format!("{:.1}", label.at.y + 1.6 * unit))
                    font-size=(format!("{:.1}", 4.5 * unit)) stroke-width=(format!("{:.2}", 0.9 * unit)) { (label.text) }
            }
            text.number x=(x_mm / 2.0) y=(y_mm + 6.0 * unit) font-size=(format!("{:.1}", 4.0 * unit)) { "front" }
        }
    }
}

fn covered(part: &CakePart, standing: &Standing) -> Vec<DVec2> {
    let placed = part.mesh.iter().flat_map(|mesh| mesh.vertices().iter().map(|&vertex| standing.pose.point(vertex)));
    footprint(placed, COARSE_MM)
}

/// The copies from the top down; those whose place is not known come last.
fn picks(cake: &Cake) -> Vec<Pick<'_>> {
    let mut picks = Vec::with_capacity(cake.copies());
    for part in &cake.parts {
        picks.extend(part.copies.iter().map(|standing| Pick {
            part,
            copy: standing.copy,
            bounds: part.bounds(standing),
            footprint: covered(part, standing),
            drawn: standing.drawn,
        }));
    }
    let top = |pick: &Pick<'_>| pick.top_mm().unwrap_or(f64::NEG_INFINITY);
    picks.sort_by(|a, b| top(b).total_cmp(&top(a)));
    picks
}

#[cfg(test)]
#[path = "pick_map_tests.rs"]
mod tests;
