//! The builds to come of a machine. This is a function of facts and time: the same triggers, precedence and choice of a printer as
//! in the farm, played ahead as if nothing more arrived.

use jiff::{SignedDuration, Timestamp};
use ledger::{BuildId, DueArrival};
use settings::MachineProfile;

use super::plan_facts::{PlanFacts, PlanLine, StandingLayout};
use crate::decisions::{
    printer_outlook::{PrinterAhead, PrinterOutlook},
    trigger::{DueFacts, FireTrigger, TriggerFacts, find_trigger, next_timed_trigger},
};

/// So many builds to come are planned at most.
const MAX_BUILDS: usize = 100;

/// A build to come.
#[derive(Debug, Clone)]
pub struct ComingBuild {
    /// Its number, if it has one: it has fired, or is the open build.
    pub build: Option<BuildId>,
    /// What is in it, in order of precedence; empty for one that has fired.
    pub lines: Vec<PlanLine>,
    /// Its height, mm.
    pub height_mm: f64,
    /// Volume of the parts, mm3; 0 for one that has fired.
    pub volume_mm3: f64,
    /// Whether the height is that of a layout, and no estimate.
    pub is_nested: bool,
    /// When it fires and why; `None` = it has fired, or nothing fires.
    pub fires: Option<(Timestamp, FireTrigger)>,
    /// Its print; `None` = no printer can begin it.
    pub print: Option<ComingPrint>,
}

/// The print of a build to come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ComingPrint {
    /// Number of the printer in the machine's file.
    pub place: usize,
    /// When the build file is there.
    pub ready_at: Timestamp,
    /// When the printer has done what it was given before.
    pub free_at: Timestamp,
    /// When it begins, in the hours of the printer.
    pub begins_at: Timestamp,
    /// When the print itself ends, without cooling.
    pub printed_at: Timestamp,
    /// When the parts can be unpacked.
    pub ends_at: Timestamp,
}

/// Plans the builds to come of a machine, in the order in which they fire. Copies beyond the last build that is planned are in none.
pub fn plan_builds(profile: &MachineProfile, facts: &PlanFacts, now: Timestamp) -> Vec<ComingBuild> {
    let mut outlook = facts.outlook.clone();
    let mut builds: Vec<ComingBuild> = Vec::new();
    for fired in &facts.fired {
        let print = print_next(profile, &mut outlook, fired.height_mm, (now, now));
        let (lines, height_mm) = (Vec::new(), fired.height_mm);
        let is_nested = height_mm > 0.0;
        builds.push(ComingBuild {
            build: Some(fired.build),
            lines,
            height_mm,
            volume_mm3: 0.0,
            is_nested,
            fires: None,
            print,
        });
    }
    let (mut waiting, mut layout, mut fires_from) = (facts.lines.clone(), facts.layout, now);
    while !waiting.is_empty() && builds.len() < MAX_BUILDS {
        let all = waiting.clone();
        let taken = take_head(profile, facts, &mut waiting, layout.take());
        let fires = match facts.hindrance {
            Some(_) => None,
            None => fire_of(profile, (facts, &outlook), &all, &taken, !waiting.is_empty(), fires_from),
        };
        // Where the queue is full, it goes on being the open build until a printer takes a file.
        let fires = fires.and_then(|(at, by)| Some((outlook.room_from(profile.printing.queue_depth, at)?, by)));
        let print = fires.and_then(|(at, _)| {
            fires_from = at;
            print_next(profile, &mut outlook, taken.height_mm, (at, add_secs(at, profile.search.final_secs)))
        });
        builds.push(ComingBuild { fires, print, ..taken });
    }
    builds
}

/// Takes what fits into one build off the head of the waiting copies. A copy that does not fit lets smaller ones pass.
fn take_head(
    profile: &MachineProfile,
    facts: &PlanFacts,
    waiting: &mut Vec<PlanLine>,
    layout: Option<StandingLayout>,
) -> ComingBuild {
    let room_mm = profile.build_volume().size_mm.z;
    let packing =
        layout.map_or(facts.packing, |layout| facts.packing.through(layout.part_volume_mm3, layout.height_mm));
    let most_mm3 = ((room_mm - packing.base_mm) / packing.mm_per_mm3).max(0.0);
    let (mut lines, mut rest): (Vec<PlanLine>, Vec<PlanLine>) = Default::default();
    let (mut volume_mm3, mut least_mm) = (0.0_f64, 0.0_f64);
    for line in waiting.drain(..) {
        let fit = ((most_mm3 - volume_mm3) / line.each_mm3.max(1e-9) + 1e-6).floor().max(0.0);
        let fit = if lines.is_empty() { fit.max(1.0) } else { fit };
        let fit = line.copies.min(fit as u32);
        if fit < line.copies {
            rest.push(PlanLine { copies: line.copies - fit, stands: false, ..line.clone() });
        }
        if fit > 0 {
            volume_mm3 += f64::from(fit) * line.each_mm3;
            least_mm = least_mm.max(line.least_mm);
            lines.push(PlanLine { copies: fit, ..line });
        }
    }
    *waiting = rest;
    let is_nested = layout.is_some() && lines.iter().all(|line| line.stands) && waiting.iter().all(|line| !line.stands);
    let height_mm = match layout {
        Some(layout) if is_nested => layout.height_mm,
        _ => packing.height_mm(volume_mm3, least_mm).min(room_mm),
    };
    let build = layout.and_then(|layout| layout.build);
    ComingBuild { build, lines, height_mm, volume_mm3, is_nested, fires: None, print: None }
}

/// When a build of the waiting copies fires, and why, if it is looked at from `from` on.
fn fire_of(
    profile: &MachineProfile,
    (facts, outlook): (&PlanFacts, &PrinterOutlook),
    waiting: &[PlanLine],
    taken: &ComingBuild,
    is_full: bool,
    from: Timestamp,
) -> Option<(Timestamp, FireTrigger)> {
    let due =
        |line: &PlanLine| Some(DueArrival { due_at: line.part.terms.due_at?, arrived_at: line.part.arrived_at() });
    let dues: Vec<DueArrival> = waiting.iter().filter_map(due).collect();
    let trigger_facts = TriggerFacts {
        copies: waiting.iter().map(|line| line.copies as usize).sum(),
        oldest: waiting.iter().map(|line| line.part.waits_since().0).min().unwrap_or_default(),
        due: DueFacts::of_arrivals(profile, outlook, taken.height_mm, &dues, facts.newest),
        height_mm: taken.height_mm,
        density: taken.volume_mm3 / profile.build_volume().size_mm.element_product(),
        full: is_full,
        flush: false,
        takes_over: false,
        is_date_trusted: true,
    };
    match find_trigger(profile, &trigger_facts, from) {
        Some(by) => Some((from, by)),
        None => next_timed_trigger(profile, &trigger_facts).map(|(at, by)| (at.max(from), by)),
    }
}

/// Gives the next build to the printer that is free first, as the farm does.
fn print_next(
    profile: &MachineProfile,
    outlook: &mut PrinterOutlook,
    height_mm: f64,
    (fires_at, ready_at): (Timestamp, Timestamp),
) -> Option<ComingPrint> {
    let depth = profile.printing.queue_depth;
    let has_room = |printer: &PrinterAhead| depth == 0 || printer.has_room(depth, fires_at);
    // What has fired is not held back.
    let is_held = !outlook.printers.iter().any(has_room);
    let begins_at = |printer: &PrinterAhead| {
        profile.printers[printer.place].begins_at(printer.free_at.max(ready_at), &profile.time_zone)
    };
    let key = |printer: &&mut PrinterAhead| (begins_at(printer), printer.builds, printer.place);
    let usable = outlook.printers.iter_mut().filter(|printer| is_held || has_room(printer));
    let printer = usable.min_by_key(key)?;
    let (free_at, begins_at) = (printer.free_at, begins_at(printer));
    let ends_at = begins_at.checked_add(outlook.times.occupied(height_mm)).ok()?;
    let printed_at = begins_at.checked_add(outlook.times.printed(height_mm)).ok()?;
    (printer.free_at, printer.builds) = (ends_at, printer.builds + 1);
    printer.takes_at.push(begins_at);
    Some(ComingPrint { place: printer.place, ready_at, free_at, begins_at, printed_at, ends_at })
}

/// The time this many seconds later.
pub fn add_secs(time: Timestamp, secs: f64) -> Timestamp {
    let span = SignedDuration::try_from_secs_f64(secs).unwrap_or(SignedDuration::MAX);
    time.checked_add(span).unwrap_or(Timestamp::MAX)
}
