//! A machine of simulated months: its waiting copies, its printers, and what its plan knows of them.

use std::{cmp::Ordering, collections::VecDeque, sync::Arc};

use jiff::Timestamp;
use ledger::{PartRow, compare_precedence};
use settings::MachineProfile;

use super::super::{
    packing_experience::PackingExperience,
    plan_facts::{PlanFacts, PlanLine},
};
use crate::decisions::{
    print_times::PrintTimes,
    printer_outlook::{PrinterAhead, PrinterOutlook},
    trigger::tests::machine_with_triggers,
};

/// A printer of the kind of an HP Jet Fusion 5200: hours per mm, hours of cooling and unpacking, and when people begin prints.
pub const PRINT_TIMES: PrintTimes = PrintTimes { hours_per_mm: 0.042, cool_down_hours: 8.0, learned_from: 40 };
const HOURS: &str = "Mon-Sat 6-22";

/// A build.
pub struct MonthBuild {
    pub lines: Vec<PlanLine>,
    pub height_mm: f64,
    pub published_at: Timestamp,
}

/// A printer: what lies in its queue, and what it prints with begin and end.
#[derive(Default)]
pub struct MonthPrinter {
    pub queue: VecDeque<MonthBuild>,
    pub prints: Option<(MonthBuild, Timestamp, Timestamp)>,
}

/// A hot folder with its printers.
pub struct MonthMachine {
    pub profile: MachineProfile,
    pub lines: Vec<PlanLine>,
    pub newest: Timestamp,
    pub printers: Vec<MonthPrinter>,
}

impl MonthMachine {
    /// A machine with printers of this kind. Due dates fire builds so many hours before a print would have to begin: `None` = never,
    /// `Some(None)` = the default.
    pub fn new(due_margin: Option<Option<f64>>, printers: usize, start: Timestamp) -> Self {
        let named = (0..printers).map(|n| format!("[[printer]]\nname = \"p{n}\"\nhours = \"{HOURS}\"\n"));
        let mut profile = machine_with_triggers(&named.collect::<String>());
        profile.space.volume_mm = glam::DVec3::new(380.0, 284.0, 380.0);
        profile.space.print_hours_per_mm = PRINT_TIMES.hours_per_mm;
        profile.time_zone = jiff::tz::TimeZone::UTC.into();
        match due_margin {
            None => profile.trigger.due_margin_secs = None,
            Some(hours) => {
                profile.trigger.due_margin_secs = hours.map(|hours| 3600.0 * hours).or(profile.trigger.due_margin_secs)
            }
        }
        let printers = (0..printers).map(|_| MonthPrinter::default()).collect();
        Self { profile, lines: Vec::new(), newest: start, printers }
    }

    /// The facts of its plan.
    pub fn facts(&self, packing: PackingExperience, now: Timestamp) -> PlanFacts {
        let printers = self.printers.iter().enumerate().map(|(place, printer)| {
            let rules = &self.profile.printers[place];
            let occupied = |build: &MonthBuild| PRINT_TIMES.occupied(build.height_mm);
            let mut free_at =
                printer.prints.as_ref().map_or(now, |(build, begun, _)| (*begun + occupied(build)).max(now));
            for build in &printer.queue {
                free_at = rules.begins_at(free_at, &self.profile.time_zone) + occupied(build);
            }
            let builds = printer.queue.len() + usize::from(printer.prints.is_some());
            PrinterAhead { place, free_at, builds, takes_at: Vec::new() }
        });
        PlanFacts {
            lines: self.lines.clone(),
            layout: None,
            newest: self.newest,
            fired: Vec::new(),
            outlook: PrinterOutlook { printers: printers.collect(), times: PRINT_TIMES },
            hindrance: None,
            packing,
        }
    }

    /// Whether a printer could begin a print at this moment.
    pub fn has_idle_printer(&self, now: Timestamp) -> bool {
        let is_idle = |(place, printer): (usize, &MonthPrinter)| {
            let opens = self.profile.printers[place].begins_at(now, &self.profile.time_zone);
            printer.prints.is_none() && printer.queue.is_empty() && opens <= now
        };
        self.printers.iter().enumerate().any(is_idle)
    }

    /// Puts copies of a part among the waiting ones.
    pub fn add_waiting(&mut self, part: Arc<PartRow>, copies: u32) {
        let line = PlanLine::new(&self.profile, part, copies, false);
        self.newest = self.newest.max(line.part.arrived_at().0);
        let goes_first =
            |other: &PlanLine| compare_precedence((&other.part, false), (&line.part, false)) != Ordering::Greater;
        let at = self.lines.partition_point(goes_first);
        self.lines.insert(at, line);
    }
}
