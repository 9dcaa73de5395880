//! The page of a build: 3D view, facts and parts.

use std::sync::Arc;

use axum::extract::{Path, State};
use farm::{BuildFact, CakeCopy, FarmReading, build_fact, load_placed_parts, read_plans};
use jiff::Timestamp;
use language::say;
use ledger::{BuildRow, BuildState, MachineStatus, OutcomeRow, PartRow};
use maud::{Markup, html};
use settings::MachineProfile;

use super::{
    costs::{CostQuestion, cost_figure},
    downloads::downloads_sheet,
};
use crate::{
    tables::{
        BUILD_PART_COLUMNS, BUILD_PART_PAGE_KEYS, CountedPart, GivenDate, OUTCOME_COLUMNS, TimeView, build_facts,
        fields,
    },
    web::{
        base::{
            error::HandlerResult,
            format::prose_with_code,
            listing::{fact_sheet, table_of, table_of_keys},
            page::html_page,
        },
        board::machine_row::fire_time,
        core::{
            cached_render::{find_build, layout_version},
            state::DashboardState,
            view_section::{ViewSection, ViewedPart},
        },
        figures::chart::height_curve,
        forms::build_forms::{again_forms, outcome_forms, release_form, second_files, unseen_failure},
        look::{
            chip::{Tone, chip},
            pieces::{figure, figure_link},
        },
        paper::label_form::build_labels,
    },
};

/// The page of a build.
pub(crate) async fn show_build(
    State(web): State<Arc<DashboardState>>,
    Path(number_of_build): Path<i64>,
) -> HandlerResult<Markup> {
    let (build, profile) = find_build(&web, number_of_build).await?;
    let parts = load_placed_parts(&web.ledger, &build, &profile).await?;
    let copies: u32 = parts.iter().map(|(_, copies)| copies.len() as u32).sum();
    // Counts only the copies in this build: the other copies are in other builds, or wait.
    let outcomes = web.ledger.outcomes_of_build(build.id).await?;
    let placements = web.ledger.placements_of_build(build.id).await?;
    let here = |(part, copies): (PartRow, Vec<CakeCopy>)| CountedPart::of_build(part, copies.len() as u32, &placements);
    let rows: Vec<CountedPart> = parts.into_iter().map(here).collect();
    let is_unseen = web.ledger.unseen_failures().await?.iter().any(|failed| failed.id == build.id);
    let view = web.time_view();
    // What the machine asks for now counts, not what it asked for when the build was made.
    let machine = web.current_settings().profiles.get(&build.machine).cloned();
    let release = match &machine {
        Some(machine) => release_form(&web, &build, machine).await?,
        None => Markup::default(),
    };
    let plans = read_plans(&web.ledger, &machine, Timestamp::now()).await?;
    let fact = build_fact(&build, &plans);
    let cost = cost_figure(&web, CostQuestion::of_build(build.id)).await?;
    let content = html! {
        h1 { (say!("build-on", build = build.id.to_string(), printer = &build.machine)) " " (chip(&fact.word)) }
        (figures((&build, &fact), &rows, &profile, cost.as_ref(), &view))
        (second_files(&web, &build).await?)
        @if is_unseen { (unseen_failure(&web, &build)) }
        @else if !build.reason.is_empty() {
            p class=(if is_failure(&build) { "bad" } else { "note" }) role="status" { (prose_with_code(&build.reason)) }
        }
        @if let Some(fires) = fire_forecast(&web, &build, &profile, &view).await? { p { (fires) } }
        (release)
        div.acts #told {
            (act_group(&say!("acts-print"), &outcome_forms(&web, &build, &placements, &rows)))
            (act_group(&say!("acts-unpack"), &html! {
                @if build.times.published_at.is_some() {
                    a.button href=(format!("/builds/{}/break-out", build.id)) { (say!("break-out-steps")) }
                }
                a.button href=(format!("/builds/{}/pick", build.id)) { (say!("pick-map")) }
                @if copies > 0 { (build_labels(build.id.0)) (downloads_sheet(&build, &profile).await?) }
            }))
            (act_group(&say!("acts-again"), &again_forms(&web, &build, &placements)))
        }
        @if copies > 0 { (view_of_build(&build, &rows, &view).to_markup()) } @else { p { (say!("nothing-in-it")) } }
        (fact_sheet(build_facts(&build, Some(&profile), (copies.to_string(), None), &view), &[fields::HEIGHT, fields::DENSITY], &view))
        (outcome_list(&outcomes, &view))
        h2 #parts { (fields::PARTS.said()) }
        (table_of_keys((&fields::PARTS.said(), None), BUILD_PART_COLUMNS, &BUILD_PART_PAGE_KEYS, &rows, &view))
        (height_curve(&build.height_curve()))
    };
    Ok(html_page(&say!("build-number", build = build.id.to_string()), "", Some("start.js"), &content))
}

/// Buttons of one purpose, if there are any.
fn act_group(label: &str, buttons: &Markup) -> Markup {
    html! { @if !buttons.0.trim().is_empty() { div.act-group role="group" aria-label=(label) { span.soft { (label) } div.buttons { (buttons) } } } }
}

/// The build in numbers.
fn figures(
    (build, fact): (&BuildRow, &BuildFact),
    rows: &[CountedPart],
    profile: &MachineProfile,
    cost: Option<&(String, String)>,
    view: &TimeView,
) -> Markup {
    let copies: u32 = rows.iter().map(|row| row.copies).sum();
    let bad: usize = rows.iter().map(|row| row.bad.len()).sum();
    let volume = fields::VOLUME_Z.with_unit(profile.space.volume_mm.z).unwrap_or_default();
    html! {
        ul.figures {
            @if let Some(height) = fields::HEIGHT.with_unit(build.measures.height_mm) { (figure(&height, &say!("figure-high", volume = volume), None)) }
            (figure(&copies.to_string(), &say!("figure-copies", count = copies), None))
            @if bad > 0 { (figure_link(&bad.to_string(), &say!("figure-bad", count = bad), Some(Tone::Wrong), "#parts")) }
            @if let Some(density) = fields::DENSITY.with_unit(build.measures.density) { (figure(&density, &say!("figure-dense"), None)) }
            @if let Some((cost, address)) = cost { (figure_link(cost, &say!("figure-cost"), None, address)) }
            @if let Some(ends) = fact.ends_at { (figure(&view.estimate_text(ends), &say!("figure-unpacked"), None)) }
        }
    }
}

/// The 3D view of a build with its parts.
fn view_of_build(build: &BuildRow, rows: &[CountedPart], view: &TimeView) -> ViewSection {
    let due = |counted: &CountedPart| GivenDate::of_terms(&counted.part.terms).map(|due| view.near_due_text(&due));
    let part = |counted: &CountedPart| ViewedPart::of_counted(counted, due(counted).unwrap_or_default());
    ViewSection { build: build.id.0, version: view_version(build), parts: rows.iter().map(part).collect() }
}

/// When an open build fires, and which trigger fires it.
async fn fire_forecast(
    web: &DashboardState,
    build: &BuildRow,
    profile: &MachineProfile,
    view: &TimeView,
) -> HandlerResult<Option<Markup>> {
    if build.state != BuildState::Open {
        return Ok(None);
    }
    let now = Timestamp::now();
    let reading = FarmReading::read(&web.ledger, [profile], now).await?;
    let (facts, status) = (reading.facts(), MachineStatus::of_machine(&reading.rows.statuses, &build.machine));
    let fires = facts.first().and_then(|fact| fact.forecast_fire(profile, &status, now));
    Ok(fires.map(|fires| fire_time(&fires, (profile, &status), view)))
}

/// A text that changes when the layout of the build changes. A proved build does not change any more.
fn view_version(build: &BuildRow) -> String {
    match build.state {
        BuildState::Open | BuildState::Nesting => layout_version(build),
        _ => "proved".to_owned(),
    }
}

/// Whether the reason of a build is a failure, not a note of the operator.
fn is_failure(build: &BuildRow) -> bool {
    build.place.withdrawn_at.is_none() && matches!(build.state, BuildState::Failed | BuildState::Interrupted)
}

fn outcome_list(outcomes: &[OutcomeRow], view: &TimeView) -> Markup {
    html! {
        @if !outcomes.is_empty() {
            h2 { (say!("what-became")) }
            (table_of(&say!("outcomes"), None, OUTCOME_COLUMNS, outcomes, view))
        }
    }
}
