//! The first page: what needs a person, which dates are at risk, and the board with a row for each machine.

use std::{collections::BTreeMap, sync::Arc};

use access::Role;
use axum::{extract::State, response::Redirect};
use farm::{
    DateRisk, FarmAlert, FarmReading, FarmRows, MachineFact, MachinePlan, PrinterWord, alerts_of_farm, dates_at_risk,
    farm_summary, halt_summary,
};
use jiff::{SignedDuration, Timestamp};
use language::{colon, say};
use ledger::{BuildId, HistoryQuery, MachineStatus, NodeRow};
use maud::{Markup, html};
use settings::Settings;

use super::needs::needs_section;
use crate::{
    tables::{FarmNode, GivenDate, NODE_COLUMNS, TimeView, list_farm_nodes},
    web::{
        base::{error::HandlerResult, format::format_age, listing::table_of, page::html_page, query::order_address},
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
    let alerts = alerts_of_farm(&read.settings, read.nodes.iter().map(|listed| &listed.node));
    let activity =
        halt_summary(&alerts).unwrap_or_else(|| farm_summary(read.settings.profiles.len(), read.rows.statuses.iter()));
    let risks = dates_at_risk(read.plans.clone());
    let why_silent = match alerts.iter().any(FarmAlert::cuts_ledger_off) {
        true => say!("why-below"),
        false => web.ledger.silence_hint().await?,
    };
    let (runs, line) = daemon_line(read.own_node(&web), &activity, &why_silent, &view, now);
    let content = html! {
        div.farm-head { h1 { (say!("nav-farm")) } (figures(&read, &risks)) }
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
    Ok(html_page(&say!("nav-farm"), "/", Some("drop.js"), &content))
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
            (figure(&say!("number-of", number = print, all = printers.len()), &say!("figure-print"), None))
            (figure(&waiting.to_string(), &say!("figure-wait", count = waiting), None))
            (figure_link(&late.to_string(), &say!("figure-late", count = late), tone(late, Tone::Wrong), "#risks"))
            (figure_link(&(risks.len() - late).to_string(), &say!("figure-tight", count = risks.len() - late), tone(risks.len() - late, Tone::Tight), "#risks"))
        }
    }
}

/// The dates at risk, the earliest first.
fn risks_section(risks: &[DateRisk], view: &TimeView) -> Markup {
    let (shown, folded) = risks.split_at(risks.len().min(MAX_AT_RISK));
    html! {
        @if !shown.is_empty() {
            section.risks #risks aria-label=(say!("risks")) {
                h2 { (say!("risks")) }
                ul.rows { @for risk in shown { (risk_row(risk, view)) } }
                @if !folded.is_empty() {
                    details { summary { (say!("more-dates", count = folded.len())) }
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
            span.row-more {
                @match risk.done_at {
                    Some(done) => (phrase!("due-done", due = due_of(&due, view), done = time_of(done, view))),
                    None => (phrase!("due-on", due = due_of(&due, view))),
                }
                span.why { (colon()) (view.near_times(&risk.reason)) } (say!("sign-stop")) }
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
        @else if is_new { (nothing_came(web.offers(Role::Order))) }
        @if !rows.is_empty() {
            section.board aria-label=(say!("board")) data-zone=[read.settings.time_zone.time_zone().iana_name()] {
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
            span { i.solid {} (say!("legend-solid")) } span { i.outlined {} (say!("legend-outlined")) }
            span { i.dashed {} (say!("legend-dashed")) }
            span { i.cool {} (say!("legend-cool")) } span { i.closed {} (say!("legend-closed")) }
        }
    }
}

fn no_machine() -> Markup {
    let text = phrase!("no-machine-text", command = html! { code { "nestd machine new" } });
    empty(
        &say!("no-machine"),
        &text,
        &html! { a.button.first href="/help/administrator" { (say!("no-machine-help")) } },
    )
}

fn nothing_came(takes_orders: bool) -> Markup {
    let text = match takes_orders {
        true => say!("nothing-came-drop", formats = say!("drop-formats")),
        false => say!("nothing-came-copy", formats = say!("drop-formats")),
    };
    let help = html! { a.button.first href="/help/technician" { (say!("nothing-came-help")) } };
    empty(&say!("nothing-came"), &html! { (text) }, &help)
}

/// Machines that are not configured here, for which parts wait.
fn others(read: &FarmSight) -> Markup {
    let gone = read.rows.statuses.iter().filter(|status| !read.settings.profiles.contains_key(&status.machine));
    let node = |name: &str| read.rows.observed(name).map(|observed| &observed.node).filter(|node| !node.is_empty());
    html! {
        @for status in gone {
            @let machine = html! { b { (status.machine) } };
            p.elsewhere {
                @match node(&status.machine) {
                    Some(node) => (phrase!("machine-of-node", machine = machine, node = node_link(&read.nodes, node), parts = status.waiting_parts)),
                    None => (phrase!("machine-is-gone", machine = machine, parts = status.waiting_parts)),
                }
            }
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
                @let running = nodes.iter().filter(|listed| listed.node.alive).count();
                summary { (say!("nodes-running", count = nodes.len(), running = running)) }
                (table_of(&say!("nodes"), None, NODE_COLUMNS, nodes, view))
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
                (say!("daemon-silent", host = &d.host, age = format_age(d.beat_at.0, now), why = why_silent))
            }
        },
        Some(d) if d.alive => {
            let text = phrase!("daemon-runs", host = &d.host, time = time_of(d.started_at, view), activity = activity);
            return (true, html! { p.ok.daemon { (text) } });
        }
        Some(d) => html! {
            p.bad role="alert" { (say!("daemon-dead", age = format_age(d.beat_at.0, now))) }
        },
        None => html! { p.bad role="alert" { (say!("daemon-never-ran")) } },
    };
    (false, line)
}
