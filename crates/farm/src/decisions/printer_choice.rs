//! Which printer of a machine is free first. This is a function of facts and time.

use std::collections::BTreeMap;

use jiff::{SignedDuration, Timestamp};
use ledger::{BuildId, BuildState, OccupyingBuild};
use settings::{MachineProfile, PrinterRules};

use super::print_times::PrintTimes;

/// What lies ahead of a printer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrinterLoad {
    /// When the next print could begin.
    pub free_at: Timestamp,
    /// Number of builds before that: being made for it, in its queue, or printed.
    pub builds: usize,
}

/// When a build that occupies a printer is printed, as far as is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuildSpan {
    /// The build.
    pub build: BuildId,
    /// When its print begins, or began.
    pub begins_at: Timestamp,
    /// When the print itself ends, without cooling.
    pub printed_at: Timestamp,
    /// When the printer is free of it.
    pub ends_at: Timestamp,
    /// Whether its file was put into the queue.
    pub is_published: bool,
    /// Whether its print has begun: that was told, or its file was taken out of the queue.
    pub is_taken: bool,
    /// Whether somebody told that its print began.
    pub is_told: bool,
}

/// How far a build is that occupies a printer, as far as is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuildStage {
    /// It is made for it.
    Made,
    /// Its file lies in the queue.
    Queued,
    /// Its file lies in the printer, behind others.
    Taken,
    /// It is printed.
    Printing,
    /// It cools, and is unpacked.
    Cooling,
    /// It should be done.
    Ended,
}

impl BuildSpan {
    /// How far it is.
    pub fn stage(&self, now: Timestamp) -> BuildStage {
        match () {
            () if self.is_taken && now >= self.ends_at => BuildStage::Ended,
            () if self.is_taken && now >= self.printed_at => BuildStage::Cooling,
            () if self.is_taken && now >= self.begins_at => BuildStage::Printing,
            () if self.is_taken => BuildStage::Taken,
            () if self.is_published => BuildStage::Queued,
            () => BuildStage::Made,
        }
    }
}

/// The load of each printer of a machine.
pub fn printer_loads(
    profile: &MachineProfile,
    builds: &[OccupyingBuild],
    times: &PrintTimes,
    now: Timestamp,
) -> BTreeMap<String, PrinterLoad> {
    let spans = build_spans(profile, builds, times, |_| false, now);
    let load = |rules: &PrinterRules| {
        let spans = spans.get(&rules.name).map_or(&[][..], Vec::as_slice);
        let load = load_of_spans(spans, now);
        let free_at = rules.begins_at(load.free_at, &profile.time_zone);
        (rules.name.clone(), PrinterLoad { free_at, ..load })
    };
    profile.printers.iter().map(load).collect()
}

/// The load of a printer with these builds, whatever its hours.
pub fn load_of_spans(spans: &[BuildSpan], now: Timestamp) -> PrinterLoad {
    let free_at = spans.last().map_or(now, |span| span.ends_at.max(now));
    PrinterLoad { free_at, builds: spans.iter().filter(|span| span.is_told || span.ends_at >= now).count() }
}

/// When the builds of each printer of a machine are printed. Published builds without a printer are those of the first; a
/// fired build whose printer is not decided yet occupies none. What a printer that `is_down` has not begun, begins at
/// [`Timestamp::MAX`]: nobody knows when.
pub fn build_spans(
    profile: &MachineProfile,
    builds: &[OccupyingBuild],
    times: &PrintTimes,
    is_down: impl Fn(&str) -> bool,
    now: Timestamp,
) -> BTreeMap<String, Vec<BuildSpan>> {
    let spans = |(place, rules): (usize, &PrinterRules)| {
        let is_of = |build: &&OccupyingBuild| match &build.printer {
            Some(printer) => *printer == rules.name,
            None => place == 0 && build.published_at.is_some(),
        };
        let rules = (rules, is_down(&rules.name));
        (rules.0.name.clone(), spans_of(profile, rules, builds.iter().filter(is_of), times, now))
    };
    profile.printers.iter().enumerate().map(spans).collect()
}

/// Lets the builds be printed one after the other, each as soon as it can be.
fn spans_of<'b>(
    profile: &MachineProfile,
    (rules, is_down): (&PrinterRules, bool),
    builds: impl Iterator<Item = &'b OccupyingBuild>,
    times: &PrintTimes,
    now: Timestamp,
) -> Vec<BuildSpan> {
    let (mut free_at, mut spans) = (Timestamp::MIN, Vec::new());
    for build in builds {
        let begins_at = match (build.begun_at, &build.printer) {
            // It lay in the printer while an earlier one was printed.
            (Some(at), _) => at.0.max(free_at),
            (None, Some(_)) if is_down && build.state != BuildState::Printing => Timestamp::MAX,
            // Its file lies in the queue, or it is still made: it has not begun.
            (None, Some(_)) => rules.begins_at(free_at.max(now), &profile.time_zone),
            // Nobody looks for the files of builds of an earlier nestd.
            (None, None) => {
                let ready_at = build.published_at.map_or(now, |at| at.0);
                rules.begins_at(ready_at.max(free_at), &profile.time_zone)
            }
        };
        let height_mm = build.height_mm.unwrap_or(0.0);
        let after = |span: SignedDuration| begins_at.checked_add(span).unwrap_or(Timestamp::MAX);
        free_at = after(times.occupied(height_mm));
        let is_told = build.state == BuildState::Printing;
        spans.push(BuildSpan {
            build: build.build,
            begins_at,
            printed_at: after(times.printed(height_mm)),
            ends_at: free_at,
            is_published: build.published_at.is_some(),
            is_taken: build.begun_at.is_some() || build.printer.is_none() || is_told,
            is_told,
        });
    }
    spans
}

/// The printer that a build goes to, of those that can be used: the one that is free first; of those that are free at the same
/// time, the one with fewer builds, then the first in the machine's file. `build` itself occupies none.
pub fn choose_printer<'n>(
    profile: &MachineProfile,
    usable: &[&'n str],
    (build, builds): (BuildId, &[OccupyingBuild]),
    times: &PrintTimes,
    now: Timestamp,
) -> Option<&'n str> {
    let others: Vec<OccupyingBuild> = builds.iter().filter(|other| other.build != build).cloned().collect();
    let loads = printer_loads(profile, &others, times, now);
    let key = |name: &&&str| loads.get(**name).map(|load| (load.free_at, load.builds));
    usable.iter().filter(|name| loads.contains_key(**name)).min_by_key(key).copied()
}

#[cfg(test)]
mod tests {
    use super::{super::trigger::tests::machine_with_triggers, *};

    /// A machine of two printers, at 1 h per 10 mm.
    fn machine(left: &str, right: &str) -> MachineProfile {
        let printers = format!("[[printer]]\nname = \"left\"\n{left}[[printer]]\nname = \"right\"\n{right}");
        machine_with_triggers(&printers)
    }

    fn at(hour: i64) -> Timestamp {
        // A Wednesday.
        "2026-11-25T00:00:00Z".parse::<Timestamp>().unwrap() + jiff::SignedDuration::from_hours(hour)
    }

    fn build(id: i64, printer: &str, height_mm: f64, published: Option<i64>) -> OccupyingBuild {
        OccupyingBuild {
            build: BuildId(id),
            printer: Some(printer.to_owned()),
            state: if published.is_some() { BuildState::Published } else { BuildState::Nesting },
            height_mm: Some(height_mm),
            published_at: published.map(|hour| at(hour).into()),
            begun_at: None,
        }
    }

    fn choose(profile: &MachineProfile, builds: &[OccupyingBuild], now: i64) -> String {
        let times = PrintTimes { hours_per_mm: 0.1, cool_down_hours: 0.0, learned_from: 0 };
        choose_printer(profile, &["left", "right"], (BuildId(99), builds), &times, at(now)).unwrap().to_owned()
    }

    #[test]
    fn a_build_goes_to_the_printer_that_is_free_first() {
        let profile = machine("", "");
        assert_eq!(choose(&profile, &[], 8), "left");
        assert_eq!(choose(&profile, &[build(1, "left", 100.0, Some(8))], 8), "right");
        let both = [build(1, "left", 100.0, Some(8)), build(2, "right", 40.0, Some(8))];
        assert_eq!(choose(&profile, &both, 9), "right", "free at 12, the other one at 18");
        let queued = [&both[..], &[build(3, "right", 80.0, Some(9))]].concat();
        assert_eq!(choose(&profile, &queued, 9), "left", "free at 18, the other one at 20");
        assert_eq!(choose(&profile, &queued, 40), "left", "both are free for long");
        // A build that is being made for a printer occupies it, and not itself.
        let made = [build(1, "left", 100.0, None), build(99, "right", 500.0, None)];
        assert_eq!(choose(&profile, &made, 8), "right");
    }

    /// A build whose print began at this hour.
    fn printed(id: i64, printer: &str, height_mm: f64, begun: i64) -> OccupyingBuild {
        OccupyingBuild { begun_at: Some(at(begun).into()), ..build(id, printer, height_mm, Some(begun)) }
    }

    #[test]
    fn a_build_whose_file_still_lies_in_the_queue_has_not_begun() {
        let profile = machine("", "");
        // Published at the same time; one was taken at once, the other lies there five hours later.
        let both = [build(1, "left", 80.0, Some(8)), printed(2, "right", 100.0, 8)];
        assert_eq!(choose(&profile, &both, 13), "right", "free at 18, the other one at 21");
        // Where nobody has looked, it is taken to have begun.
        let earlier = OccupyingBuild { printer: None, ..build(1, "left", 80.0, Some(8)) };
        assert_eq!(choose(&profile, &[earlier, both[1].clone()], 13), "left", "free at 16");
    }

    #[test]
    fn a_print_that_was_told_to_go_on_occupies_its_printer_however_long_that_takes() {
        let profile = machine("", "");
        let mut long = build(1, "left", 10.0, Some(0));
        long.state = BuildState::Printing;
        let loads = printer_loads(&profile, &[long], &PrintTimes::of_settings(&profile), at(48));
        assert_eq!((loads["left"].builds, loads["right"].builds), (1, 0));
    }

    #[test]
    fn prints_begin_in_the_hours_of_the_printer_and_go_on_over_night() {
        let mut profile = machine("hours = \"Mon-Fri 6-22\"\n", "hours = \"Mon-Fri 6-14\"\n");
        profile.time_zone = jiff::tz::TimeZone::UTC.into();
        // Free at 20 and at 2 of the night: one begins at once, the other at 6 of the next day.
        let builds = [printed(1, "left", 100.0, 10), printed(2, "right", 200.0, 6)];
        let times = PrintTimes { hours_per_mm: 0.1, cool_down_hours: 0.0, learned_from: 0 };
        let loads = printer_loads(&profile, &builds, &times, at(12));
        assert_eq!((loads["left"].free_at, loads["right"].free_at), (at(20), at(30)));
        assert_eq!(choose(&profile, &builds, 12), "left");
        // On a Friday evening.
        assert_eq!(printer_loads(&profile, &[], &times, at(2 * 24 + 23))["left"].free_at, at(5 * 24 + 6));
    }
}
