//! A machine on the board: what it does, one click to what a person does next, and a lane with its builds for each printer.

use std::collections::BTreeSet;

use access::Role;
use farm::{
    FireForecast, MachineFact, MachinePlan, MachineWord, PlanStage, PrinterFact, PrinterWord, asked_text, build_fact,
    held_text, night_text, with_lot,
};
use jiff::Timestamp;
use language::{colon, comma, say};
use ledger::{
    BuildId, BuildRow, BuildState, CommandKind, MachineRow, MachineStatus, NestingBuild, OpenBuildForecast,
    UtcTimestamp,
};
use maud::{Markup, html};
use settings::MachineProfile;

use super::{
    axis::TimeAxis,
    job::{Job, JobSetting, later_job},
};
use crate::{
    tables::{GivenDate, MachineForecast, SheetFact, TimeView, fields, plan_notes},
    web::{
        base::listing::fact_list,
        core::{command::command_button, state::DashboardState},
        forms::{
            drop_form::drop_form,
            machine_forms::{down_form, load_form, up_form},
        },
        look::{
            chip::chip,
            times::{due_of, estimate_of, time_of},
        },
    },
};

/// Builds without a place on the axis that are shown at once.
const MAX_LATER: usize = 3;

/// What the board shows of a machine.
pub(crate) struct MachineRowOnBoard<'a> {
    pub(crate) profile: &'a MachineProfile,
    pub(crate) fact: &'a MachineFact,
    pub(crate) plan: &'a MachinePlan,
    pub(crate) status: &'a MachineStatus,
    /// As the daemon saw it last.
    pub(crate) observed: Option<&'a MachineRow>,
    /// The build that was published last.
    pub(crate) last: Option<BuildRow>,
    /// Mean density of its builds of the last weeks, 0..1.
    pub(crate) usual_density: Option<f64>,
}

impl MachineRowOnBoard<'_> {
    /// Machines in trouble come first: those that do nothing because of it, then those with dates that are late, or at risk.
    pub(crate) fn urgency(&self) -> u8 {
        match self.fact.state {
            MachineWord::Unavailable | MachineWord::Down => 0,
            MachineWord::Paused => 1,
            _ if self.plan.risks.iter().any(|risk| risk.is_late) => 2,
            MachineWord::Ended => 3,
            _ if self.plan.builds.iter().any(|build| build.awaits_release) => 3,
            _ if !self.plan.risks.is_empty() => 4,
            _ => 5,
        }
    }

    /// The row; the board asks for files to be dropped on it.
    pub(crate) fn draw(&self, web: &DashboardState, setting: &JobSetting<'_>) -> Markup {
        let (name, view) = (self.profile.name.as_str(), setting.view);
        let now = view.now().unwrap_or_else(Timestamp::now);
        let jobs: Vec<Job<'_>> =
            self.plan.builds.iter().filter_map(|build| Job::on_axis(build, setting.axis, now.into())).collect();
        html! {
            section.machine id=(name) aria-label=(name) {
                (self.head(web, view, now))
                div.lanes {
                    @for printer in &self.fact.printers { (self.lane(web, printer, &jobs, setting)) }
                    (self.later(&jobs, setting))
                }
                div.machine-foot {
                    (self.waiting(view, now))
                    @for build in &self.status.nesting { (self.search_progress(build, now)) }
                    div.folds {
                        @if web.offers(Role::Operate) {
                            details { summary { (phrase!("add-files-here", unseen = html! { span.unseen { " " (say!("unseen-to", machine = name)) } }, soft = html! { span.soft { (say!("or-drop-here")) } })) }
                                (drop_form(web, self.profile, web.current_settings().limits.max_bytes)) }
                        }
                        details { summary { (say!("details")) span.unseen { " " (say!("unseen-of", name = name)) } } (self.details(web, view, now)) }
                    }
                }
            }
        }
    }

    /// Its name, its state, and what a person does next.
    fn head(&self, web: &DashboardState, view: &TimeView, now: Timestamp) -> Markup {
        let (name, status) = (self.profile.name.as_str(), self.status);
        html! {
            div.machine-head {
                h2 { (name) " " (chip(self.fact.state.word())) }
                @if !status.material.is_empty() { p.soft { (say!("material-loaded", material = with_lot(&status.material, &status.lot))) } }
                // Of a machine with one printer, its lane says it.
                @if let Some(free) = self.fact.free_at.filter(|free| free.0 > now && self.fact.printers.len() > 1) { p.soft { (phrase!("free-time", time = estimate_of(free, view))) } }
                (machine_warnings(status, self.observed, view))
                div.buttons {
                    (self.next_step(web))
                    @if web.offers(Role::Operate) && status.waiting_parts > 0 {
                        a.button href=(format!("/machines/{name}/flush")) { (say!("flush")) span.unseen { " " (say!("unseen-flush", machine = name)) } }
                    }
                    @if status.paused.is_none() { (command_button(web, CommandKind::Pause, &say!("pause"), name, name, None)) }
                }
            }
        }
    }

    /// What a person does next with this machine, if anything.
    fn next_step(&self, web: &DashboardState) -> Markup {
        let name = self.profile.name.as_str();
        let released = self.plan.builds.iter().find(|build| build.awaits_release).and_then(|build| build.build);
        let at =
            |stage: PlanStage| self.plan.builds.iter().find(|build| build.stage == stage).and_then(|build| build.build);
        let told = [PlanStage::Ended, PlanStage::Cooling, PlanStage::Printing].into_iter().find_map(at);
        html! {
            @if self.status.paused.is_some() {
                span.next-step { (command_button(web, CommandKind::Resume, &say!("resume"), name, name, None)) }
            } @else if let Some(build) = released {
                a.button.first href=(format!("/builds/{build}#release")) { (say!("say-yes", build = build.to_string())) }
            }
            @if let Some(build) = told {
                a.button.first[at(PlanStage::Ended).is_some()] href=(format!("/builds/{build}#told")) { (say!("tell-how", build = build.to_string())) }
            }
        }
    }

    /// A printer and its builds in the order of time.
    fn lane(&self, web: &DashboardState, printer: &PrinterFact, jobs: &[Job<'_>], setting: &JobSetting<'_>) -> Markup {
        let is_only = self.fact.printers.len() == 1;
        let mut own: Vec<&Job<'_>> =
            jobs.iter().filter(|job| job.build.printer.as_ref() == Some(&printer.printer)).collect();
        own.sort_by_key(|job| job.begins());
        let doing = if is_only { &self.fact.doing } else { &printer.doing };
        html! {
            div.lane {
                p.lane-name {
                    @if !is_only { b { (printer.printer) } " " (chip(printer.state.word())) " " }
                    // That it is free, its state says.
                    @if is_only || printer.state != PrinterWord::Free { span.soft.doing { (doing) "." } }
                }
                @if let Some(down) = &printer.down { div.buttons { (up_form(web, down)) } }
                div.track.down[printer.down.is_some()] {
                    (self.closed(printer, setting.axis))
                    (setting.axis.lines())
                    ol.jobs aria-label=(say!("builds-of", name = &printer.printer)) { @for (at, job) in own.iter().enumerate() { (job.draw(setting, own.get(at + 1).copied())) } }
                }
            }
        }
    }

    /// When no print begins.
    fn closed(&self, printer: &PrinterFact, axis: &TimeAxis) -> Markup {
        let rules = self.profile.printers.iter().find(|rules| rules.name == printer.printer);
        let (from, to) = axis.ends();
        let spans = rules.map(|rules| rules.closed_spans(from, to, &self.profile.time_zone)).unwrap_or_default();
        html! { @for span in spans.iter().filter_map(|(from, to)| axis.span(*from, *to)) { i class=(format!("closed {}", span.classes())) {} } }
    }

    /// The builds that have no place on the axis.
    fn later(&self, jobs: &[Job<'_>], setting: &JobSetting<'_>) -> Markup {
        let on_axis: BTreeSet<*const _> = jobs.iter().map(|job| std::ptr::from_ref(job.build)).collect();
        let later: Vec<_> =
            self.plan.builds.iter().filter(|build| !on_axis.contains(&std::ptr::from_ref(*build))).collect();
        let (shown, folded) = later.split_at(later.len().min(MAX_LATER));
        html! {
            @if !shown.is_empty() {
                ol.jobs.later aria-label=(say!("later-builds-of", name = &self.profile.name)) { @for build in shown { (later_job(build, setting)) } }
            }
            @if !folded.is_empty() {
                details { summary { (say!("count-more-builds", count = folded.len())) }
                    ol.jobs.later { @for build in folded { (later_job(build, setting)) } } }
            }
        }
    }

    /// What waits, what the open build is like, and when it fires.
    fn waiting(&self, view: &TimeView, now: Timestamp) -> Markup {
        let status = self.status;
        let machine = MachineForecast::new(status.clone(), Some(self.profile), self.fact.clone(), now);
        let fires = self.fact.forecast_fire(self.profile, status, now);
        html! {
            p.waiting {
                @if status.waiting_parts == 0 { span.soft { (say!("nothing-waits")) } }
                @else {
                    @let copies = html! { b { (say!("count-copies", count = status.waiting_copies)) } };
                    span { @match GivenDate::new(status.due_at, &status.due_text) {
                        Some(due) => (phrase!("waiting-due", copies = copies, parts = status.waiting_parts, due = due_of(&due, view))),
                        None => (phrase!("waiting", copies = copies, parts = status.waiting_parts)),
                    } }
                }
                // Of a machine with one printer, its lane says it.
                @if self.fact.printers.len() > 1 {
                    @for awaiting in &status.awaiting { span { (say!("copies-await-material", copies = awaiting.copies, material = &awaiting.material)) } }
                    @if let Some(asked) = asked_text(status) { span { (asked) } }
                }
                @if let Some(open) = machine.forecast_build() { (self.open_build(open)) }
                @if let Some(fires) = fires { (fire_time(&fires, (self.profile, status), view)) }
                @if let Some(held) = held_text(self.profile, status) { span { (say!("it-waits", why = held)) } }
                @if status.refused_parts > 0 {
                    a href=(format!("/parts?state=refused&machine={}", self.profile.name)) { (fields::REFUSED.said()) (colon()) (status.refused_parts) }
                }
            }
        }
    }

    /// How high and how dense the open build is.
    fn open_build(&self, open: &OpenBuildForecast) -> Markup {
        let volume_z_mm = self.profile.space.volume_mm.z;
        let share = open.height_mm.map(|height| 100.0 * height / volume_z_mm);
        let usual = self.usual_density.and_then(|density| fields::DENSITY.with_unit(density));
        html! {
            span { (phrase!("open-build", build = html! { a href=(format!("/builds/{}", open.build)) { (open.build) } })) " "
                @if let Some(height) = fields::HEIGHT.with_unit(open.height_mm) {
                    (phrase!("height-of", height = html! { b { (height) } }, limit = volume_z_mm)) ", "
                }
                @if let Some(density) = fields::DENSITY.with_unit(open.density) { (say!("so-dense", density = density)) }
                @if let Some(usual) = usual { " " (say!("usual-density", density = usual)) }
                (comma()) (say!("count-copies", count = open.copies.unwrap_or(0)))
                @if let Some(share) = share {
                    " " meter min="0" max="100" value=(format!("{share:.1}")) aria-label=(say!("height-used", machine = &self.profile.name, share = format!("{share:.0}"))) {}
                }
            }
        }
    }

    fn awaits_release(&self, build: BuildId) -> bool {
        self.plan.builds.iter().any(|planned| planned.build == Some(build) && planned.awaits_release)
    }

    /// How far the search for a build is.
    fn search_progress(&self, build: &NestingBuild, now: Timestamp) -> Markup {
        let limit_secs = self.profile.search.final_secs;
        let spent_secs = build.nesting_at.map(|at| now.duration_since(at.0).as_secs_f64().clamp(0.0, limit_secs));
        let is_searching = build.state == BuildState::Nesting;
        html! {
            @let number = html! { a href=(format!("/builds/{}", build.build)) { (build.build) } };
            p.making {
                @if is_searching { (phrase!("made-searched", build = number, copies = build.copies)) }
                @else if self.awaits_release(build.build) { (phrase!("made-awaits", build = number, copies = build.copies)) }
                @else { (phrase!("made-proved", build = number, copies = build.copies)) }
                @if let (true, Some(spent)) = (is_searching, spent_secs) {
                    (comma()) (say!("spent-of", spent = format!("{spent:.0}"), limit = format!("{limit_secs:.0}")))
                    @if spent < limit_secs { " " progress max=(limit_secs) value=(format!("{spent:.0}")) aria-label=(say!("search-for", build = build.build.to_string())) {} }
                } }
        }
    }

    /// What only some want to know.
    fn details(&self, web: &DashboardState, view: &TimeView, now: Timestamp) -> Markup {
        let machine = MachineForecast::new(self.status.clone(), Some(self.profile), self.fact.clone(), now);
        html! {
            (fact_list(&more_facts(&machine, view), view))
            (load_form(web, self.status))
            (down_form(web, &self.profile.name, &self.fact.printers))
            (self.last_outcome(view))
            @for note in plan_notes(self.plan, view) { p { (note) } }
        }
    }

    /// What became of the build that was published last.
    fn last_outcome(&self, view: &TimeView) -> Markup {
        html! {
            @if let Some(last) = &self.last {
                p { (phrase!("last-published", build = html! { a href=(format!("/builds/{}", last.id)) { (last.id) } }))
                    @if let Some(height) = fields::HEIGHT.with_unit(last.measures.height_mm) { (comma()) (height) }
                    @if let Some(density) = fields::DENSITY.with_unit(last.measures.density) { (comma()) (say!("so-dense", density = density)) }
                    @if let Some(at) = last.times.published_at { (comma()) (time_of(at, view)) }
                    " " (chip(&build_fact(last, std::slice::from_ref(self.plan)).word)) }
            }
        }
    }
}

/// When an open build fires, and why.
pub(crate) fn fire_time(
    fires: &FireForecast,
    (profile, status): (&MachineProfile, &MachineStatus),
    view: &TimeView,
) -> Markup {
    let is_now = view.now().is_some_and(|now| fires.at <= now);
    let time = html! { b { @if is_now { (say!("now")) } @else { (time_of(UtcTimestamp(fires.at), view)) } } };
    let why = fires.fire_reason(profile, status);
    html! {
        span { @match fires.at < fires.latest {
            true => (phrase!("fires-if", time = time, why = why)),
            false => (phrase!("fires-at-time", time = time, why = why)),
        } }
    }
}

/// Why a machine takes no parts, if so: an operator paused it, or the daemon found it unavailable.
fn machine_warnings(status: &MachineStatus, observed: Option<&MachineRow>, view: &TimeView) -> Markup {
    html! {
        @if let Some(paused) = &status.paused {
            p.bad role="status" { (phrase!("paused-by", by = &paused.paused_by, time = time_of(paused.paused_at, view))) }
        }
        @if let Some(observed) = observed.filter(|observed| !observed.trouble.is_empty()) {
            p.bad role="status" { @match observed.trouble_at {
                Some(at) => (phrase!("unavailable-since", time = time_of(at, view), trouble = language::told(&observed.trouble))),
                None => (say!("unavailable-for", trouble = language::told(&observed.trouble))),
            } }
        }
    }
}

/// What waits for a machine, beside what its row says.
fn more_facts(machine: &MachineForecast, view: &TimeView) -> Vec<SheetFact> {
    let status = &machine.status;
    let lines = [
        fields::OLDEST.fact(view.now().and_then(|now| machine.oldest(now))),
        fields::WHILE_IT_WAITS.fact(machine.forecast_build().and_then(night_text)),
        (status.claimed_parts > 0)
            .then(|| fields::BEING_READ.fact_of(say!("count-files", count = status.claimed_parts))),
    ];
    lines.into_iter().flatten().collect()
}

/// The builds of a plan that can be drawn.
pub(crate) fn drawn_builds(plan: &MachinePlan) -> impl Iterator<Item = BuildId> {
    plan.builds.iter().filter(|build| build.is_nested).filter_map(|build| build.build)
}
