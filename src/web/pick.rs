//! The pick map: what comes out of the cake, one after the other. Made for paper.

use std::sync::Arc;

use axum::extract::{Path, State};
use glam::DVec2;
use maud::{Markup, html};

use super::{
    cache::Kept,
    footprint::footprint,
    labels::{Label, apart},
    page::page,
    problem::Answer,
    scene::{build_of, of_cake, version},
    search::Told,
    server::Web,
    words::{count, number, text},
};
use crate::{
    farm::{Cake, CakePart, Standing},
    format::name_in_build_file,
    geometry::Bounds,
    nest::DrawnCopy,
};

/// Corners of a footprint are no closer, mm.
const COARSE_MM: f64 = 1.5;

/// Thickness of a band of the map, mm.
const BAND_MM: f64 = 10.0;

/// Copies of a sheet of the map when they come in a proved order.
const OF_SHEET: usize = 16;

/// Maps that are kept; some 100 kB each.
pub(super) const KEPT: usize = 8;

/// How many copies are on a map, and its sheets.
pub(super) type Map = (usize, Markup);

/// A copy to take out of the cake.
struct Pick<'c> {
    part: &'c CakePart,
    copy: u32,
    /// `None` when the original of its part is not there any more.
    bounds: Option<Bounds>,
    /// What it covers, from above.
    footprint: Vec<DVec2>,
    /// The straight line that it takes out, as it was proved.
    way: Option<[f64; 3]>,
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

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let title = format!("Pick map of build {}", build.id);
    let link = |part| Some(format!("/parts/{part}"));
    let search = Told::of_build(&web, &profile, &build).await;
    // A map by height gives way once the order can be read.
    let kept = Kept { cache: |web| &web.picks, key: format!("{} {}", version(&build), search.order.len()) };
    let map = move |cake: &Cake| Ok((cake.copies(), sheets(cake, &search.order, link)));
    let (copies, sheets) = of_cake(&web, &build, &profile, kept, map).await?;
    let content = html! {
        h1 { (title) }
        p { (build.profile) ", " (number(build.height_mm, 2)) " mm, " (count(copies as u32, "copy", "copies")) "." }
        @if copies > 0 {
            img.cake alt=(PICTURE) width="640" height="480" src=(format!("/builds/{}/picture", build.id));
        }
        (sheets)
    };
    Ok(page(&title, "", None, &content))
}

/// What the picture beside a map shows.
pub(super) const PICTURE: &str = "The build, seen from the front, a little from the right and from above";

/// Sheet by sheet, in the order in which copies come out of the cake: the proved one (`order`) where it names them all, else
/// from the top down; `link` gives the address of a part.
pub(super) fn sheets(cake: &Cake, order: &[DrawnCopy], link: impl Fn(i64) -> Option<String>) -> Markup {
    let mut picks = picks(cake);
    let is_proved = in_order(&mut picks, order);
    let sheets = if is_proved { by_number(&picks) } else { by_height(&picks) };
    let mut first = 1;
    html! {
        p { (if is_proved { PROVED } else { BY_HEIGHT }) " x from the left, y from the front, top and bottom from the floor, mm." }
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
/// How to read a map without one.
const BY_HEIGHT: &str = "By height, from the top down; whether each comes out past the others is not said here.";

/// Brings copies into a proved order; says whether it names them all, each once.
fn in_order(picks: &mut Vec<Pick<'_>>, order: &[DrawnCopy]) -> bool {
    if order.len() != picks.len() || order.is_empty() {
        return false;
    }
    // The report names the file that a part was dropped as; the cake its solid as well.
    let names: Vec<String> = picks.iter().map(|pick| name_in_build_file(&pick.part.name)).collect();
    let is = |at: usize, drawn: &DrawnCopy| {
        let rest = names[at].strip_prefix(drawn.part.as_str());
        picks[at].copy == drawn.copy + 1 && rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("))
    };
    let mut at = Vec::with_capacity(order.len());
    for drawn in order {
        let mut found = (0..picks.len()).filter(|&at| is(at, drawn));
        match (found.next(), found.next()) {
            (Some(one), None) => at.push(one),
            // Two parts of one name: which of them is meant is not said.
            _ => return false,
        }
    }
    let mut place = vec![usize::MAX; picks.len()];
    at.iter().enumerate().for_each(|(number, &at)| place[at] = number);
    if place.contains(&usize::MAX) {
        return false;
    }
    at.iter().zip(order).for_each(|(&at, drawn)| picks[at].way = Some(drawn.way));
    let mut placed: Vec<_> = place.into_iter().zip(std::mem::take(picks)).collect();
    placed.sort_by_key(|(number, _)| *number);
    picks.extend(placed.into_iter().map(|(_, pick)| pick));
    true
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
    const SLIGHT: f64 = 0.2;
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
        @if let Some(way) = pick.way { td { (whereto(way)) } }
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
            way: None,
        }));
    }
    let top = |pick: &Pick<'_>| pick.top_mm().unwrap_or(f64::NEG_INFINITY);
    picks.sort_by(|a, b| top(b).total_cmp(&top(a)));
    picks
}

#[cfg(test)]
#[path = "pick_tests.rs"]
mod tests;
