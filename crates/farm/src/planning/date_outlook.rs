//! Which due dates a plan does not keep, and what keeps it from doing so. This is a function of the plan and time.

use jiff::{SignedDuration, Timestamp};
use language::say;
use schemars::JsonSchema;
use serde::Serialize;
use settings::{FarmZone, MachineProfile};

use super::{
    build_plan::{ComingBuild, add_secs},
    plan_facts::{PlanFacts, PlanHindrance},
};
use crate::decisions::printer_choice::BuildStage;

/// What puts a due date at risk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RiskCause {
    /// The date has passed.
    Passed,
    /// Its print takes too long, even if it began at once.
    TooLong,
    /// It finds no place in the next build beside what goes first.
    LeftOut,
    /// Its build fires too late.
    AwaitsFire,
    /// The printers have other builds to do.
    PrinterBusy,
    /// No print begins then: the printer's hours or days off.
    PrinterClosed,
    /// Its build waits for a person's yes.
    AwaitsRelease,
    /// The part waits for a person's answer.
    AwaitsAnswer,
    /// Its material is not loaded on its machine.
    AwaitsMaterial,
    /// Its file is damaged, or is being fetched.
    FileMissing,
    /// Its file is not read yet.
    NotRead,
    /// A person has paused the machine.
    Paused,
    /// The daemon found the machine unavailable.
    Unavailable,
    /// No printer of the machine is in use.
    NoPrinter,
}

/// What a build that is looked at means for a due date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DateOutlook {
    /// What puts it at risk.
    pub cause: RiskCause,
    /// The time that the cause goes until, where it has one: the fire, the end of other prints, the opening of the hours.
    pub until: Option<Timestamp>,
    /// When the part can be unpacked, as far as is known.
    pub done_at: Option<Timestamp>,
    /// Whether it would be late; otherwise the time left is less than the spread of such plans.
    pub is_late: bool,
}

/// How a build keeps the due dates of what is in it: the date that it keeps worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DatesKept {
    /// Nothing in it has a due date.
    NoDate,
    /// All of them.
    Kept,
    /// None is missed yet, and nobody knows when it is done.
    Unknown,
    /// Less time is left than such plans are wrong by.
    Tight,
    /// It is unpacked after one of them, as far as is known.
    Late,
}

impl DatesKept {
    /// Of a build whose due dates have these outlooks; `None` = a date is kept, if it is known when the build is done.
    pub fn of_outlooks(outlooks: impl Iterator<Item = Option<DateOutlook>>, is_end_known: bool) -> Self {
        let kept = |outlook: Option<DateOutlook>| match outlook {
            None if !is_end_known => Self::Unknown,
            None => Self::Kept,
            Some(outlook) if outlook.is_late => Self::Late,
            Some(_) => Self::Tight,
        };
        outlooks.map(kept).max().unwrap_or(Self::NoDate)
    }

    /// The word.
    pub fn word(self) -> &'static str {
        match self {
            Self::NoDate => "no date",
            Self::Kept => "kept",
            Self::Unknown => "not known",
            Self::Tight => "tight",
            Self::Late => "late",
        }
    }
}

/// How sure the end of a print is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndReserve {
    /// Hours by which 95 % of prints exceed their time at most.
    pub print_hours: f64,
}

impl EndReserve {
    /// The time to hold back for a build of this height.
    pub fn span_of(&self, facts: &PlanFacts, height_mm: f64, is_nested: bool) -> SignedDuration {
        let higher_mm = if is_nested { 0.0 } else { facts.packing.spread * height_mm };
        let hours = self.print_hours + facts.outlook.times.print_hours(higher_mm);
        SignedDuration::try_from_secs_f64(3600.0 * hours).unwrap_or(SignedDuration::MAX)
    }
}

/// The outlook of a due date of a part in a build to come; `None` = it is kept. `first` is the first build to come that has not
/// fired yet.
pub fn outlook_of_coming(
    profile: &MachineProfile,
    facts: &PlanFacts,
    (build, first): (&ComingBuild, Option<&ComingBuild>),
    reserve: EndReserve,
    due_at: Timestamp,
    now: Timestamp,
) -> Option<DateOutlook> {
    let occupied = facts.outlook.times.occupied(build.height_mm);
    let ends = |begins: Timestamp| begins.checked_add(occupied).unwrap_or(Timestamp::MAX);
    let at_once = ends(add_secs(now, profile.search.final_secs));
    let at_risk = |cause: RiskCause, until: Option<Timestamp>, is_late: bool| {
        Some(DateOutlook { cause, until, done_at: build.print.map(|print| print.ends_at), is_late })
    };
    if due_at <= now {
        return at_risk(RiskCause::Passed, None, true);
    }
    let Some(print) = build.print else {
        let cause = match facts.hindrance {
            Some(PlanHindrance::Paused) => RiskCause::Paused,
            Some(PlanHindrance::Unavailable) => RiskCause::Unavailable,
            Some(PlanHindrance::NoPrinter) => RiskCause::NoPrinter,
            None => RiskCause::PrinterClosed,
        };
        let is_near = add_secs(at_once, profile.trigger.due_margin_secs.unwrap_or(0.0)) > due_at;
        return if is_near { at_risk(cause, None, at_once > due_at) } else { None };
    };
    let is_late = print.ends_at > due_at;
    let held_back = reserve.span_of(facts, build.height_mm, build.is_nested);
    let limit = if is_late { due_at } else { due_at.checked_sub(held_back).unwrap_or(Timestamp::MIN) };
    if print.ends_at <= limit {
        return None;
    }
    if at_once > limit {
        return at_risk(RiskCause::TooLong, None, is_late);
    }
    let is_first = first.is_none_or(|first| std::ptr::eq(first, build));
    let fits_first = first.and_then(|first| first.print).is_some_and(|first| first.ends_at <= limit);
    if !is_first && fits_first {
        return at_risk(RiskCause::LeftOut, None, is_late);
    }
    if ends(print.free_at) > limit {
        return at_risk(RiskCause::PrinterBusy, Some(print.free_at), is_late);
    }
    if ends(print.ready_at) > limit {
        return at_risk(RiskCause::AwaitsFire, build.fires.map(|(at, _)| at), is_late);
    }
    at_risk(RiskCause::PrinterClosed, Some(print.begins_at), is_late)
}

/// A build that has fired and has its printer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MadeBuild {
    /// Its height, mm.
    pub height_mm: f64,
    /// How far it is.
    pub stage: BuildStage,
    /// Whether it waits for a person's yes.
    pub awaits_release: bool,
    /// Whether its printer is down and has not begun it: nobody knows when it begins.
    pub awaits_printer: bool,
    /// When the builds before it are done.
    pub free_at: Timestamp,
    /// When its print begins, or began.
    pub begins_at: Timestamp,
    /// When the print itself ends, without cooling.
    pub printed_at: Timestamp,
    /// When its parts can be unpacked.
    pub ends_at: Timestamp,
}

/// The outlook of a due date of a part in a build that has its printer; `None` = it is kept.
pub fn outlook_of_made(
    facts: &PlanFacts,
    build: &MadeBuild,
    reserve: EndReserve,
    due_at: Timestamp,
    now: Timestamp,
) -> Option<DateOutlook> {
    let occupied = facts.outlook.times.occupied(build.height_mm);
    let ends = |begins: Timestamp| begins.checked_add(occupied).unwrap_or(Timestamp::MAX);
    if build.awaits_printer {
        let cause = if due_at <= now { RiskCause::Passed } else { RiskCause::NoPrinter };
        let is_near = ends(now) > due_at.checked_sub(reserve.span_of(facts, build.height_mm, true)).unwrap_or(due_at);
        return is_near.then(|| DateOutlook { cause, until: None, done_at: None, is_late: ends(now) > due_at });
    }
    let ends_at = build.ends_at;
    let is_late = ends_at > due_at;
    let held_back = match build.stage {
        BuildStage::Ended => SignedDuration::ZERO,
        _ => reserve.span_of(facts, build.height_mm, true),
    };
    let limit = if is_late { due_at } else { due_at.checked_sub(held_back).unwrap_or(Timestamp::MIN) };
    if ends_at <= limit {
        return None;
    }
    let (cause, until) = match () {
        () if due_at <= now => (RiskCause::Passed, None),
        () if build.awaits_release => (RiskCause::AwaitsRelease, None),
        () if build.begins_at <= now || ends(now) > limit => (RiskCause::TooLong, None),
        () if ends(build.free_at.max(now)) > limit => (RiskCause::PrinterBusy, Some(build.free_at)),
        () => (RiskCause::PrinterClosed, Some(build.begins_at)),
    };
    Some(DateOutlook { cause, until, done_at: Some(ends_at), is_late })
}

impl DateOutlook {
    /// Of two copies of one line, the outlook that is worse.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        let key = |outlook: &Self| (outlook.is_late, outlook.done_at.unwrap_or(Timestamp::MAX));
        if key(&other) > key(&self) { other } else { self }
    }
}

impl RiskCause {
    /// Why a date is at risk, as the end of a sentence. `until` = the time that it goes until, where there is one.
    pub fn reason_text(self, until: Option<Timestamp>, zone: &FarmZone) -> String {
        let until = until.filter(|at| *at < Timestamp::MAX).map(|at| zone.format_minute(at));
        let until = until.unwrap_or_default();
        match self {
            RiskCause::Passed => say!("risk-passed"),
            RiskCause::TooLong => say!("risk-too-long"),
            RiskCause::LeftOut => say!("risk-left-out"),
            RiskCause::AwaitsFire => say!("risk-awaits-fire", time = until),
            RiskCause::PrinterBusy => say!("risk-printers-busy", time = until),
            RiskCause::PrinterClosed if until.is_empty() => say!("risk-no-begin"),
            RiskCause::PrinterClosed => say!("risk-printer-closed", time = until),
            RiskCause::AwaitsRelease => say!("risk-awaits-release"),
            RiskCause::AwaitsAnswer => say!("risk-awaits-answer"),
            RiskCause::AwaitsMaterial => say!("risk-awaits-material"),
            RiskCause::FileMissing => say!("risk-file-missing"),
            RiskCause::NotRead => say!("risk-not-read"),
            RiskCause::Paused => say!("risk-paused"),
            RiskCause::Unavailable => say!("risk-unavailable"),
            RiskCause::NoPrinter => say!("risk-no-printer"),
        }
    }
}
