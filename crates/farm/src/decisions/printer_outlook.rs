//! What lies ahead of the printers of a machine, and when a print must begin so that a due date is kept. These are functions of facts
//! and time.

use jiff::{SignedDuration, Timestamp};
use ledger::{MachineStatus, OccupyingBuild};
use settings::{FarmZone, MachineProfile, PrinterRules};

use super::{
    print_times::PrintTimes,
    printer_choice::{BuildSpan, PrinterLoad, build_spans, load_of_spans},
};

/// The printers of a machine that are in use, and how long prints take.
#[derive(Debug, Clone, PartialEq)]
pub struct PrinterOutlook {
    /// The printers, in the order of the machine's file.
    pub printers: Vec<PrinterAhead>,
    /// How long prints take.
    pub times: PrintTimes,
}

/// A printer, and what lies ahead of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrinterAhead {
    /// Its number in the machine's file.
    pub place: usize,
    /// When it has done what it was given; it may begin later, in its hours.
    pub free_at: Timestamp,
    /// Number of builds before that.
    pub builds: usize,
    /// When it takes each of the files that lie in its queue, or are made for it, as far as is known.
    pub takes_at: Vec<Timestamp>,
}

/// When prints of one height can begin at the latest.
#[derive(Debug)]
pub struct LatestBegins<'p> {
    zone: &'p FarmZone,
    /// The printers in use, and when each can begin at the earliest.
    printers: Vec<(&'p PrinterRules, Timestamp)>,
    occupied: SignedDuration,
}

impl PrinterOutlook {
    /// The printers for which `is_in_use` holds, with the builds that occupy them.
    pub fn new(
        profile: &MachineProfile,
        builds: &[OccupyingBuild],
        times: PrintTimes,
        is_in_use: impl Fn(&str) -> bool,
        now: Timestamp,
    ) -> Self {
        let spans = build_spans(profile, builds, &times, |printer| !is_in_use(printer), now);
        let in_use = profile.printers.iter().enumerate().filter(|(_, rules)| is_in_use(&rules.name));
        let ahead = |(place, rules): (usize, &PrinterRules)| {
            let spans = spans.get(&rules.name).map_or(&[][..], Vec::as_slice);
            PrinterAhead::of_spans(place, spans, now)
        };
        Self { printers: in_use.map(ahead).collect(), times }
    }

    /// As the status of a machine tells it.
    pub fn of_status(profile: &MachineProfile, row: &MachineStatus, now: Timestamp) -> Self {
        let is_down = |name: &str| row.ahead.iter().any(|ahead| ahead.printer == name && ahead.is_down);
        let times = PrintTimes::learn(profile, &row.told_prints);
        Self::new(profile, &row.occupying, times, |name| !is_down(name), now)
    }

    /// What tells when the print of a build of this height must begin.
    pub fn latest_begins<'p>(&self, profile: &'p MachineProfile, height_mm: f64) -> LatestBegins<'p> {
        let first = |printer: &PrinterAhead| {
            let rules = &profile.printers[printer.place];
            (rules, rules.begins_at(printer.free_at, &profile.time_zone))
        };
        let occupied = self.times.occupied(height_mm);
        LatestBegins { zone: &profile.time_zone, printers: self.printers.iter().map(first).collect(), occupied }
    }

    /// The first moment from `at` on in which a printer has fewer files ahead than may lie in its queue: 0 = any number. `None` = none has.
    pub fn room_from(&self, depth: u32, at: Timestamp) -> Option<Timestamp> {
        let has_room = |at: Timestamp| depth == 0 || self.printers.iter().any(|printer| printer.has_room(depth, at));
        let taken = self.printers.iter().flat_map(|printer| printer.takes_at.iter().copied());
        taken.filter(|taken| *taken > at && *taken < Timestamp::MAX).chain([at]).filter(|at| has_room(*at)).min()
    }
}

impl LatestBegins<'_> {
    /// When a print must begin so that its parts can be unpacked when they are due. Where no printer can begin it in time, none is
    /// counted with: the file is in the queue for whoever sees to it.
    pub fn begin_by(&self, due_at: Timestamp) -> Timestamp {
        let limit = due_at.checked_sub(self.occupied).unwrap_or(Timestamp::MIN);
        let last = |(rules, first): &(&PrinterRules, Timestamp)| {
            let last = (*first <= limit).then(|| rules.begins_by(limit, self.zone)).flatten()?;
            (*first <= last).then_some(last)
        };
        self.printers.iter().filter_map(last).max().unwrap_or(limit)
    }
}

impl PrinterAhead {
    /// What lies ahead of a printer with these builds.
    fn of_spans(place: usize, spans: &[BuildSpan], now: Timestamp) -> Self {
        let PrinterLoad { free_at, builds } = load_of_spans(spans, now);
        let takes_at = spans.iter().filter(|span| !span.is_taken).map(|span| span.begins_at).collect();
        Self { place, free_at, builds, takes_at }
    }

    /// Whether fewer files than this are ahead of it at that time.
    pub fn has_room(&self, depth: u32, at: Timestamp) -> bool {
        self.takes_at.iter().filter(|taken| **taken > at).count() < depth as usize
    }
}

#[cfg(test)]
mod tests {
    use super::{super::trigger::tests::machine_with_triggers, *};

    /// A Wednesday, 00:00 UTC, and hours after it.
    fn at(hour: i64) -> Timestamp {
        "2026-11-25T00:00:00Z".parse::<Timestamp>().unwrap() + jiff::SignedDuration::from_hours(hour)
    }

    #[test]
    fn a_print_begins_by_when_a_printer_is_free_and_open_before_the_date() {
        let mut profile = machine_with_triggers(
            "[[printer]]\nname = \"always\"\n[[printer]]\nname = \"day\"\nhours = \"Mon-Fri 6-22\"\n",
        );
        profile.time_zone = jiff::tz::TimeZone::UTC.into();
        let times = PrintTimes { hours_per_mm: 0.1, cool_down_hours: 2.0, learned_from: 0 };
        // 30 mm: five hours with cooling.
        let begin_by = |always: i64, day: i64, due: i64| {
            let ahead = |(place, free): (usize, i64)| PrinterAhead {
                place,
                free_at: at(free),
                builds: 0,
                takes_at: Vec::new(),
            };
            let printers = [always, day].into_iter().enumerate().map(ahead).collect();
            let by = PrinterOutlook { printers, times }.latest_begins(&profile, 30.0).begin_by(at(due));
            (by.duration_since(at(0)).as_secs_f64() / 3600.0 * 100.0).round() / 100.0
        };
        assert_eq!(begin_by(0, 0, 35), 30.0);
        assert_eq!(begin_by(40, 0, 30), 22.0, "it closes at 22");
        assert_eq!(begin_by(24, 50, 30), 25.0);
        assert_eq!(begin_by(40, 23, 30), 25.0, "one is free after it closed: none begins it in time");
        assert_eq!(begin_by(0, 50, 3), -2.0, "it is too late");
        let none = PrinterOutlook { printers: Vec::new(), times };
        assert_eq!(none.latest_begins(&profile, 30.0).begin_by(at(35)), at(30));
    }

    #[test]
    fn there_is_room_again_when_a_printer_takes_a_file() {
        let times = PrintTimes { hours_per_mm: 0.1, cool_down_hours: 0.0, learned_from: 0 };
        let ahead = |takes: &[i64]| PrinterAhead {
            place: 0,
            free_at: at(9),
            builds: takes.len(),
            takes_at: takes.iter().map(|hour| at(*hour)).collect(),
        };
        let outlook = PrinterOutlook { printers: vec![ahead(&[2, 5]), ahead(&[4, 8])], times };
        assert_eq!(outlook.room_from(0, at(0)), Some(at(0)), "any number");
        assert_eq!(outlook.room_from(3, at(0)), Some(at(0)));
        assert_eq!(outlook.room_from(2, at(0)), Some(at(2)));
        assert_eq!(outlook.room_from(1, at(0)), Some(at(5)));
        assert_eq!(outlook.room_from(1, at(6)), Some(at(6)));
        let never = PrinterAhead { takes_at: vec![Timestamp::MAX], ..ahead(&[]) };
        assert_eq!(PrinterOutlook { printers: vec![never], times }.room_from(1, at(0)), None);
    }
}
