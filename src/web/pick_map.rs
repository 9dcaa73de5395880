//! The pick map of a cake: what comes out, one after the other. Made for paper; `pick` shows it.

use std::sync::Arc;

use glam::DVec2;
use maud::{Markup, html};
use serde::Serialize;
use solids::Bounds;

use super::{
    footprint::footprint,
    labels::{Label, apart},
    words::{count, number, text},
};
use crate::{
    farm::{Cake, CakePart, Standing},
    ledger::DrawnOut,
};

/// Corners of a footprint are no closer, mm.
const COARSE_MM: f64 = 1.5;

/// Thickness of a band of the map, mm.
const BAND_MM: f64 = 10.0;

/// Copies of a sheet of the map when they come in a proved order.
const OF_SHEET: usize = 16;

/// What of a way, a unit vector, goes to a side so little is not told.
const SLIGHT: f64 = 0.2;

/// A pick map as it is kept.
#[derive(Clone)]
pub(super) struct Map {
    pub(super) copies: usize,
    pub(super) sheets: Markup,
    pub(super) list: Arc<List>,
}

impl Map {
    /// The map of the cake of a build, with links to its parts.
    pub(super) fn of(cake: &Cake, number_of_build: i64) -> Self {
        let (picks, is_proved) = in_order(cake);
        let copies = (1..).zip(&picks).map(|(number, pick)| listed(number, pick)).collect();
        let list = Arc::new(List { build: number_of_build, is_proved, copies });
        let sheets = sheets(cake, (&picks, is_proved), |part| Some(format!("/parts/{part}")));
        Self { copies: cake.copies(), sheets, list }
    }
}

/// The copies of a build in the order in which they come out of the cake.
#[derive(Serialize)]
pub(super) struct List {
    build: i64,
    /// Whether it is proved on the triangles that each comes out on a straight line past all that are listed after it; else
    /// they are listed from the top down.
    is_proved: bool,
    copies: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    number: usize,
    part: i64,
    name: String,
    order: String,
    copy: u32,
    top_mm: Option<f64>,
    bottom_mm: Option<f64>,
    center_x_mm: Option<f64>,
    center_y_mm: Option<f64>,
    /// Whereto it is drawn: a unit vector in the machine's frame.
    way: Option<[f64; 3]>,
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

    fn goes_down(&self) -> bool {
        self.drawn.is_some_and(|drawn| drawn.way[2] < -SLIGHT)
    }
}

fn listed(number: usize, pick: &Pick<'_>) -> Listed {
    let center_mm = pick.center_mm();
    Listed {
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
    sheets(cake, (&picks, is_proved), |_| None)
}

/// Sheet by sheet; `link` gives the address of a part.
fn sheets(cake: &Cake, (picks, is_proved): (&[Pick<'_>], bool), link: impl Fn(i64) -> Option<String>) -> Markup {
    let sheets = if is_proved { by_number(picks) } else { by_height(picks) };
    let mut first = 1;
    html! {
        p { (if is_proved { PROVED } else { BY_HEIGHT }) " x from the left, y from the front, top and bottom from the floor, mm." }
        @if picks.iter().any(Pick::goes_down) { p { (DOWN) } }
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
                        thead { tr { th scope="col" { "Done" } th.n scope="col" { "No." } th.n scope="col" { "Top" } th.n scope="col" { "Bottom" }
                            th.n scope="col" { "x" } th.n scope="col" { "y" } @if is_proved { th scope="col" { "Way" } }
                            th scope="col" { "Part" } th scope="col" { "Order" } th.n scope="col" { "Copy" } } }
                        tbody { @for (number, pick) in (first..).zip(band) { (row(number, pick, link(pick.part.part))) } }
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

/// A way in words: the sides that it goes to.
fn whereto([x, y, z]: [f64; 3]) -> String {
    let side = |value: f64, towards: &'static str, away: &'static str| match value {
        value if value > SLIGHT => Some(towards),
        value if value < -SLIGHT => Some(away),
        _ => None,
    };
    let sides = [side(z, "up", "down"), side(x, "right", "left"), side(y, "back", "front")];
    sides.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn row(number_of: usize, pick: &Pick<'_>, link: Option<String>) -> Markup {
    let center_mm = pick.center_mm();
    html! { tr {
        td { "\u{2610}" } td.n { (number_of) } td.n { (number(pick.top_mm(), 1)) } td.n { (number(pick.low_mm(), 1)) }
        td.n { (number(center_mm.map(|c| c.x), 0)) } td.n { (number(center_mm.map(|c| c.y), 0)) }
        @if let Some(drawn) = pick.drawn { td { (whereto(drawn.way)) } }
        td { @if let Some(link) = link { a href=(link) { (pick.part.name) } } @else { (pick.part.name) } }
        td { (text(&pick.part.order)) } td.n { (pick.copy) }
    } }
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
