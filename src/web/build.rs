//! A build: what is in the cake, to look at from all sides, and the pick map for breaking it out.

use std::sync::Arc;

use anyhow::Context;
use axum::{
    extract::{Path, State},
    http::header,
    response::{IntoResponse, Response},
};
use glam::DVec2;
use jiff::Timestamp;
use maud::{Markup, html};

use super::{
    chart,
    footprint::footprint,
    page::{facts, page},
    part,
    problem::Answer,
    scene::{Bodies, Standing, build_of, by_part, standing},
    server::Web,
    words::{age, count, full_name, number, or_dash, percent, text, time},
};
use crate::{
    format,
    geometry::{Mesh, Pose},
    ledger::{BuildRow, OutcomeRow, PartRow},
    settings::{Profile, Settings},
};

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let standing = standing(&web.ledger, &build, &profile).await?;
    let copies = standing.len() as u32;
    let parts = by_part(&web.ledger, standing).await?;
    let rows: Vec<PartRow> = parts.into_iter().map(|(part, _)| part).collect();
    let outcomes = web.ledger.outcomes(build.id).await?;
    let content = html! {
        h1 { "Build " (build.id) " on " (build.profile) ": " (build.state) }
        @if !build.reason.is_empty() { p.bad role="status" { (build.reason) } }
        @if copies > 0 { (view(&build, copies)) } @else { p { "Nothing stands in it yet." } }
        p { a href=(format!("/builds/{}/pick", build.id)) { "Pick map for the person who breaks it out" } }
        (what_is_known(&build, &profile, copies))
        (curve(&build, &profile))
        (told(&outcomes))
        h2 { "Parts" }
        (part::table(&rows, rows.len()))
    };
    Ok(page(&format!("Build {}", build.id), "", Some("/assets/view.js"), &content))
}

/// The 3D view; without JavaScript the pick map shows the picture.
fn view(build: &BuildRow, copies: u32) -> Markup {
    html! {
        section #view data-build=(build.id) data-copies=(copies) aria-label="3D view" {
            noscript { p { "The 3D view needs JavaScript; the pick map has a picture." } }
            canvas tabindex="0" role="img" aria-label=(format!("Nest of {}; arrow keys turn it, + and - zoom", count(copies, "part", "parts"))) {}
            div.controls {
                label { "Cut at " output #cut-mm { } input #cut type="range" min="0" max="1000" value="1000"; }
                label { "Explode" input #explode type="range" min="0" max="100" value="0"; }
                button #home type="button" { "Whole view" }
            }
            p #hover role="status" { "Point at a part to see what it is; click to see its siblings." }
        }
    }
}

fn what_is_known(build: &BuildRow, profile: &Profile, copies: u32) -> Markup {
    facts(&[
        (
            "Height",
            html! { b { (number(build.height_mm, 2)) " mm" } " of " (number(Some(profile.volume_mm.z), 0)) " mm" },
        ),
        ("Lower bound", html! { (number(build.lower_bound_mm, 2)) " mm: no build of these parts is lower" }),
        ("Layers", html! { (or_dash(build.layers)) " of " (profile.layer_mm) " mm" }),
        ("Density", html! { (percent(build.density)) }),
        ("Copies", html! { (copies) ", " (number(build.part_volume_mm3.map(|v| v / 1000.0), 1)) " cm3" }),
        (
            "Clearance",
            html! { (number(build.clearance_mm, 2)) " mm asked, " (number(build.clearance_proved_mm, 3)) " mm proved on the triangles" },
        ),
        (
            "Search",
            html! { (or_dash(build.method.as_ref())) ", seed " (or_dash(build.seed)) ", "
            (or_dash(build.evaluations)) " evaluations, " (number(build.cpu_secs, 1)) " CPU s, " (number(build.wall_secs, 1)) " s" },
        ),
        ("Fired by", html! { (text(&build.fired_by)) }),
        ("Opened", html! { (time(Some(build.opened_at))) }),
        (
            "Published",
            html! { (time(build.published_at)) @if let Some(at) = build.published_at { ", " (age(at.0, Timestamp::now())) " ago" } },
        ),
        ("File", html! { (build.file_name.as_deref().unwrap_or("–")) }),
    ])
}

/// How the height fell, as long as the report of the search lies beside the build file.
fn curve(build: &BuildRow, profile: &Profile) -> Markup {
    let read = || -> Option<Vec<(f64, f64)>> {
        let stem = build.file_name.as_deref()?.strip_suffix(".build.3mf")?;
        let report = std::fs::read(profile.folders.queue.join(format!("{stem}.report.json"))).ok()?;
        let report: serde_json::Value = serde_json::from_slice(&report).ok()?;
        serde_json::from_value(report.get("curve")?.clone()).ok()
    };
    match read() {
        Some(points) if points.len() > 1 => {
            let end = format!("{:.1} s", points[points.len() - 1].0);
            html! {
                figure { figcaption { "Height while it was searched, mm over seconds" }
                    (chart::plot("Height over time", std::iter::once(&points), ("0 s", &end))) }
            }
        }
        _ => html! {},
    }
}

fn told(outcomes: &[OutcomeRow]) -> Markup {
    html! {
        @if !outcomes.is_empty() {
            h2 { "What became of it" }
            ul { @for told in outcomes { li { (time(Some(told.told_at))) " " (told.outcome) " by " (told.told_by) ": " (text(&told.note)) } } }
        }
    }
}

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

/// The pick map: top to bottom, in the order in which parts come out of the cake. Made for paper.
pub(super) async fn pick(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let standing = standing(&web.ledger, &build, &profile).await?;
    let parts = by_part(&web.ledger, standing).await?;
    let settings = web.settings();
    let (volume, title) = (profile.volume_mm, format!("Pick map of build {}", build.id));
    let of = build.clone();
    let made = tokio::task::spawn_blocking(move || pick_rows(&settings, &profile, &of, &parts)).await;
    let picks = made.context("making the pick map")??;
    let from = |band: &[Pick]| BAND_MM * ((band[0].top_mm / BAND_MM).floor() + 1.0);
    let content = html! {
        h1 { (title) }
        p { (build.profile) ", " (number(build.height_mm, 2)) " mm, " (count(picks.len() as u32, "part", "parts"))
            ". From the top down; x from the left, y from the front, z from the floor, mm." }
        @if !picks.is_empty() {
            img.cake alt="The build from the front" width="640" height="480" src=(format!("/builds/{}/picture", build.id));
        }
        @for (first, band) in bands(&picks) {
            section.band {
                h2 { "From " (from(band)) " mm down" }
                (plan(first, band, volume.x, volume.y))
                div.wide tabindex="0" role="region" aria-label=(format!("Parts from {} mm down", from(band))) { table {
                    thead { tr { th scope="col" { "Done" } th.n scope="col" { "No." } th.n scope="col" { "Top" } th.n scope="col" { "Bottom" } th.n scope="col" { "x" } th.n scope="col" { "y" }
                        th scope="col" { "Part" } th scope="col" { "Order" } th.n scope="col" { "Copy" } } }
                    tbody { @for (number_of, pick) in (first..).zip(band) { tr {
                        td { "\u{2610}" } td.n { (number_of) } td.n { (number(Some(pick.top_mm), 1)) } td.n { (number(Some(pick.low_mm), 1)) }
                        td.n { (number(Some(pick.center_mm[0]), 0)) } td.n { (number(Some(pick.center_mm[1]), 0)) }
                        td { a href=(format!("/parts/{}", pick.part)) { (pick.name) } } td { (text(&pick.order)) } td.n { (pick.copy) }
                    } } }
                } }
            }
        }
    };
    Ok(page(&title, "", None, &content))
}

/// Height of a band of the pick map, mm.
const BAND_MM: f64 = 10.0;

/// The picks by band, each with the number of its first.
fn bands(picks: &[Pick]) -> impl Iterator<Item = (usize, &[Pick])> {
    let band = |pick: &Pick| (pick.top_mm / BAND_MM).floor() as i64;
    picks.chunk_by(move |a, b| band(a) == band(b)).scan(1, |next, band| {
        let first = *next;
        *next += band.len();
        Some((first, band))
    })
}

/// What the parts of a band cover, from above, with the numbers that they have in the list; the front is below.
fn plan(first: usize, band: &[Pick], x_mm: f64, y_mm: f64) -> Markup {
    let unit = x_mm.max(y_mm) / 100.0;
    let corners = |pick: &Pick| {
        pick.footprint.iter().map(|p| format!("{:.1},{:.1}", p.x, y_mm - p.y)).collect::<Vec<_>>().join(" ")
    };
    html! {
        svg.plan viewBox=(format!("-1 -1 {} {}", x_mm + 2.0, y_mm + 2.0 + 5.0 * unit)) role="img"
            aria-label="What they cover, from above, with their numbers" {
            rect.grid x="0" y="0" width=(x_mm) height=(y_mm) {}
            @for pick in band { polygon.covers points=(corners(pick)) {} }
            @for (number_of, pick) in (first..).zip(band) {
                text.number x=(format!("{:.1}", pick.center_mm[0])) y=(format!("{:.1}", y_mm - pick.center_mm[1] + 1.5 * unit))
                    font-size=(format!("{:.1}", 4.5 * unit)) { (number_of) }
            }
            text.number x=(x_mm / 2.0) y=(y_mm + 5.0 * unit) font-size=(format!("{:.1}", 4.0 * unit)) { "front" }
        }
    }
}

fn pick_rows(
    settings: &Settings,
    profile: &Profile,
    build: &BuildRow,
    parts: &[(PartRow, Vec<Standing>)],
) -> anyhow::Result<Vec<Pick>> {
    let bodies = Bodies::new(settings, profile, build)?;
    let mut picks = Vec::new();
    for (part, copies) in parts {
        let mesh = bodies.mesh(part);
        for standing in copies {
            let bounds = mesh.as_ref().map(|mesh| mesh.bounds_at(&standing.pose));
            let (low, top) = bounds.map_or((standing.pose.translation, standing.pose.translation), |b| (b.min, b.max));
            picks.push(Pick {
                top_mm: top.z,
                low_mm: low.z,
                center_mm: [0.5 * (low.x + top.x), 0.5 * (low.y + top.y)],
                footprint: mesh.as_ref().map_or_else(Vec::new, |mesh| covered(mesh, &standing.pose)),
                name: full_name(part),
                order: part.order_name.clone(),
                copy: standing.copy + 1,
                part: part.id.0,
            });
        }
    }
    picks.sort_by(|a, b| b.top_mm.total_cmp(&a.top_mm));
    Ok(picks)
}

/// Corners of a footprint are no closer, mm.
const COARSE_MM: f64 = 1.5;

fn covered(mesh: &Mesh, pose: &Pose) -> Vec<DVec2> {
    footprint(mesh.vertices().iter().map(|&vertex| pose.point(vertex)), COARSE_MM)
}

/// The picture of a build, a PNG.
pub(super) async fn picture(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Response> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let standing = standing(&web.ledger, &build, &profile).await?;
    let parts = by_part(&web.ledger, standing).await?;
    let settings = web.settings();
    let draw = move || -> anyhow::Result<Vec<u8>> {
        let meshes = Bodies::new(&settings, &profile, &build)?;
        let read = |(part, copies): &(PartRow, Vec<Standing>)| Some((meshes.mesh(part)?, copies.clone()));
        let read: Vec<(Arc<Mesh>, Vec<Standing>)> = parts.iter().filter_map(read).collect();
        let bodies: Vec<(&Mesh, Pose)> =
            read.iter().flat_map(|(mesh, copies)| copies.iter().map(|c| (&**mesh, c.pose))).collect();
        Ok(format::picture(&bodies, profile.volume_mm, 640, 480))
    };
    let png = tokio::task::spawn_blocking(draw).await.context("drawing")??;
    Ok(([(header::CONTENT_TYPE, "image/png")], png).into_response())
}
