//! A build: what is in the cake, to look at from all sides.

use std::sync::Arc;

use axum::extract::{Path, State};
use jiff::Timestamp;
use maud::{Markup, html};

use super::{
    chart, farm,
    listing::{facts, table_of},
    page::page,
    pick_map::PICTURE,
    problem::Answer,
    render::{build_of, version},
    state::Web,
    words::{count, prose},
};
use crate::{
    farm::{Standing, standing},
    ledger::{BuildRow, BuildState, OutcomeRow, PartRow},
    settings::Profile,
    tables::{BUILD_PART_COLUMNS, CountedPart, OUTCOME_COLUMNS, build_facts},
};

/// The page.
pub(super) async fn show(State(web): State<Arc<Web>>, Path(number_of_build): Path<i64>) -> Answer<Markup> {
    let (build, profile) = build_of(&web, number_of_build).await?;
    let parts = standing(&web.ledger, &build, &profile).await?;
    let copies = parts.iter().map(|(_, copies)| copies.len() as u32).sum();
    // Of each part the copies that stand here: the others are in other builds, or wait.
    let here = |(part, copies): (PartRow, Vec<Standing>)| CountedPart { part, copies: copies.len() as u32 };
    let rows: Vec<CountedPart> = parts.into_iter().map(here).collect();
    let outcomes = web.ledger.outcomes(build.id).await?;
    let content = html! {
        h1 { "Build " (build.id) " on " (build.profile) ": " (build.state) }
        @if !build.reason.is_empty() {
            p class=(if is_bad(build.state) { "bad" } else { "note" }) role="status" { (prose(&build.reason)) }
        }
        @if copies > 0 { (view(build.id.0, copies, &standing_now(&build))) } @else { p { "Nothing stands in it yet." } }
        p { a href=(format!("/builds/{}/pick", build.id)) { "Pick map for the person who breaks it out" } }
        @if let Some(fires) = fires(&web, &build, &profile).await? { p { "Fires " (fires) "." } }
        (facts(&build_facts(&build, Some(&profile), (copies.to_string(), None), Timestamp::now())))
        (curve(&build.curve()))
        (told(&outcomes))
        h2 { "Parts" }
        (table_of("Parts", None, BUILD_PART_COLUMNS, &rows))
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
            (table_of("Outcomes", None, OUTCOME_COLUMNS, outcomes))
        }
    }
}
