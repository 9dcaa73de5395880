//! The page of a build: 3D view, facts and parts.

use std::sync::Arc;

use axum::extract::{Path, State};
use maud::{Markup, html};

use super::{
    build_forms::{build_forms, unseen_failure},
    cached_render::{find_build, layout_version},
    chart,
    error::HandlerResult,
    farm,
    format::{count, prose_with_code},
    listing::{fact_list, table_of},
    page::html_page,
    picture::cake_picture,
    state::DashboardState,
};
use crate::{
    farm::{CakeCopy, load_placed_parts},
    ledger::{BuildRow, BuildState, OutcomeRow, PartRow},
    settings::MachineProfile,
    tables::{BUILD_PART_COLUMNS, CountedPart, OUTCOME_COLUMNS, TimeView, build_facts},
};

/// The page of a build.
pub(super) async fn show_build(
    State(web): State<Arc<DashboardState>>,
    Path(number_of_build): Path<i64>,
) -> HandlerResult<Markup> {
    let (build, profile) = find_build(&web, number_of_build).await?;
    let parts = load_placed_parts(&web.ledger, &build, &profile).await?;
    let copies = parts.iter().map(|(_, copies)| copies.len() as u32).sum();
    // Counts only the copies in this build: the other copies are in other builds, or wait.
    let here = |(part, copies): (PartRow, Vec<CakeCopy>)| CountedPart { part, copies: copies.len() as u32 };
    let rows: Vec<CountedPart> = parts.into_iter().map(here).collect();
    let outcomes = web.ledger.outcomes_of_build(build.id).await?;
    let placements = web.ledger.placements_of_build(build.id).await?;
    let is_unseen = web.ledger.unseen_failures().await?.iter().any(|failed| failed.id == build.id);
    let view = web.time_view();
    let content = html! {
        h1 { "Build " (build.id) " on " (build.profile) ": " (build.state) }
        @if is_unseen { (unseen_failure(&web, &build)) }
        @else if !build.reason.is_empty() {
            p class=(if is_failure(build.state) { "bad" } else { "note" }) role="status" { (prose_with_code(&build.reason)) }
        }
        @if copies > 0 { (view_section(build.id.0, copies, &view_version(&build))) } @else { p { "Nothing stands in it yet." } }
        p.links { a href=(format!("/builds/{}/pick", build.id)) { "Pick map for the person who breaks it out" }
            @if build.times.published_at.is_some() {
                a href=(format!("/builds/{}/break-out", build.id)) { "Break it out step by step" }
            } }
        @if let Some(fires) = fire_forecast(&web, &build, &profile).await? { p { "Fires " (fires) "." } }
        (fact_list(&build_facts(&build, Some(&profile), (copies.to_string(), None), &view)))
        (build_forms(&web, &build, &placements))
        (height_curve(&build.height_curve()))
        (outcome_list(&outcomes, &view))
        h2 { "Parts" }
        (table_of("Parts", None, BUILD_PART_COLUMNS, &rows, &view))
    };
    Ok(html_page(&format!("Build {}", build.id), "", Some("view.js"), &content))
}

/// When an open build fires, and which trigger fires it.
async fn fire_forecast(
    web: &DashboardState,
    build: &BuildRow,
    profile: &MachineProfile,
) -> HandlerResult<Option<String>> {
    if build.state != BuildState::Open {
        return Ok(None);
    }
    let status = web.ledger.profile_statuses().await?;
    Ok(status
        .iter()
        .find(|status| status.profile == build.profile)
        .and_then(|status| farm::fire_forecast_text(profile, status)))
}

/// A text that changes when the layout of the build changes. A proved build does not change any more.
fn view_version(build: &BuildRow) -> String {
    match build.state {
        BuildState::Open | BuildState::Nesting => layout_version(build),
        _ => "proved".to_owned(),
    }
}

/// Whether the reason of a build is a failure, not a note of the operator.
fn is_failure(state: BuildState) -> bool {
    matches!(state, BuildState::Failed | BuildState::Interrupted)
}

/// The 3D view, or a picture without JavaScript. A report has no `version`: it contains its scene and its picture.
pub(super) fn view_section(build: i64, copies: u32, version: &str) -> Markup {
    html! {
        section #view data-build=(build) data-copies=(copies) data-version=(version) aria-label="3D view" {
            @if !version.is_empty() {
                noscript { p { "The 3D view needs JavaScript. " } }
            } @else {
                noscript { p { "The 3D view needs JavaScript; the pick map has a picture." } }
            }
            div.stage {
                // Stands there until the view is drawn, and where it cannot be drawn.
                @if !version.is_empty() { div.poster { (cake_picture(build)) } }
                canvas tabindex="0" role="img" aria-label=(format!("Nest of {}; arrow keys turn it, + and - zoom", count(copies, "copy", "copies"))) {}
            }
            div.controls {
                label { "Cut at " output #cut-mm { } input #cut type="range" min="0" max="1000" value="1000"; }
                label { "Explode" input #explode type="range" min="0" max="100" value="0"; }
                button #home type="button" { "Whole view" }
            }
            p #hover role="status" { "Point at a copy to see what it is; click to see its siblings." }
        }
    }
}

/// A chart of the build height over the time of the search.
pub(super) fn height_curve(points: &Vec<(f64, f64)>) -> Markup {
    html! {
        @if points.len() > 1 {
            figure { figcaption { "Height while it was searched, mm over seconds" }
                (chart::plot_lines("Height over time", std::iter::once(points), &|secs| format!("{secs:.1} s"))) }
        }
    }
}

fn outcome_list(outcomes: &[OutcomeRow], view: &TimeView) -> Markup {
    html! {
        @if !outcomes.is_empty() {
            h2 { "What became of it" }
            (table_of("Outcomes", None, OUTCOME_COLUMNS, outcomes, view))
        }
    }
}
