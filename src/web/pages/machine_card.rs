//! The card of a machine on the farm page: what it does, when its next build fires, what is late, how full the build is.

use jiff::Timestamp;
use ledger::{
    BuildRow, BuildState, CommandKind, MachineRow, MachineStatus, NestingBuild, OpenBuildForecast, UtcTimestamp,
};
use maud::{Markup, html};

use crate::{
    farm::{DateRisk, MachineFact, forecast_fire, held_text, night_text},
    settings::MachineProfile,
    tables::{GivenDate, MachineForecast, SheetFact, TimeView, fields},
    web::{
        base::{format::count, listing::fact_list, query::order_address},
        core::{command::command_button, state::DashboardState},
        forms::drop_form::drop_form,
    },
};

/// Due dates at risk that are named on a card.
const MAX_AT_RISK: usize = 5;

/// What a card shows.
pub(crate) struct MachineCard<'a> {
    pub(crate) profile: &'a MachineProfile,
    pub(crate) fact: &'a MachineFact,
    pub(crate) status: &'a MachineStatus,
    /// As the daemon saw it last.
    pub(crate) observed: Option<&'a MachineRow>,
    /// Its builds that are being made.
    pub(crate) nesting: Vec<BuildRow>,
    /// The build that was published last.
    pub(crate) last: Option<BuildRow>,
    /// Its due dates at risk, the earliest first.
    pub(crate) at_risk: Vec<&'a DateRisk>,
    /// Mean density of its builds of the last weeks, 0..1.
    pub(super) usual_density: Option<f64>,
}

impl MachineCard<'_> {
    /// The card; `picture_html` shows the build.
    pub(super) fn draw_card(&self, web: &DashboardState, picture_html: &Markup, view: &TimeView) -> Markup {
        let (name, status) = (self.profile.name.as_str(), self.status);
        let now = view.now().unwrap_or_else(Timestamp::now);
        let machine = MachineForecast::new(status.clone(), Some(self.profile), self.fact.clone(), now);
        html! {
            section.card id=(name) aria-label=(name) {
                h2 { (name) " " span class=(format!("state {}", self.fact.state.word())) { (self.fact.state.word()) } }
                p { (self.fact.doing) "." }
                @for text in machine_warnings(status, self.observed, view) { p.bad role="status" { (text) } }
                (self.dates_at_risk(now))
                @for build in &status.nesting { (self.search_progress(build, now)) }
                (picture_html)
                @if let Some(open) = machine.forecast_build() { (self.open_build(open)) } @else { p { "No open build." } }
                (self.countdown(now))
                (fact_list(&waiting_facts(&machine, fire_forecast_text(self.profile, status, now), view), view))
                @if status.refused_parts > 0 {
                    p { a href=(format!("/parts?state=refused&machine={name}")) { (fields::REFUSED.label) ": " (status.refused_parts) } }
                }
                (self.last_outcome(view))
                div.buttons {
                    @if web.orders {
                        @if status.waiting_parts > 0 { a.button href=(format!("/machines/{name}/flush")) { "Flush" span.unseen { " " (name) ": see what would be built now" } } }
                    }
                    @if status.paused.is_some() { (command_button(web, CommandKind::Resume, "Resume", name, name, None)) }
                    @else { (command_button(web, CommandKind::Pause, "Pause", name, name, None)) }
                }
                @if web.orders {
                    details { summary { "Add files" span.unseen { " to " (name) } span.soft { ", or drop them here" } }
                        (drop_form(web, self.profile, web.current_settings().limits.max_bytes)) }
                }
            }
        }
    }

    fn dates_at_risk(&self, now: Timestamp) -> Markup {
        let more = self.at_risk.len().saturating_sub(MAX_AT_RISK);
        let part = |risk: &DateRisk| risk.numbers.first().map(|part| format!("/parts/{part}")).unwrap_or_default();
        let page = |risk: &DateRisk| if risk.order.is_empty() { part(risk) } else { order_address(&risk.order) };
        html! {
            @if !self.at_risk.is_empty() {
                div.bad role="status" {
                    p { b { "Late, or at risk to be" } }
                    ul { @for risk in self.at_risk.iter().take(MAX_AT_RISK) { li {
                        a href=(page(risk)) { (risk.subject_text()) } ": " (risk.in_words(&self.profile.time_zone, now)) "."
                    } } }
                    @if more > 0 { p { (count(more as u32, "more date", "more dates")) "." } }
                }
            }
        }
    }

    /// How far the search for a build is.
    fn search_progress(&self, build: &NestingBuild, now: Timestamp) -> Markup {
        let limit_secs = self.profile.search.final_secs;
        let spent_secs = build.nesting_at.map(|at| now.duration_since(at.0).as_secs_f64().clamp(0.0, limit_secs));
        let height = self.nesting.iter().find(|row| row.id == build.build).and_then(|row| row.measures.height_mm);
        let is_searching = build.state == BuildState::Nesting;
        html! {
            p { "Build " a href=(format!("/builds/{}", build.build)) { (build.build) }
                @if is_searching { " is searched" } @else { " is proved and goes to the queue" }
                ": " (count(build.copies, "copy", "copies"))
                @if let Some(height) = fields::HEIGHT.with_unit(height) { ", began at " (height) }
                @if let (true, Some(spent)) = (is_searching, spent_secs) { ", " (format!("{spent:.0} of {limit_secs:.0} s")) } "." }
            @if let (true, Some(spent)) = (is_searching, spent_secs.filter(|spent| *spent < limit_secs)) {
                progress max=(limit_secs) value=(format!("{spent:.0}")) aria-label=(format!("Search for build {}", build.build)) {}
            }
        }
    }

    /// The forecast of the next build: how high and how dense it is, together.
    fn open_build(&self, open: &OpenBuildForecast) -> Markup {
        let volume_z_mm = self.profile.space.volume_mm.z;
        let share = open.height_mm.map(|height| 100.0 * height / volume_z_mm);
        let usual = self.usual_density.and_then(|density| fields::DENSITY.with_unit(density));
        html! {
            p { "Open build " a href=(format!("/builds/{}", open.build)) { (open.build) } ": "
                @if let Some(height) = fields::HEIGHT.with_unit(open.height_mm) { b { (height) } " of " (volume_z_mm) " mm" }
                @if let Some(density) = fields::DENSITY.with_unit(open.density) { ", " b { (density) " dense" } }
                @if let Some(usual) = usual { " (usual: " (usual) ")" }
                ", " (count(open.copies.unwrap_or(0), "copy", "copies")) "." }
            @if let Some(share) = share {
                meter min="0" max="100" value=(format!("{share:.1}")) aria-label=(format!("Height used by the open build of {}: {share:.0} %", self.profile.name)) {}
            }
        }
    }

    /// How long until the next build fires.
    fn countdown(&self, now: Timestamp) -> Markup {
        let fires = forecast_fire(self.profile, self.status, now);
        html! {
            @if let Some(fires) = fires {
                p { "Fires " b { @if fires.at <= now { "now" } @else { (UtcTimestamp(fires.at).distance_text(now).unwrap_or_default()) } }
                    @if fires.at < fires.latest { " if nothing more arrives" } "." }
            }
            @if let Some(held) = held_text(self.profile, self.status) { p { "It waits: " (held) "." } }
        }
    }

    /// What became of the build that was published last.
    fn last_outcome(&self, view: &TimeView) -> Markup {
        html! {
            @if let Some(last) = &self.last {
                p { (fields::LAST_PUBLISHED.label) ": build " a href=(format!("/builds/{}", last.id)) { (last.id) }
                    @if let Some(height) = fields::HEIGHT.with_unit(last.measures.height_mm) { ", " (height) }
                    @if let Some(density) = fields::DENSITY.with_unit(last.measures.density) { ", " (density) " dense" }
                    @if let Some(at) = last.times.published_at { ", " (view.time_text(at)) }
                    @match last.state {
                        BuildState::Published => { ". " a href=(format!("/builds/{}#told", last.id)) { "Tell how it printed" } "." }
                        state => { ": " b { (state) } "." }
                    } }
            }
        }
    }
}

/// What a machine does and how full its next build is, in a few words.
pub(super) fn brief_state(
    profile: &MachineProfile,
    status: Option<&MachineStatus>,
    fact: &MachineFact,
    now: Timestamp,
) -> String {
    let height =
        status.and_then(|status| status.open.as_ref()).and_then(|open| fields::HEIGHT.with_unit(open.height_mm));
    let fires = status.and_then(|status| forecast_fire(profile, status, now));
    let fires = fires.and_then(|fires| UtcTimestamp(fires.at).distance_text(now)).map(|fires| format!("fires {fires}"));
    [Some(fact.state.word().to_owned()), height, fires].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Why a machine takes no parts, if so: an operator paused it, or the daemon found it unavailable.
fn machine_warnings(status: &MachineStatus, observed: Option<&MachineRow>, view: &TimeView) -> Vec<String> {
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
pub(super) fn fire_forecast_text(profile: &MachineProfile, status: &MachineStatus, now: Timestamp) -> Option<String> {
    Some(forecast_fire(profile, status, now)?.fire_text(profile, status))
}

/// What waits for a machine, and until when.
fn waiting_facts(machine: &MachineForecast, fires: Option<String>, view: &TimeView) -> Vec<SheetFact> {
    let status = &machine.status;
    let parts = count(status.waiting_parts, "part", "parts");
    let lines = [
        Some(fields::WAITING.fact_of(format!("{} of {parts}", count(status.waiting_copies, "copy", "copies")))),
        fields::OLDEST.fact(view.now().and_then(|now| machine.oldest(now))),
        view.due_fact(fields::DUE, GivenDate::new(status.due_at, &status.due_text)),
        fields::FIRES.fact(fires),
        fields::WHILE_IT_WAITS.fact(machine.forecast_build().and_then(night_text)),
        (status.claimed_parts > 0).then(|| fields::BEING_READ.fact_of(count(status.claimed_parts, "file", "files"))),
    ];
    lines.into_iter().flatten().collect()
}
