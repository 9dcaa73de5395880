//! The first page: a card per machine with the waiting parts, the next build and command buttons.

use std::sync::Arc;

use axum::extract::State;
use jiff::Timestamp;
use maud::{Markup, html};

use super::{
    build_forms::unseen_failure,
    command::command_button,
    error::HandlerResult,
    format::{DASH, count, format_age, prose_with_code},
    listing::{fact_list, table_of},
    page::html_page,
    picture,
    state::DashboardState,
};
use crate::{
    farm::{FarmAlert, farm_summary, forecast_fire, halt_summary, read_stored_alerts},
    ledger::{CommandKind, MachineRow, NodeRow, OpenBuildForecast, ProfileStatus},
    settings::MachineProfile,
    tables::{
        FarmNode, GivenDate, MachineForecast, NODE_COLUMNS, SheetFact, TimeView, fields, height_in_volume,
        list_farm_nodes,
    },
};

/// The farm page.
pub(super) async fn show_farm(State(web): State<Arc<DashboardState>>) -> HandlerResult<Markup> {
    let (status, nodes) = (web.ledger.profile_statuses().await?, list_farm_nodes(&web.ledger).await?);
    let machines = web.ledger.list_machines().await?;
    let (settings, now) = (web.current_settings(), Timestamp::now());
    let daemon = nodes
        .iter()
        .map(|listed| &listed.node)
        .find(|node| web.ledger.file().is_some() || node.name == settings.node.name);
    let view = TimeView::at(&settings.time_zone, now);
    let nothing = |name: &str| ProfileStatus { profile: name.to_owned(), ..ProfileStatus::default() };
    let of = |name: &str| status.iter().find(|s| s.profile == name).cloned().unwrap_or_else(|| nothing(name));
    let mut cards = Vec::with_capacity(settings.profiles.len());
    for (name, profile) in &settings.profiles {
        let status = of(name);
        let picture_html = picture::profile_picture(&web, &status).await?;
        let observed = machines.iter().find(|observed| observed.profile == *name);
        cards.push(machine_card(&web, profile, (&status, observed), &picture_html, &view));
    }
    let gone = status.iter().filter(|s| !settings.profiles.contains_key(&s.profile));
    let failures = web.ledger.unseen_failures().await?;
    let alerts = read_stored_alerts(&settings.state_dir);
    let activity = halt_summary(&alerts).unwrap_or_else(|| farm_summary(settings.profiles.len(), status.iter()));
    let content = html! {
        h1 { "Farm" }
        (daemon_line(daemon, &activity, now))
        (nodes_section(&nodes, &view))
        (alerts_section(&alerts, now))
        @for build in &failures { (unseen_failure(&web, build)) }
        div.cards {
            @for card in &cards { (card) }
        }
        @for status in gone {
            p { "The profile " b { (status.profile) }
                @match machines.iter().find(|observed| observed.profile == status.profile && !observed.node.is_empty()) {
                    Some(observed) => { " is served by the node " (node_link(&nodes, &observed.node)) ": " }
                    None => { " is no longer configured: " }
                }
                (count(status.waiting_parts, "part waits", "parts wait")) "." }
        }
        @if settings.profiles.is_empty() { p { "No machine is configured: this node searches for the builds of others." } }
    };
    Ok(html_page("Farm", "/", None, &content))
}

/// The name of a node, with a link to its pages where it has any.
fn node_link(nodes: &[FarmNode], name: &str) -> Markup {
    match nodes.iter().find(|listed| listed.node.name == name && !listed.node.address.is_empty()) {
        Some(listed) => html! { a href=(listed.node.address) { (name) } },
        None => html! { b { (name) } },
    }
}

/// The nodes, where there are several.
fn nodes_section(nodes: &[FarmNode], view: &TimeView) -> Markup {
    html! {
        @if nodes.len() > 1 {
            details.nodes open[nodes.iter().any(|listed| !listed.node.alive)] {
                summary { (count(nodes.len() as u32, "node", "nodes")) ", "
                    (nodes.iter().filter(|listed| listed.node.alive).count()) " running" }
                (table_of("Nodes", None, NODE_COLUMNS, nodes, view))
            }
        }
    }
}

/// The problems that a person must solve, each with its remedy.
fn alerts_section(notices: &[FarmAlert], now: Timestamp) -> Markup {
    html! {
        @if !notices.is_empty() {
            section.needs aria-label="Needs a person" {
                h2 { (count(notices.len() as u32, "thing needs a person", "things need a person")) }
                // Folded: on a phone the machines come next.
                @for notice in notices { details {
                    summary { b { (notice.alert_text()) } }
                    p { (prose_with_code(notice.kind.remedy())) " Since " (format_age(notice.since, now)) "." }
                } }
            }
        }
    }
}

/// The state of the daemon. `activity` says what it does, according to the rows and alerts that the page shows.
fn daemon_line(daemon: Option<&NodeRow>, activity: &str, now: Timestamp) -> Markup {
    match daemon {
        Some(d) if d.is_silent(now) => html! {
            p.bad role="alert" {
                "The daemon runs on " (d.host) ", but has not written into the ledger for " (format_age(d.beat_at.0, now))
                ": this page may be that old. Free some room where the disk of the state folder is full."
            }
        },
        Some(d) if d.alive => html! {
            p.ok.daemon { "The daemon runs on " (d.host) " for " (format_age(d.started_at.0, now)) ": " (activity) "." }
        },
        Some(d) => html! {
            p.bad role="alert" { "The daemon does not run; its last sign of life was " (format_age(d.beat_at.0, now)) " ago." }
        },
        None => html! { p.bad role="alert" { "The daemon has not run yet." } },
    }
}

/// Why a machine takes no parts, if so: an operator paused it, or the daemon found it unavailable.
fn machine_warnings(status: &ProfileStatus, observed: Option<&MachineRow>, view: &TimeView) -> Vec<String> {
    let paused = status.paused.as_ref().map(|paused| {
        format!("Paused by {} since {}: nothing is fired.", paused.paused_by, view.time_text(paused.paused_at))
    });
    let unavailable = observed.filter(|observed| !observed.trouble.is_empty()).map(|observed| {
        let since = observed.trouble_at.map(|at| format!(", since {}", view.time_text(at))).unwrap_or_default();
        format!("Unavailable{since}: {}", observed.trouble)
    });
    paused.into_iter().chain(unavailable).collect()
}

/// When the open build of a machine fires, and which trigger fires it.
pub(super) fn fire_forecast_text(profile: &MachineProfile, status: &ProfileStatus) -> Option<String> {
    Some(forecast_fire(profile, status)?.fire_text(profile, status))
}

fn machine_card(
    web: &DashboardState,
    profile: &MachineProfile,
    (status, observed): (&ProfileStatus, Option<&MachineRow>),
    picture_html: &Markup,
    view: &TimeView,
) -> Markup {
    let name = profile.name.as_str();
    let machine = MachineForecast::new(status.clone(), Some(profile));
    let open = machine.forecast_build();
    html! {
        section.card aria-label=(name) {
            h2 { (name) }
            @for text in machine_warnings(status, observed, view) { p.bad role="status" { (text) } }
            (picture_html)
            @if let Some(open) = open { (open_build(open, profile.space.volume_mm.z)) } @else { p { "No open build." } }
            (fact_list(&waiting(&machine, fire_forecast_text(profile, status), view)))
            @if status.rejected_parts > 0 {
                p { a href=(format!("/parts?state=rejected&profile={name}")) { (fields::REJECTED.label) ": " (status.rejected_parts) } }
            }
            @for build in &status.nesting {
                p { "Build " a href=(format!("/builds/{}", build.build)) { (build.build) } " is being made: "
                    (count(build.copies, "copy", "copies")) "." }
            }
            @if let Some(last) = &status.last_published {
                p { (fields::LAST_PUBLISHED.label) ": build " a href=(format!("/builds/{}", last.build)) { (last.build) }
                    @if let Some(height) = fields::HEIGHT.with_unit(last.height_mm) { ", " (height) }
                    ", " (view.time_text(last.published_at)) }
            }
            div.buttons {
                (command_button(web, CommandKind::Flush, "Flush", &format!("{name}: publish what waits now"), name, None))
                @if status.paused.is_some() { (command_button(web, CommandKind::Resume, "Resume", name, name, None)) }
                @else { (command_button(web, CommandKind::Pause, "Pause", name, name, None)) }
            }
        }
    }
}

/// The forecast of the next build.
fn open_build(open: &OpenBuildForecast, volume_z_mm: f64) -> Markup {
    let height = height_in_volume(open.height_mm, Some(volume_z_mm)).unwrap_or_else(|| DASH.to_owned());
    let density = fields::DENSITY.with_unit(open.density).map(|density| format!(", {density} dense"));
    html! {
        p { "Open build " a href=(format!("/builds/{}", open.build)) { (open.build) } ": " b { (height) }
            (density.unwrap_or_default()) ", " (count(open.copies.unwrap_or(0), "copy", "copies")) }
        meter min="0" max=(volume_z_mm) value=(open.height_mm.unwrap_or(0.0)) aria-label="Height of the open build, mm" {}
    }
}

/// What waits for a machine, and until when.
fn waiting(machine: &MachineForecast, fires: Option<String>, view: &TimeView) -> Vec<SheetFact> {
    let status = &machine.status;
    let parts = count(status.waiting_parts, "part", "parts");
    let lines = [
        Some(fields::WAITING.fact_of(format!("{} of {parts}", count(status.waiting_copies, "copy", "copies")))),
        fields::OLDEST.fact(view.now().and_then(|now| machine.oldest(now))),
        view.due_fact(fields::DUE, GivenDate::new(status.due_at, &status.due_text)),
        fields::FIRES.fact(fires),
        Some(fields::BEING_READ.fact_of(count(status.claimed_parts, "file", "files"))),
    ];
    lines.into_iter().flatten().collect()
}
