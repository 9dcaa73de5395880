//! The pick map: what comes out of the cake, from the top down. Made for paper.

use std::sync::Arc;

use axum::extract::{Path, State};
use maud::{Markup, html};

use super::{
    page::page,
    problem::Answer,
    scene::{build_of, of_cake},
    server::Web,
    words::{count, number, text},
};
use crate::farm::Cake;

/// Thickness of a band of the map, mm.
const BAND_MM: f64 = 10.0;

/// A part to take out of the cake.
struct Pick {
    top_mm: f64,
    low_mm: f64,
    center_mm: [f64; 2],
    name: String,
    order: String,
    copy: u32,
    part: i64,
}

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let title = format!("Pick map of build {}", build.id);
    let (copies, bands) =
        of_cake(&web, &build, &profile, |cake| (cake.copies(), bands(cake, |part| Some(format!("/parts/{part}")))))
            .await?;
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
    let layer = |z: f64| (z / BAND_MM).floor() as i64;
    let down = |band: &[Pick]| format!("{} mm down", BAND_MM as i64 * (layer(band[0].top_mm) + 1));
    html! {
        @for band in picks.chunk_by(|a, b| layer(a.top_mm) == layer(b.top_mm)) {
            section.band {
                h2 { "From " (down(band)) }
                (plan(band, cake.volume_mm.x, cake.volume_mm.y))
                div.wide tabindex="0" role="region" aria-label=(format!("Parts from {}", down(band))) { table {
                    thead { tr { th scope="col" { "Done" } th.n scope="col" { "Top" } th.n scope="col" { "Bottom" } th.n scope="col" { "x" } th.n scope="col" { "y" }
                        th scope="col" { "Part" } th scope="col" { "Order" } th.n scope="col" { "Copy" } } }
                    tbody { @for pick in band { (row(pick, link(pick.part))) } }
                } }
            }
        }
    }
}

fn row(pick: &Pick, link: Option<String>) -> Markup {
    html! { tr {
        td { "\u{2610}" } td.n { (number(Some(pick.top_mm), 1)) } td.n { (number(Some(pick.low_mm), 1)) }
        td.n { (number(Some(pick.center_mm[0]), 0)) } td.n { (number(Some(pick.center_mm[1]), 0)) }
        td { @if let Some(link) = link { a href=(link) { (pick.name) } } @else { (pick.name) } }
        td { (text(&pick.order)) } td.n { (pick.copy) }
    } }
}

/// Where the parts of a band are, from above.
fn plan(band: &[Pick], x_mm: f64, y_mm: f64) -> Markup {
    html! {
        svg.plan viewBox=(format!("-1 -1 {} {}", x_mm + 2.0, y_mm + 2.0)) role="img" aria-label="Where they are, from above" {
            rect.grid x="0" y="0" width=(x_mm) height=(y_mm) {}
            @for pick in band {
                circle.c0 cx=(format!("{:.1}", pick.center_mm[0])) cy=(format!("{:.1}", y_mm - pick.center_mm[1])) r=(x_mm.max(y_mm) / 60.0) {}
            }
        }
    }
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
