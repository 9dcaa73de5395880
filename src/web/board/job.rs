//! A build on the board: a bar on the time axis, on a phone an entry of a list. It says what the plan says.

use std::collections::BTreeMap;

use farm::{DatesKept, PlanStage, PlannedBuild};
use language::say;
use ledger::{BuildId, UtcTimestamp};
use maud::{Markup, html};

use super::axis::{AxisSpan, TimeAxis};
use crate::{
    tables::TimeView,
    web::{
        core::picture::small_picture,
        look::{
            chip::{Tone, chip, chip_of},
            style::AXIS_STEPS,
            times::estimate_of,
        },
    },
};

/// Steps of the axis in which what a bar says has room.
const TEXT_STEPS: u32 = 60;

/// What all builds of a board share.
pub(crate) struct JobSetting<'a> {
    pub(crate) axis: &'a TimeAxis,
    pub(crate) view: &'a TimeView,
    /// The version of the layout of each build that can be drawn.
    pub(crate) layouts: &'a BTreeMap<BuildId, String>,
}

/// A build with its place on the axis.
pub(crate) struct Job<'a> {
    pub(crate) build: &'a PlannedBuild,
    span: AxisSpan,
}

impl<'a> Job<'a> {
    /// The build, if a part of it is on the axis.
    pub(crate) fn on_axis(build: &'a PlannedBuild, axis: &TimeAxis, now: UtcTimestamp) -> Option<Self> {
        build.printer.as_ref()?;
        // What nobody told the end of occupies its printer until now.
        let ends = if build.stage == PlanStage::Ended { build.ends_at?.max(now) } else { build.ends_at? };
        let span = axis.span(build.begins_at?.0, ends.0)?;
        Some(Self { build, span })
    }

    /// The step at which it begins.
    pub(crate) fn begins(&self) -> u32 {
        self.span.from
    }

    /// The bar. What it says may stand behind a short one, up to where the `next` bar of its lane begins.
    pub(crate) fn draw(&self, setting: &JobSetting<'_>, next: Option<&Job<'_>>) -> Markup {
        let build = self.build;
        let cools = build.printed_at.zip(build.ends_at).and_then(|(from, to)| setting.axis.span(from.0, to.0));
        let place = self.span.classes();
        let free = next.map_or(AXIS_STEPS, Job::begins).saturating_sub(self.span.from);
        let said = AxisSpan { steps: self.span.steps.max(free.min(TEXT_STEPS)), ..self.span };
        html! {
            li class=(li_class(build)) {
                i class=(format!("body {place}")) {}
                @if let Some(cools) = cools { i class=(format!("cool {}", cools.classes())) {} }
                (link(build, &said.classes(), setting))
            }
        }
    }
}

/// A build that has no place on the axis: it comes later, or it is not known when.
pub(crate) fn later_job(build: &PlannedBuild, setting: &JobSetting<'_>) -> Markup {
    html! { li class=(li_class(build)) { (link(build, "", setting)) } }
}

fn li_class(build: &PlannedBuild) -> String {
    let look = match build.stage {
        PlanStage::Ended | PlanStage::Cooling | PlanStage::Printing => "solid",
        PlanStage::Taken | PlanStage::Queued | PlanStage::Made => "outlined",
        PlanStage::Open | PlanStage::Later => "dashed",
    };
    format!("{} {look}", dates_tone(build.dates).class())
}

/// The tone of a build: how it keeps its dates.
fn dates_tone(dates: DatesKept) -> Tone {
    match dates {
        DatesKept::NoDate | DatesKept::Unknown => Tone::Busy,
        other => Tone::of_word(other.word()),
    }
}

/// The entry, which leads to the page of the build if there is one.
fn link(build: &PlannedBuild, place: &str, setting: &JobSetting<'_>) -> Markup {
    let class = format!("job {place}");
    let shown = shown(build, setting);
    match build.build {
        Some(number) => html! { a class=(class.trim_end()) href=(format!("/builds/{number}")) { (shown) } },
        None => html! { span class=(class.trim_end()) { (shown) } },
    }
}

/// What is seen of it, as far as there is room, and all of it in a sentence for who hears it.
fn shown(build: &PlannedBuild, setting: &JobSetting<'_>) -> Markup {
    let sentence = sentence(build, setting.view);
    let picture =
        build.build.filter(|_| build.is_nested).and_then(|number| Some((number, setting.layouts.get(&number)?)));
    html! {
        @if let Some((number, version)) = picture { (small_picture(number, version)) }
        span.job-text aria-hidden="true" title=(sentence) {
            span.job-name {
                (dates_mark(build.dates))
                @match build.build { Some(number) => b { span.narrow { (say!("build-word")) " " } (number) }, None => b { (say!("next-build")) } }
                span.job-mm { " " (height(build)) }
            }
            span.job-more { (chip(build.stage.word(build.awaits_release))) " " span.job-when { (when(build, setting.view)) } }
            @if build.dates != DatesKept::NoDate { span.job-dates { (dates_chip(build.dates)) } }
        }
        span.unseen { (sentence) }
    }
}

/// The shape of how the dates are kept.
fn dates_mark(dates: DatesKept) -> Markup {
    html! { @if dates != DatesKept::NoDate { span class=(format!("mark {}", dates_tone(dates).class())) { i {} } } }
}

/// How the due dates are kept.
pub(crate) fn dates_chip(dates: DatesKept) -> Markup {
    let text = match dates {
        DatesKept::Kept => say!("dates-kept"),
        DatesKept::Unknown => say!("dates-not-known"),
        other => language::say_word("state", other.word()),
    };
    chip_of(dates_tone(dates), &text)
}

fn height(build: &PlannedBuild) -> String {
    match (build.is_nested, build.height_mm > 0.0) {
        (true, true) => language::decimal(format!("{:.1} mm", build.height_mm)),
        (false, true) => say!("about-mm", height = format!("{:.0}", build.height_mm)),
        // Its search has found nothing yet.
        (_, false) => String::new(),
    }
}

/// When it comes to its next stage.
fn when(build: &PlannedBuild, view: &TimeView) -> Markup {
    let time = |at: UtcTimestamp| estimate_of(at, view);
    html! {
        @match (build.stage, build.printed_at, build.ends_at, build.fires_at, build.begins_at) {
            (PlanStage::Ended, _, Some(ends), ..) => (phrase!("since-time", time = time(ends))),
            (PlanStage::Cooling, _, Some(ends), ..) => (phrase!("until-time", time = time(ends))),
            (PlanStage::Printing, Some(printed), ..) => (phrase!("until-time", time = time(printed))),
            (PlanStage::Open | PlanStage::Later, _, _, Some(fires), Some(begins)) => (phrase!("fires-begins", fires = time(fires), begins = time(begins))),
            _ if build.awaits_release => {}
            (_, _, _, _, Some(begins)) => (phrase!("begins-time", time = time(begins))),
            _ => (say!("no-time-known")),
        }
    }
}

/// All that is known of it.
fn sentence(build: &PlannedBuild, view: &TimeView) -> String {
    let name = match (build.build, &build.printer) {
        (Some(number), Some(printer)) => say!("build-on", build = number.to_string(), printer = printer),
        (Some(number), None) => say!("build-number", build = number.to_string()),
        (None, Some(printer)) => say!("build-to-come-on", printer = printer),
        (None, None) => say!("build-to-come"),
    };
    let time = |at: Option<UtcTimestamp>| at.map(|at| view.estimate_text(at));
    let dates = match build.dates {
        DatesKept::NoDate => None,
        DatesKept::Kept => Some(say!("all-dates-kept")),
        DatesKept::Unknown => Some(say!("dates-not-known")),
        DatesKept::Tight => Some(say!("a-date-is-tight")),
        DatesKept::Late => Some(say!("a-date-is-late")),
    };
    let begins = match build.stage.has_begun() {
        true => build.begins_at.map(|at| say!("began-time", time = view.near_text(at))),
        // It begins when somebody says yes.
        false if build.awaits_release => None,
        false => time(build.begins_at).map(|time| say!("begins-time", time = time)),
    };
    let pieces = [
        Some(language::say_word("state", build.stage.word(build.awaits_release))),
        Some(height(build)).filter(|height| !height.is_empty()),
        Some(say!("count-copies", count = build.copies)),
        time(build.fires_at).map(|time| say!("fires-time", time = time)),
        begins,
        time(build.printed_at).map(|time| say!("printed-time", time = time)),
        time(build.ends_at).map(|time| say!("unpacked-time", time = time)),
        dates,
    ];
    say!("job-described", name = name, what = language::join_names(pieces.into_iter().flatten()))
}
