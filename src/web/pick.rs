//! The pick map: what comes out of the cake, from the top down. Made for paper.

use std::sync::Arc;

use axum::extract::{Path, State};
use glam::DVec2;
use maud::{Markup, html};

use super::{
    cache::Kept,
    footprint::footprint,
    page::page,
    problem::Answer,
    scene::{build_of, of_cake, version},
    server::Web,
    words::{count, number, text},
};
use crate::farm::{Cake, CakePart, Standing};

/// Corners of a footprint are no closer, mm.
const COARSE_MM: f64 = 1.5;

/// Thickness of a band of the map, mm.
const BAND_MM: f64 = 10.0;

/// Maps that are kept; some 100 kB each.
pub(super) const KEPT: usize = 8;

/// How many copies are on a map, and its bands.
pub(super) type Map = (usize, Markup);

/// A part to take out of the cake.
struct Pick {
    top_mm: f64,
    low_mm: f64,
    center_mm: [f64; 2],
    /// What it covers, from above.
    footprint: Vec<DVec2>,
    name: String,
    order: String,
    copy: u32,
    part: i64,
}

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let title = format!("Pick map of build {}", build.id);
    let kept = Kept { cache: |web| &web.picks, key: version(&build) };
    let link = |part| Some(format!("/parts/{part}"));
    let map = move |cake: &Cake| Ok((cake.copies(), bands(cake, link)));
    let (copies, bands) = of_cake(&web, &build, &profile, kept, map).await?;
    let content = html! {
        h1 { (title) }
        p { (build.profile) ", " (number(build.height_mm, 2)) " mm, " (count(copies as u32, "part", "parts")) ". " (LEGEND) }
        @if copies > 0 {
            img.cake alt="The build from the front" width="640" height="480" src=(format!("/builds/{}/picture", build.id));
        }
        (bands)
    };
    Ok(page(&title, "", None, &content))
}

/// How to read the map.
pub(super) const LEGEND: &str = "From the top down; x from the left, y from the front, z from the floor, mm.";

/// Band by band, in the order in which parts come out of the cake; `link` gives the address of a part.
pub(super) fn bands(cake: &Cake, link: impl Fn(i64) -> Option<String>) -> Markup {
    let picks = picks(cake);
    let layer = |pick: &Pick| (pick.top_mm / BAND_MM).floor() as i64;
    let down = |band: &[Pick]| format!("{} mm down", BAND_MM as i64 * (layer(&band[0]) + 1));
    let mut first = 1;
    html! {
        @for band in picks.chunk_by(|a, b| layer(a) == layer(b)) {
            section.band {
                h2 { "From " (down(band)) }
                div.sheet {
                    (plan(first, band, cake.volume_mm.x, cake.volume_mm.y))
                    div.wide tabindex="0" role="region" aria-label=(format!("Parts from {}", down(band))) { table {
                        thead { tr { th scope="col" { "Done" } th.n scope="col" { "No." } th.n scope="col" { "Top" } th.n scope="col" { "Bottom" }
                            th.n scope="col" { "x" } th.n scope="col" { "y" }
                            th scope="col" { "Part" } th scope="col" { "Order" } th.n scope="col" { "Copy" } } }
                        tbody { @for (number, pick) in (first..).zip(band) { (row(number, pick, link(pick.part))) } }
                    } }
                }
            }
            @let () = first += band.len();
        }
    }
}

fn row(number_of: usize, pick: &Pick, link: Option<String>) -> Markup {
    html! { tr {
        td { "\u{2610}" } td.n { (number_of) } td.n { (number(Some(pick.top_mm), 1)) } td.n { (number(Some(pick.low_mm), 1)) }
        td.n { (number(Some(pick.center_mm[0]), 0)) } td.n { (number(Some(pick.center_mm[1]), 0)) }
        td { @if let Some(link) = link { a href=(link) { (pick.name) } } @else { (pick.name) } }
        td { (text(&pick.order)) } td.n { (pick.copy) }
    } }
}

/// What the parts of a band cover, from above, with their numbers, the first of which is `first`; the front is below.
fn plan(first: usize, band: &[Pick], x_mm: f64, y_mm: f64) -> Markup {
    let unit = x_mm.max(y_mm) / 100.0;
    let corner = |p: &DVec2| format!("{:.1},{:.1}", p.x, y_mm - p.y);
    let corners = |pick: &Pick| pick.footprint.iter().map(corner).collect::<Vec<_>>().join(" ");
    html! {
        svg.plan viewBox=(format!("-1 -1 {} {}", x_mm + 2.0, y_mm + 2.0 + 5.0 * unit)) role="img"
            aria-label="What they cover, from above, with their numbers" {
            rect.grid x="0" y="0" width=(x_mm) height=(y_mm) {}
            @for pick in band { polygon.covers points=(corners(pick)) {} }
            @for (number, pick) in (first..).zip(band) {
                text.number x=(format!("{:.1}", pick.center_mm[0])) y=(format!("{:.1}", y_mm - pick.center_mm[1] + 1.5 * unit))
                    font-size=(format!("{:.1}", 4.5 * unit)) { (number) }
            }
            text.number x=(x_mm / 2.0) y=(y_mm + 5.0 * unit) font-size=(format!("{:.1}", 4.0 * unit)) { "front" }
        }
    }
}

fn covered(part: &CakePart, standing: &Standing) -> Vec<DVec2> {
    let placed = part.mesh.iter().flat_map(|mesh| mesh.vertices().iter().map(|&vertex| standing.pose.point(vertex)));
    footprint(placed, COARSE_MM)
}

fn picks(cake: &Cake) -> Vec<Pick> {
    let mut picks = Vec::with_capacity(cake.copies());
    for part in &cake.parts {
        for standing in &part.copies {
            let middle = standing.pose.translation;
            let (low, top) = part.bounds(standing).map_or((middle, middle), |b| (b.min, b.max));
            picks.push(Pick {
                top_mm: top.z,
                low_mm: low.z,
                center_mm: [0.5 * (low.x + top.x), 0.5 * (low.y + top.y)],
                footprint: covered(part, standing),
                name: part.name.clone(),
                order: part.order.clone(),
                copy: standing.copy,
                part: part.part,
            });
        }
    }
    picks.sort_by(|a, b| b.top_mm.total_cmp(&a.top_mm));
    picks
}
