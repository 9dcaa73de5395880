//! The first page: what needs a person, and a card per machine.

use std::sync::Arc;

use axum::extract::State;
use jiff::{SignedDuration, Timestamp};
use ledger::{BuildId, BuildRow, HeightSummary, HistoryQuery, MachineStatus, NodeRow};
use maud::{Markup, html};

use super::{
    machine_card::{MachineCard, brief_state},
    needs::needs_section,
};
use crate::{
    farm::{FarmReading, MachineFact, dates_at_risk, farm_summary, halt_summary, read_stored_alerts},
    settings::{MachineProfile, Settings},
    tables::{FarmNode, NODE_COLUMNS, TimeView, list_farm_nodes},
    web::{
        base::{
            error::HandlerResult,
            format::{count, format_age},
            listing::table_of,
            page::html_page,
        },
        core::{picture, state::DashboardState},
    },
};

/// The period whose builds say what density is usual.
const USUAL_PERIOD: SignedDuration = SignedDuration::from_hours(30 * 24);

/// The farm page.
pub(crate) async fn show_farm(State(web): State<Arc<DashboardState>>) -> HandlerResult<Markup> {
    let nodes = list_farm_nodes(&web.ledger).await?;
    let (settings, now) = (web.current_settings(), Timestamp::now());
    let reading = FarmReading::read(&web.ledger, settings.profiles.values(), now).await?;
    let (status, machines) = (&reading.rows.statuses, &reading.rows.observed);
    let daemon = nodes
        .iter()
        .map(|listed| &listed.node)
        .find(|node| web.ledger.file().is_some() || node.name == settings.node.name);
    let view = TimeView::at(&settings.time_zone, now);
    let builds = MachineBuilds::read_for(&web, now).await?;
    let (facts, at_risk) = (reading.facts(), dates_at_risk(reading.plans(&web.ledger).await?));
    let mut cards = Vec::with_capacity(settings.profiles.len());
    for ((name, profile), fact) in settings.profiles.iter().zip(&facts) {
        let status = MachineStatus::of_machine(status, name);
        let picture_html = picture::machine_picture(&web, &status).await?;
        let card = MachineCard {
            profile,
            fact,
            status: &status,
            observed: reading.rows.observed(name),
            nesting: find_builds(&web, status.nesting.iter().map(|build| build.build)).await?,
            last: find_builds(&web, status.last_published.iter().map(|build| build.build)).await?.pop(),
            at_risk: at_risk.iter().filter(|risk| risk.machine == *name).collect(),
            usual_density: builds.usual.iter().find(|sum| sum.machine == *name).and_then(|sum| sum.mean_density),
        };
        cards.push(card.draw_card(&web, &picture_html, &view));
    }
    let gone = status.iter().filter(|s| !settings.profiles.contains_key(&s.machine));
    let alerts = read_stored_alerts(&settings.state_dir);
    let activity = halt_summary(&alerts).unwrap_or_else(|| farm_summary(settings.profiles.len(), status.iter()));
    let content = html! {
        h1 { "Farm" }
        (daemon_line(daemon, &activity, web.ledger.silence_hint(), now))
        (nodes_section(&nodes, &view))
        (machine_strip(&settings, status, &facts, now))
        (needs_section(&web, &alerts, now).await?)
        div.cards {
            @for card in &cards { (card) }
        }
        @for status in gone {
            p { "The machine " b { (status.machine) }
                @match machines.iter().find(|observed| observed.machine == status.machine && !observed.node.is_empty()) {
                    Some(observed) => { " is served by the node " (node_link(&nodes, &observed.node)) ": " }
                    None => { " is no longer configured: " }
                }
                (count(status.waiting_parts, "part waits", "parts wait")) "." }
        }
        @if settings.profiles.is_empty() { p { "No machine is configured on this node." } }
    };
    Ok(html_page("Farm", "/", Some("drop.js"), &content))
}

/// A line per machine, for a phone, where the cards come after what needs a person.
fn machine_strip(settings: &Settings, statuses: &[MachineStatus], facts: &[MachineFact], now: Timestamp) -> Markup {
    let line = |((name, profile), fact): ((&String, &MachineProfile), &MachineFact)| {
        let status = statuses.iter().find(|status| status.machine == *name);
        html! {
            li { a href=(format!("#{name}")) { (name) } " " span.soft { (brief_state(profile, status, fact, now)) } }
        }
    };
    html! { ul.strip aria-label="Machines" { @for machine in settings.profiles.iter().zip(facts) { (line(machine)) } } }
}

/// What the cards of all machines show of builds and due dates.
struct MachineBuilds {
    /// The builds of the last weeks.
    usual: Vec<HeightSummary>,
}

impl MachineBuilds {
    async fn read_for(web: &DashboardState, now: Timestamp) -> HandlerResult<Self> {
        let usual = HistoryQuery { since: now.checked_sub(USUAL_PERIOD).ok(), ..HistoryQuery::default() };
        Ok(Self { usual: web.ledger.height_summaries(&usual).await? })
    }
}

/// The builds with these numbers.
async fn find_builds(web: &DashboardState, ids: impl Iterator<Item = BuildId>) -> HandlerResult<Vec<BuildRow>> {
    let mut found = Vec::new();
    for id in ids {
        found.extend(web.ledger.find_build(id).await?);
    }
    Ok(found)
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

/// The state of the daemon. `activity` says what it does, according to the rows and alerts that the page shows.
fn daemon_line(daemon: Option<&NodeRow>, activity: &str, silence_hint: &str, now: Timestamp) -> Markup {
    match daemon {
        Some(d) if d.is_silent(now) => html! {
            p.bad role="alert" {
                "The daemon runs on " (d.host) ", but has not written into the ledger for " (format_age(d.beat_at.0, now))
                ": this page may be that old. " (silence_hint) "."
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
