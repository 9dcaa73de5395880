//! A build: what is in the cake, to look at from all sides.

use std::sync::Arc;

use axum::extract::{Path, State};
use jiff::Timestamp;
use maud::{Markup, html};

use super::{
    chart, farm,
    page::{facts, page},
    part,
    pick_map::PICTURE,
    problem::Answer,
    render::{build_of, version},
    state::Web,
    words::{age, count, number, or_dash, percent, prose, text, time},
};
use crate::{
    farm::{Standing, standing},
    ledger::{BuildRow, BuildState, OutcomeRow, PartRow},
    settings::Profile,
};

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let parts = standing(&web.ledger, &build, &profile).await?;
    let copies = parts.iter().map(|(_, copies)| copies.len() as u32).sum();
    // Of each part the copies that stand here: the others are in other builds, or wait.
    let here = |(part, copies): (PartRow, Vec<Standing>)| PartRow { copies: copies.len() as u32, ..part };
    let rows: Vec<PartRow> = parts.into_iter().map(here).collect();
    let outcomes = web.ledger.outcomes(build.id).await?;
    let content = html! {
        h1 { "Build " (build.id) " on " (build.profile) ": " (build.state) }
        @if !build.reason.is_empty() {
            p class=(if is_bad(build.state) { "bad" } else { "note" }) role="status" { (prose(&build.reason)) }
        }
        @if copies > 0 { (view(build.id.0, copies, &standing_now(&build))) } @else { p { "Nothing stands in it yet." } }
        p { a href=(format!("/builds/{}/pick", build.id)) { "Pick map for the person who breaks it out" } }
        @if let Some(fires) = fires(&web, &build, &profile).await? { p { "Fires " (fires) "." } }
        (what_is_known(&build, &profile, copies))
        (curve(&build.curve()))
        (told(&outcomes))
        h2 { "Parts" }
        (part::table(&rows, false, "Copies here"))
    };
    Ok(page(&format!("Build {}", build.id), "", Some("/assets/view.js"), &content))
}

/// When an open build fires, and why.
async fn fires(web: &Web, build: &BuildRow, profile: &Profile) -> Answer<Option<String>> {
    if build.state != BuildState::Open {
        return Ok(None);
    }
    let status = web.ledger.status().await?;
    Ok(status.iter().find(|status| status.profile == build.profile).and_then(|status| farm::fires(profile, status)))
}

/// A text that is another one when something else stands in the build; what is proved stays.
fn standing_now(build: &BuildRow) -> String {
    match build.state {
        BuildState::Open | BuildState::Nesting => version(build),
        _ => "proved".to_owned(),
    }
}

/// Whether a build's reason is bad news, and not a note of the operator.
fn is_bad(state: BuildState) -> bool {
    matches!(state, BuildState::Failed | BuildState::Interrupted)
}

/// The 3D view; without JavaScript the picture. A report (no `version`) carries its own.
pub(super) fn view(build: i64, copies: u32, version: &str) -> Markup {
    html! {
        section #view data-build=(build) data-copies=(copies) data-version=(version) aria-label="3D view" {
            @if !version.is_empty() {
                noscript { p { "The 3D view needs JavaScript. " }
                    img.cake alt=(PICTURE) width="640" height="480" src=(format!("/builds/{build}/picture")); }
            } @else {
                noscript { p { "The 3D view needs JavaScript; the pick map has a picture." } }
            }
            canvas tabindex="0" role="img" aria-label=(format!("Nest of {}; arrow keys turn it, + and - zoom", count(copies, "copy", "copies"))) {}
            div.controls {
                label { "Cut at " output #cut-mm { } input #cut type="range" min="0" max="1000" value="1000"; }
                label { "Explode" input #explode type="range" min="0" max="100" value="0"; }
                button #home type="button" { "Whole view" }
            }
            p #hover role="status" { "Point at a copy to see what it is; click to see its siblings." }
        }
    }
}

/// What is known of a build; of an open one less.
pub(super) fn what_is_known(build: &BuildRow, profile: &Profile, copies: u32) -> Markup {
    let volume_z_mm = Some(profile.volume_mm.z).filter(|z| *z > 0.0);
    let layers = build.layers.or(build.height_mm.map(|height_mm| (height_mm / profile.layer_mm).ceil() as u32));
    let mut known =
        vec![("Height", html! { b { (number(build.height_mm, 2)) " mm" } " of " (number(volume_z_mm, 0)) " mm" })];
    if build.lower_bound_mm.is_some() {
        known
            .push(("Lower bound", html! { (number(build.lower_bound_mm, 2)) " mm: no build of these parts is lower" }));
    }
    if let Some(layers) = layers {
        known.push(("Layers", html! { (layers) " of " (profile.layer_mm) " mm" }));
    }
    if build.density.is_some() {
        known.push(("Density", html! { (percent(build.density)) }));
    }
    let volume_cm3 = build.part_volume_mm3.map(|v| v / 1000.0);
    known.push(("Copies", html! { (copies) @if volume_cm3.is_some() { ", " (number(volume_cm3, 1)) " cm3" } }));
    known.push(("Clearance", clearance(build, profile)));
    if let Some(method) = &build.method {
        let search = html! { (method) ", seed " (or_dash(build.seed)) ", " (or_dash(build.evaluations)) " evaluations, "
        (number(build.cpu_secs, 1)) " CPU s, " (number(build.wall_secs, 1)) " s" };
        known.push(("Search", search));
    }
    if !build.fired_by.is_empty() {
        known.push(("Fired by", html! { (build.fired_by) }));
    }
    known.push(("Opened", html! { (time(Some(build.opened_at))) }));
    if let Some(at) = build.published_at {
        known.push(("Published", html! { (time(Some(at))) ", " (age(at.0, Timestamp::now())) " ago" }));
    }
    if let Some(file) = &build.file_name {
        known.push(("File", html! { (file) }));
    }
    facts(&known)
}

fn clearance(build: &BuildRow, profile: &Profile) -> Markup {
    let asked_mm = build.clearance_mm.or(Some(profile.clearance_mm));
    html! {
        (number(asked_mm, 2)) " mm asked"
        @match (build.clearance_proved_mm, build.verified_at) {
            (Some(proved_mm), _) => { ", " (number(Some(proved_mm), 3)) " mm proved on the triangles" }
            (None, Some(_)) => { ", proved: no two are near" }
            (None, None) => { ", proved once it is fired" }
        }
    }
}

/// How the height fell.
pub(super) fn curve(points: &Vec<(f64, f64)>) -> Markup {
    html! {
        @if points.len() > 1 {
            figure { figcaption { "Height while it was searched, mm over seconds" }
                (chart::plot("Height over time", std::iter::once(points), &|secs| format!("{secs:.1} s"))) }
        }
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
