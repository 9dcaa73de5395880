//! The plan of a machine as people and programs see it: builds under way and to come, and the due dates that are at risk.

use std::collections::BTreeMap;

use jiff::Timestamp;
use language::say;
use ledger::{BuildId, PartId, PartRow, PartState, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::{FarmZone, MachineProfile};

use super::{
    build_plan::{ComingBuild, plan_builds},
    date_outlook::{DateOutlook, DatesKept, RiskCause, outlook_of_coming, outlook_of_made},
    plan_facts::PlanHindrance,
    plan_reading::{BuildUnderWay, PlanReading},
};
use crate::{
    decisions::{printer_choice::BuildStage, trigger::FireTrigger},
    process::time_text::known_minute,
};

/// The plan of a machine. It holds as long as nothing more arrives.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MachinePlan {
    /// Its machine.
    pub machine: String,
    /// When it was made.
    pub planned_at: UtcTimestamp,
    /// Why nothing fires; `None` = nothing prevents it.
    pub hindered: Option<RiskCause>,
    /// The builds under way and to come, in the order in which they are printed or fire.
    pub builds: Vec<PlannedBuild>,
    /// The due dates at risk, the earliest first.
    pub risks: Vec<DateRisk>,
    /// Parts that cannot be in a build yet: not read, waiting for an answer, or without their file.
    pub unplanned_parts: u32,
    /// Number of earlier builds from which the heights of builds to come were learned; 0 = the usual density counts.
    pub heights_learned_from: u32,
}

/// How far a build of a plan is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanStage {
    /// It should be done, and nobody told how it printed.
    Ended,
    /// It cools, and is unpacked.
    Cooling,
    /// It is printed, as far as is known.
    Printing,
    /// Its printer took its file, and has others to print before it.
    Taken,
    /// Its file lies in a queue folder.
    Queued,
    /// It has fired, and is nested, proved, or waits for a person's yes.
    Made,
    /// It is the open build, which waiting parts join.
    Open,
    /// It follows after that.
    Later,
}

/// A build of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PlannedBuild {
    /// Its number; `None` = it has none yet.
    pub build: Option<BuildId>,
    /// How far it is.
    pub stage: PlanStage,
    /// Its printer, as far as is known.
    pub printer: Option<String>,
    /// Copies in it.
    pub copies: u32,
    /// Its height, mm.
    pub height_mm: f64,
    /// Whether the height is that of a layout, and no estimate.
    pub is_nested: bool,
    /// When it fires; `None` = it has fired, or nothing fires.
    pub fires_at: Option<UtcTimestamp>,
    /// What fires it.
    pub fires_by: Option<FireTrigger>,
    /// When its print begins, or began.
    pub begins_at: Option<UtcTimestamp>,
    /// When the print itself ends, without cooling.
    pub printed_at: Option<UtcTimestamp>,
    /// When its parts can be unpacked.
    pub ends_at: Option<UtcTimestamp>,
    /// How it keeps the due dates of what is in it.
    pub dates: DatesKept,
    /// Whether it waits for a person's yes.
    pub awaits_release: bool,
    /// What is in it, in order of precedence.
    pub parts: Vec<PlannedPart>,
}

/// Copies of a part in a build of a plan.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PlannedPart {
    /// The part.
    pub part: PartId,
    /// Its name.
    pub name: String,
    /// Its order; "" = none.
    pub order: String,
    /// Copies of it in the build.
    pub copies: u32,
    /// When it is due.
    pub due_at: Option<UtcTimestamp>,
}

/// A due date that is at risk: that of an order, or of a part without one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DateRisk {
    /// The machine.
    pub machine: String,
    /// The order; "" = the part has none.
    pub order: String,
    /// The parts that put it at risk.
    pub parts: Vec<String>,
    /// Their numbers.
    pub numbers: Vec<PartId>,
    /// When it is due.
    pub due_at: UtcTimestamp,
    /// The date as it was given.
    pub due_text: String,
    /// When the last of it can be unpacked, as far as is known.
    pub done_at: Option<UtcTimestamp>,
    /// Whether it would be late; otherwise the time left is less than such plans are wrong by.
    pub is_late: bool,
    /// What puts it at risk.
    pub cause: RiskCause,
    /// The time that the cause goes until, where it has one.
    #[serde(skip)]
    pub until: Option<Timestamp>,
    /// The cause in words, as the end of a sentence.
    pub reason: String,
}

/// Makes the plan of a machine.
pub fn make_plan(profile: &MachineProfile, reading: &PlanReading, now: Timestamp) -> MachinePlan {
    let facts = &reading.facts;
    let coming = plan_builds(profile, facts, now);
    let fired = |build: BuildId| coming.iter().find(|coming| coming.fires.is_none() && coming.build == Some(build));
    let under_way =
        reading.under_way.iter().map(|build| view_under_way(profile, reading, build, fired(build.id()), now));
    let to_come = coming.iter().filter(|build| !build.lines.is_empty());
    let first = to_come.clone().next();
    let to_come = to_come.map(|build| view_coming(profile, reading, (build, first), now));
    MachinePlan {
        machine: profile.name.clone(),
        planned_at: UtcTimestamp(now),
        hindered: facts.hindrance.map(|hindrance| match hindrance {
            PlanHindrance::Paused => RiskCause::Paused,
            PlanHindrance::Unavailable => RiskCause::Unavailable,
            PlanHindrance::NoPrinter => RiskCause::NoPrinter,
        }),
        builds: under_way.chain(to_come).collect(),
        risks: find_risks(profile, reading, &coming, now),
        unplanned_parts: u32::try_from(reading.unplanned.len()).unwrap_or(u32::MAX),
        heights_learned_from: u32::try_from(facts.packing.learned_from).unwrap_or(u32::MAX),
    }
}

fn view_under_way(
    profile: &MachineProfile,
    reading: &PlanReading,
    build: &BuildUnderWay,
    fired: Option<&ComingBuild>,
    now: Timestamp,
) -> PlannedBuild {
    let print = fired.and_then(|fired| fired.print);
    let times = match (&build.made, print) {
        (Some((_, made)), _) => Some([made.begins_at, made.printed_at, made.ends_at]),
        (None, Some(print)) => Some([print.begins_at, print.printed_at, print.ends_at]),
        (None, None) => None,
    };
    let time = |at: usize| times.and_then(|times| known_minute(times[at]));
    let dues = build.parts.iter().filter_map(|(part, _)| part.terms.due_at);
    let outlook = |due: UtcTimestamp| outlook_under_way(profile, reading, build, fired, due.0, now);
    let printer = match &build.made {
        Some((printer, _)) => Some(printer.clone()),
        None => print.map(|print| profile.printers[print.place].name.clone()),
    };
    PlannedBuild {
        build: Some(build.id()),
        stage: match build.made.as_ref().map(|(_, made)| made.stage) {
            Some(BuildStage::Queued) => PlanStage::Queued,
            Some(BuildStage::Taken) => PlanStage::Taken,
            Some(BuildStage::Printing) => PlanStage::Printing,
            Some(BuildStage::Cooling) => PlanStage::Cooling,
            Some(BuildStage::Ended) => PlanStage::Ended,
            Some(BuildStage::Made) | None => PlanStage::Made,
        },
        printer,
        copies: build.parts.iter().map(|(_, copies)| copies).sum(),
        height_mm: build.row.measures.height_mm.unwrap_or(0.0),
        is_nested: build.row.measures.height_mm.is_some(),
        fires_at: None,
        fires_by: None,
        begins_at: time(0),
        printed_at: time(1),
        ends_at: time(2),
        dates: DatesKept::of_outlooks(dues.map(outlook), time(2).is_some()),
        awaits_release: build.made.as_ref().is_some_and(|(_, made)| made.awaits_release),
        parts: build.parts.iter().map(|(part, copies)| planned_part(part, *copies)).collect(),
    }
}

/// The outlook of a due date of a part in a build that has fired; `None` = it is kept, as far as is known.
fn outlook_under_way(
    profile: &MachineProfile,
    reading: &PlanReading,
    build: &BuildUnderWay,
    fired: Option<&ComingBuild>,
    due: Timestamp,
    now: Timestamp,
) -> Option<DateOutlook> {
    match (&build.made, fired) {
        (Some((_, made)), _) => outlook_of_made(&reading.facts, made, reading.reserve, due, now),
        (None, Some(fired)) => outlook_of_coming(profile, &reading.facts, (fired, None), reading.reserve, due, now),
        (None, None) => None,
    }
}

/// `first` is the first build to come that has not fired yet.
fn view_coming(
    profile: &MachineProfile,
    reading: &PlanReading,
    (build, first): (&ComingBuild, Option<&ComingBuild>),
    now: Timestamp,
) -> PlannedBuild {
    let dues = build.lines.iter().filter_map(|line| line.part.terms.due_at);
    let outlook =
        |due: UtcTimestamp| outlook_of_coming(profile, &reading.facts, (build, first), reading.reserve, due.0, now);
    let print = build.print.filter(|print| print.begins_at < Timestamp::MAX);
    let ends_at = print.map(|print| print.ends_at).and_then(known_minute);
    let parts = build.lines.iter().fold(BTreeMap::new(), |mut places: BTreeMap<PartId, usize>, line| {
        let next = places.len();
        places.entry(line.part.id).or_insert(next);
        places
    });
    let mut listed: Vec<Option<PlannedPart>> = vec![None; parts.len()];
    for line in &build.lines {
        match &mut listed[parts[&line.part.id]] {
            Some(part) => part.copies += line.copies,
            empty => *empty = Some(planned_part(&line.part, line.copies)),
        }
    }
    PlannedBuild {
        build: build.build,
        stage: if build.build.is_some() { PlanStage::Open } else { PlanStage::Later },
        printer: print.map(|print| profile.printers[print.place].name.clone()),
        copies: build.lines.iter().map(|line| line.copies).sum(),
        height_mm: build.height_mm,
        is_nested: build.is_nested,
        // As it is, for the same is told in other places.
        fires_at: build.fires.map(|(at, _)| UtcTimestamp(at)).filter(|at| at.0 < Timestamp::MAX),
        fires_by: build.fires.map(|(_, by)| by),
        begins_at: print.map(|print| print.begins_at).and_then(known_minute),
        printed_at: print.map(|print| print.printed_at).and_then(known_minute),
        dates: DatesKept::of_outlooks(dues.map(outlook), ends_at.is_some()),
        ends_at,
        awaits_release: false,
        parts: listed.into_iter().flatten().collect(),
    }
}

fn planned_part(part: &PartRow, copies: u32) -> PlannedPart {
    PlannedPart {
        part: part.id,
        name: part.full_name(),
        order: part.terms.order_name.clone(),
        copies,
        due_at: part.terms.due_at,
    }
}

/// The due dates at risk, the earliest first.
pub fn find_risks(
    profile: &MachineProfile,
    reading: &PlanReading,
    coming: &[ComingBuild],
    now: Timestamp,
) -> Vec<DateRisk> {
    let (facts, reserve) = (&reading.facts, reading.reserve);
    let mut found: BTreeMap<RiskKey, (DateOutlook, DateRisk)> = BTreeMap::new();
    let first = coming.iter().find(|build| !build.lines.is_empty());
    for build in coming {
        for line in &build.lines {
            let due = line.part.terms.due_at.map(|due| due.0);
            let outlook = due.and_then(|due| outlook_of_coming(profile, facts, (build, first), reserve, due, now));
            note_risk(profile, &mut found, &line.part, outlook);
        }
    }
    for build in &reading.under_way {
        let fired = coming.iter().find(|coming| coming.fires.is_none() && coming.build == Some(build.id()));
        for (part, _) in &build.parts {
            let Some(due) = part.terms.due_at.map(|due| due.0) else { continue };
            note_risk(profile, &mut found, part, outlook_under_way(profile, reading, build, fired, due, now));
        }
    }
    for part in &reading.unplanned {
        note_risk(profile, &mut found, part, outlook_of_unplanned(profile, reading, part, first, now));
    }
    let mut risks: Vec<DateRisk> = found.into_values().map(|(_, risk)| risk).collect();
    risks.sort_by(|one, other| (one.due_at, &one.order).cmp(&(other.due_at, &other.order)));
    risks
}

/// The outlook of a part that is in no build: at risk once it could not be kept without it being answered now.
fn outlook_of_unplanned(
    profile: &MachineProfile,
    reading: &PlanReading,
    part: &PartRow,
    first: Option<&ComingBuild>,
    now: Timestamp,
) -> Option<DateOutlook> {
    let due_at = part.terms.due_at?.0;
    let height_mm = first.map_or(0.0, |build| build.height_mm);
    let at_once = now.checked_add(reading.facts.outlook.times.occupied(height_mm)).unwrap_or(Timestamp::MAX);
    let margin_secs = profile.trigger.due_margin_secs.unwrap_or(0.0);
    let cause = match () {
        () if due_at <= now => RiskCause::Passed,
        () if part.state == PartState::Claimed => RiskCause::NotRead,
        () if !part.owed.question.is_empty() => RiskCause::AwaitsAnswer,
        () if part.owed.awaits_material => RiskCause::AwaitsMaterial,
        () => RiskCause::FileMissing,
    };
    let is_near = super::build_plan::add_secs(at_once, margin_secs) > due_at;
    is_near.then(|| DateOutlook { cause, until: None, done_at: None, is_late: at_once > due_at })
}

/// Order, or number of a part without one, and due date.
type RiskKey = (String, Option<PartId>, UtcTimestamp);

/// Adds what puts a part's due date at risk to that of its order.
fn note_risk(
    profile: &MachineProfile,
    found: &mut BTreeMap<RiskKey, (DateOutlook, DateRisk)>,
    part: &PartRow,
    outlook: Option<DateOutlook>,
) {
    let (Some(outlook), Some(due_at)) = (outlook, part.terms.due_at) else { return };
    let order = part.terms.order_name.clone();
    let alone = order.is_empty().then_some(part.id);
    let risk = |outlook: &DateOutlook, (parts, numbers): (Vec<String>, Vec<PartId>)| DateRisk {
        machine: profile.name.clone(),
        order: order.clone(),
        parts,
        numbers,
        due_at,
        due_text: part.terms.due_text.clone(),
        done_at: outlook.done_at.and_then(known_minute),
        is_late: outlook.is_late,
        cause: outlook.cause,
        until: outlook.until,
        reason: outlook.cause.reason_text(outlook.until, &profile.time_zone),
    };
    let entry = found.entry((order.clone(), alone, due_at));
    let (worst, noted) = entry.or_insert_with(|| (outlook, risk(&outlook, Default::default())));
    *worst = worst.worse(outlook);
    let (mut parts, mut numbers) = (std::mem::take(&mut noted.parts), std::mem::take(&mut noted.numbers));
    if !numbers.contains(&part.id) {
        numbers.push(part.id);
        parts.push(part.full_name());
    }
    *noted = risk(worst, (parts, numbers));
}

impl DateRisk {
    /// The order with its parts that are at risk, or the part.
    pub fn subject_text(&self) -> String {
        let named = match self.parts.as_slice() {
            [] => String::new(),
            [one] => one.clone(),
            [one, rest @ ..] => say!("name-and-more", name = one, count = rest.len()),
        };
        if self.order.is_empty() { named } else { format!("{}: {named}", self.order) }
    }

    /// `late`, or `tight` where the time left is less than such plans are wrong by.
    pub fn word(&self) -> &'static str {
        if self.is_late { "late" } else { "tight" }
    }

    /// What follows the subject in a sentence: `due 2026-11-27, late, done about tomorrow 03:45: its print takes too long for that`.
    pub fn in_words(&self, zone: &FarmZone, now: Timestamp) -> String {
        let due = zone.format_due(self.due_at.0, &self.due_text);
        // In the language of now, which may be another than that of the plan.
        let (word, why) = (language::say_word("state", self.word()), self.cause.reason_text(self.until, zone));
        match self.done_at.map(|at| zone.format_near(at.0, now)) {
            Some(done) => say!("risk-due-done", due = due, word = word, done = done, why = why),
            None => say!("risk-due", due = due, word = word, why = why),
        }
    }
}
