//! The first page: what needs a person, which dates are at risk, and the board with a row for each machine.

use std::{collections::BTreeMap, sync::Arc};

use axum::{extract::State, response::Redirect};
use jiff::{SignedDuration, Timestamp};
use ledger::{BuildId, HistoryQuery, MachineStatus, NodeRow};
use maud::{Markup, html};

use super::needs::needs_section;
use crate::{
    farm::{
        DateRisk, FarmReading, FarmRows, MachineFact, MachinePlan, PrinterWord, dates_at_risk, farm_summary,
        halt_summary, read_stored_alerts,
    },
    settings::Settings,
    tables::{FarmNode, GivenDate, NODE_COLUMNS, TimeView, list_farm_nodes},
    web::{
        base::{
            error::HandlerResult,
            format::{count, format_age},
            listing::table_of,
            page::html_page,
            query::order_address,
        },
        board::{
            axis::TimeAxis,
            job::JobSetting,
            machine_row::{MachineRowOnBoard, drawn_builds},
        },
        core::{cached_render::layout_version, state::DashboardState},
        look::{
            chip::{Tone, chip},
            pieces::{empty, figure, figure_link},
            times::{due_of, time_of},
        },
    },
};

/// The period whose builds say what density is usual.
const USUAL_PERIOD: SignedDuration = SignedDuration::from_hours(30 * 24);
/// Due dates at risk that are shown at once.
const MAX_AT_RISK: usize = 3;

/// What the page is made of.
struct FarmSight {
    settings: Arc<Settings>,
    now: Timestamp,
    rows: FarmRows,
    facts: Vec<MachineFact>,
    plans: Vec<MachinePlan>,
    nodes: Vec<FarmNode>,
}

impl FarmSight {
    async fn read(web: &DashboardState) -> HandlerResult<Self> {
        let (settings, now) = (web.current_settings(), Timestamp::now());
        let nodes = list_farm_nodes(&web.ledger).await?;
        let reading = FarmReading::read(&web.ledger, settings.profiles.values(), now).await?;
        let (facts, plans) = (reading.facts(), reading.plans(&web.ledger).await?);
        let rows = reading.rows;
        Ok(Self { settings: settings.clone(), now, rows, facts, plans, nodes })
    }

    /// The version of the layout of each build that the board can draw.
    async fn layouts(&self, web: &DashboardState) -> HandlerResult<BTreeMap<BuildId, String>> {
        let mut layouts = BTreeMap::new();
        for id in self.plans.iter().flat_map(drawn_builds) {
            if let Some(build) = web.ledger.find_build(id).await? {
                layouts.insert(id, layout_version(&build));
            }
        }
        Ok(layouts)
    }

    /// The node of this page.
    fn own_node(&self, web: &DashboardState) -> Option<&NodeRow> {
        let mut nodes = self.nodes.iter().map(|listed| &listed.node);
        nodes.find(|node| web.ledger.file().is_some() || node.name == self.settings.node.name)
    }
}

/// The farm page.
pub(crate) async fn show_farm(State(web): State<Arc<DashboardState>>) -> HandlerResult<Markup> {
    let read = FarmSight::read(&web).await?;
    let (now, view) = (read.now, TimeView::at(&read.settings.time_zone, read.now));
    let alerts = read_stored_alerts(&read.settings.state_dir);
    let activity =
        halt_summary(&alerts).unwrap_or_else(|| farm_summary(read.settings.profiles.len(), read.rows.statuses.iter()));
    let risks = dates_at_risk(read.plans.clone());
    let why_silent = match alerts.iter().any(|alert| alert.kind.cuts_ledger_off()) {
        true => "It is said below why".to_owned(),
        false => web.ledger.silence_hint().await?,
    };
    let (runs, line) = daemon_line(read.own_node(&web), &activity, &why_silent, &view, now);
    let content = html! {
        div.farm-head { h1 { "Farm" } (figures(&read, &risks)) }
        @if !runs { (line) }
        div.urgent {
            (needs_section(&web, &alerts, now).await?)
            (risks_section(&risks, &view))
        }
        (board(&web, &read, &view).await?)
        (others(&read))
        @if runs { (line) }
        (nodes_section(&read.nodes, &view))
    };
    Ok(html_page("Farm", "/", Some("drop.js"), &content))
}

/// The plan stands on the farm page.
pub(crate) async fn lead_to_board() -> Redirect {
    Redirect::permanent("/")
}

/// The farm in numbers.
fn figures(read: &FarmSight, risks: &[DateRisk]) -> Markup {
    let printers: Vec<PrinterWord> =
        read.facts.iter().flat_map(|fact| &fact.printers).map(|printer| printer.state).collect();
    let print = printers.iter().filter(|word| **word == PrinterWord::Printing).count();
    let waiting: u32 = read.rows.statuses.iter().map(|status| status.waiting_copies).sum();
    let late = risks.iter().filter(|risk| risk.is_late).count();
    let tone = |number: usize, tone: Tone| (number > 0).then_some(tone);
    html! {
        ul.figures {
            (figure(&format!("{print} of {}", printers.len()), "printers print", None))
            (figure(&waiting.to_string(), if waiting == 1 { "copy waits" } else { "copies wait" }, None))
            (figure_link(&late.to_string(), "dates late", tone(late, Tone::Wrong), "#risks"))
            (figure_link(&(risks.len() - late).to_string(), "dates tight", tone(risks.len() - late, Tone::Tight), "#risks"))
        }
    }
}

/// The dates at risk, the earliest first.
fn risks_section(risks: &[DateRisk], view: &TimeView) -> Markup {
    let (shown, folded) = risks.split_at(risks.len().min(MAX_AT_RISK));
    html! {
        @if !shown.is_empty() {
            section.risks #risks aria-label="Late, or at risk to be" {
                h2 { "Late, or at risk to be" }
                ul.rows { @for risk in shown { (risk_row(risk, view)) } }
                @if !folded.is_empty() {
                    details { summary { (count(folded.len() as u32, "more date", "more dates")) }
                        ul.rows { @for risk in folded { (risk_row(risk, view)) } } }
                }
            }
        }
    }
}

/// A date at risk, as a row that leads to its order or part.
pub(super) fn risk_row(risk: &DateRisk, view: &TimeView) -> Markup {
    let part = || risk.numbers.first().map(|part| format!("/parts/{part}")).unwrap_or_default();
    let page = if risk.order.is_empty() { part() } else { order_address(&risk.order) };
    let due = GivenDate { due_at: risk.due_at, text: risk.due_text.clone() };
    html! {
        li { a.row href=(page) {
            span.row-name { (risk.subject_text()) } (chip(risk.word()))
            span.row-more { "due " (due_of(&due, view))
                @if let Some(done) = risk.done_at { ", done about " (time_of(done, view)) }
                span.why { ": " (risk.reason) } "." }
        } }
    }
}

/// The board.
async fn board(web: &DashboardState, read: &FarmSight, view: &TimeView) -> HandlerResult<Markup> {
    let layouts = read.layouts(web).await?;
    let axis = TimeAxis::new(read.now, &read.settings.time_zone);
    let setting = JobSetting { axis: &axis, view, layouts: &layouts };
    let usual = HistoryQuery { since: read.now.checked_sub(USUAL_PERIOD).ok(), ..HistoryQuery::default() };
    let usual = web.ledger.height_summaries(&usual).await?;
    let nothing = MachineStatus::default();
    let mut rows = Vec::new();
    for ((profile, fact), plan) in read.settings.profiles.values().zip(&read.facts).zip(&read.plans) {
        let own = |status: &&MachineStatus| status.machine == profile.name;
        let status = read.rows.statuses.iter().find(own).unwrap_or(&nothing);
        let last = match &status.last_published {
            Some(last) => web.ledger.find_build(last.build).await?,
            None => None,
        };
        rows.push(MachineRowOnBoard {
            profile,
            fact,
            plan,
            status,
            observed: read.rows.observed(&profile.name),
            last,
            usual_density: usual.iter().find(|sum| sum.machine == profile.name).and_then(|sum| sum.mean_density),
        });
    }
    rows.sort_by_key(MachineRowOnBoard::urgency);
    let is_new = read.rows.statuses.iter().all(|status| status.last_published.is_none() && status.waiting_parts == 0)
        && read.plans.iter().all(|plan| plan.builds.is_empty());
    Ok(html! {
        @if rows.is_empty() { (no_machine()) }
        @else if is_new { (nothing_came(web.orders)) }
        @if !rows.is_empty() {
            section.board aria-label="Board" data-zone=[read.settings.time_zone.time_zone().iana_name()] {
                (axis.draw())
                @for row in &rows { (row.draw(web, &setting)) }
                (legend())
            }
        }
    })
}

/// What the looks of the board mean.
fn legend() -> Markup {
    html! {
        p.legend aria-hidden="true" {
            span { i.solid {} "is printed" } span { i.outlined {} "is made, or lies in the queue" } span { i.dashed {} "is to come, if nothing more arrives" }
            span { i.cool {} "cools" } span { i.closed {} "no print begins" }
        }
    }
}

fn no_machine() -> Markup {
    let text = html! { "A machine is a file of a few lines: its volume, its clearance, its printers. " code { "nestd machine new" }
    " writes it." };
    empty(
        "No machine is configured on this node",
        &text,
        &html! { a.button.first href="/help/administrator" { "How to add a machine" } },
    )
}

fn nothing_came(takes_orders: bool) -> Markup {
    let text = html! {
        "Drop STL or 3MF files "
        @if takes_orders { "on a machine below, or copy them " }
        "into its hot folder. The farm collects them, nests them as low as it can and puts the build into the printer's queue."
    };
    empty("Nothing has come yet", &text, &html! { a.button.first href="/help/technician" { "How parts come in" } })
}

/// Machines that are not configured here, for which parts wait.
fn others(read: &FarmSight) -> Markup {
    let gone = read.rows.statuses.iter().filter(|status| !read.settings.profiles.contains_key(&status.machine));
    let node = |name: &str| read.rows.observed(name).map(|observed| &observed.node).filter(|node| !node.is_empty());
    html! {
        @for status in gone {
            p.elsewhere { "The machine " b { (status.machine) }
                @match node(&status.machine) {
                    Some(node) => { " is served by the node " (node_link(&read.nodes, node)) ": " }
                    None => { " is no longer configured: " }
                }
                (count(status.waiting_parts, "part waits", "parts wait")) "." }
        }
    }
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

/// Whether the daemon runs, and its state. `activity` says what it does, according to the rows and alerts that the page shows.
fn daemon_line(
    daemon: Option<&NodeRow>,
    activity: &str,
    why_silent: &str,
    view: &TimeView,
    now: Timestamp,
) -> (bool, Markup) {
    let line = match daemon {
        Some(d) if d.is_silent(now) => html! {
            p.bad role="alert" {
                "The daemon runs on " (d.host) ", but has not written into the ledger for " (format_age(d.beat_at.0, now))
                ": this page may be that old. " (why_silent) "."
            }
        },
        Some(d) if d.alive => {
            let text =
                html! { "The daemon runs on " (d.host) " since " (time_of(d.started_at, view)) ": " (activity) "." };
            return (true, html! { p.ok.daemon { (text) } });
        }
        Some(d) => html! {
            p.bad role="alert" { "The daemon does not run; its last sign of life was " (format_age(d.beat_at.0, now)) " ago." }
        },
        None => html! { p.bad role="alert" { "The daemon has not run yet." } },
    };
    (false, line)
}
