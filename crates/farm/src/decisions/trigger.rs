//! When a batch fires: a pure function of the waiting parts, the open build, and the time.

use std::{collections::BTreeMap, fmt};

use jiff::{SignedDuration, Timestamp, civil::Date};
use ledger::DueArrival;
use schemars::JsonSchema;
use serde::Serialize;
use settings::MachineProfile;

use super::printer_outlook::PrinterOutlook;

/// Why a batch fired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FireTrigger {
    /// An operator asked for it.
    Flush,
    /// A waiting copy was tried and found no place.
    Full,
    /// The open build has reached the configured share of the volume.
    Fill,
    /// Enough copies wait.
    Copies,
    /// The oldest part has waited long enough.
    MaxWait,
    /// A due date is near.
    Due,
    /// A time of day has come.
    At,
    /// nestd took a published build back out of the queue, so that this one holds its copies, too.
    Withdrawn,
}

impl fmt::Display for FireTrigger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Flush => "flush",
            Self::Full => "full",
            Self::Fill => "fill",
            Self::Copies => "copies",
            Self::MaxWait => "max_wait",
            Self::Due => "due",
            Self::At => "at",
            Self::Withdrawn => "withdrawn",
        })
    }
}

/// The input of the triggers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriggerFacts {
    /// Number of waiting copies.
    pub copies: usize,
    /// Since when the part waits that has waited longest.
    pub oldest: Timestamp,
    /// What fires a batch for a due date; `None` = no waiting part has one, or they fire nothing.
    pub due: Option<DueFacts>,
    /// Height of the open build, mm; 0 when there is no layout yet.
    pub height_mm: f64,
    /// Part volume of the open build / volume of the whole build volume.
    pub density: f64,
    /// Whether a layout of all waiting copies was tried to the end of its budget and a copy found no place.
    pub full: bool,
    /// Whether an operator asked for it.
    pub flush: bool,
    /// Whether copies of a build that nestd withdrew are among the waiting ones.
    pub takes_over: bool,
    /// Whether the clock was not set recently, so that dates may be acted on.
    pub is_date_trusted: bool,
}

/// The gathering before a batch fires for a due date: parts that are dropped one after another go into one build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DueFacts {
    /// Since when a due date is near: when its print must begin, less the margin, or the arrival of a part whose date is nearer.
    pub near_at: Timestamp,
    /// When the final search must begin to meet the nearest due date.
    pub start_by: Timestamp,
    /// When the newest part arrived.
    pub newest: Timestamp,
}

/// A batch gathers for at most this many times `gather_secs`, however many parts arrive.
const MAX_GATHERS: f64 = 4.0;

impl DueFacts {
    /// The facts of the due dates of waiting parts, for an open build of this height; `newest` is when the newest part
    /// arrived.
    pub fn of_arrivals(
        profile: &MachineProfile,
        outlook: &PrinterOutlook,
        height_mm: f64,
        dues: &[DueArrival],
        newest: Timestamp,
    ) -> Option<Self> {
        let margin_secs = profile.trigger.due_margin_secs?;
        // The final search, and as long again for the proof and the file.
        let prepare_secs = 2.0 * profile.search.final_secs;
        let begins = outlook.latest_begins(profile, height_mm);
        let start_by = |due_at: Timestamp| add_secs(begins.begin_by(due_at), -prepare_secs);
        let mut arrivals: BTreeMap<Timestamp, Timestamp> = BTreeMap::new();
        for due in dues {
            let first = arrivals.entry(due.due_at.0).or_insert(due.arrived_at.0);
            *first = (*first).min(due.arrived_at.0);
        }
        let near_at = |(&due_at, &arrived_at)| Some(add_secs(start_by(due_at)?, -margin_secs)?.max(arrived_at));
        let (&nearest, _) = arrivals.first_key_value()?;
        Some(Self { near_at: arrivals.iter().filter_map(near_at).min()?, start_by: start_by(nearest)?, newest })
    }

    /// When the batch fires if nothing more arrives. A due date that can still be met is never missed by gathering.
    pub fn fires_at(&self, profile: &MachineProfile) -> Timestamp {
        let gather_secs = profile.trigger.gather_secs;
        let later = |time: Timestamp, secs: f64| add_secs(time, secs).unwrap_or(Timestamp::MAX);
        let longest = later(self.near_at, MAX_GATHERS * gather_secs);
        let longest = if self.start_by > self.near_at { longest.min(self.start_by) } else { longest };
        later(self.newest, gather_secs).min(longest).max(self.near_at)
    }
}

/// The first trigger that holds, if any.
pub fn find_trigger(profile: &MachineProfile, facts: &TriggerFacts, now: Timestamp) -> Option<FireTrigger> {
    if facts.copies == 0 {
        return None;
    }
    let trigger = &profile.trigger;
    let share = |limit: Option<f64>, value: f64| limit.is_some_and(|limit| value >= limit);
    let height_share = facts.height_mm / profile.build_volume().size_mm.z;
    let holds = [
        (facts.flush, FireTrigger::Flush),
        (facts.takes_over, FireTrigger::Withdrawn),
        (facts.full, FireTrigger::Full),
        (share(trigger.fill_height, height_share) || share(trigger.fill_density, facts.density), FireTrigger::Fill),
        (trigger.copies.is_some_and(|n| facts.copies >= n as usize), FireTrigger::Copies),
    ];
    let timed = || trigger_times(profile, facts).into_iter().find(|(at, _)| *at <= now);
    holds.into_iter().find(|(holds, _)| *holds).map(|(_, by)| by).or_else(|| Some(timed()?.1))
}

/// When a batch of the waiting parts fires because of the time alone, and why; a time in the past means that it fires
/// at once.
pub fn next_timed_trigger(profile: &MachineProfile, facts: &TriggerFacts) -> Option<(Timestamp, FireTrigger)> {
    if facts.copies == 0 {
        return None;
    }
    // Of triggers at the same time the first counts, as in [`find_trigger`].
    trigger_times(profile, facts).into_iter().min_by_key(|(at, _)| *at)
}

/// The time from which each time-based trigger holds, in order of precedence.
fn trigger_times(profile: &MachineProfile, facts: &TriggerFacts) -> Vec<(Timestamp, FireTrigger)> {
    let (trigger, knows) = (&profile.trigger, facts.is_date_trusted);
    let moments = [
        // When the clock is set, the times of the waiting parts are adjusted: this is how long the part has really
        // waited.
        (add_secs(facts.oldest, trigger.max_wait_secs), FireTrigger::MaxWait),
        (facts.due.filter(|_| knows).map(|due| due.fires_at(profile)), FireTrigger::Due),
        (first_daily_time_after(profile, facts.oldest).filter(|_| knows), FireTrigger::At),
    ];
    moments.into_iter().filter_map(|(at, by)| Some((at?, by))).collect()
}

/// When the next trigger holds by the passing of time alone; `None` = none does.
pub(crate) fn next_timed(profile: &MachineProfile, facts: &TriggerFacts, now: Timestamp) -> Option<Timestamp> {
    let to_come = |(at, _)| Some(at).filter(|at| *at > now);
    trigger_times(profile, facts).into_iter().filter_map(to_come).min().filter(|_| facts.copies > 0)
}

/// The time this many seconds later.
fn add_secs(time: Timestamp, secs: f64) -> Option<Timestamp> {
    time.checked_add(SignedDuration::try_from_secs_f64(secs).ok()?).ok()
}

/// Seconds from `earlier` to `later`.
pub fn secs_between(earlier: Timestamp, later: Timestamp) -> f64 {
    later.duration_since(earlier).as_secs_f64()
}

/// The first of the local times of day after the oldest part began to wait; so a time that passed while the daemon was down
/// still counts.
fn first_daily_time_after(profile: &MachineProfile, oldest: Timestamp) -> Option<Timestamp> {
    let (at, zone) = (&profile.trigger.at, profile.time_zone.time_zone());
    let today = oldest.to_zoned(zone.clone()).date();
    let days = [Some(today), today.tomorrow().ok()];
    let on = |day: Date, time: &jiff::civil::Time| day.to_datetime(*time).to_zoned(zone.clone()).ok();
    let all =
        days.into_iter().flatten().flat_map(|day| at.iter().filter_map(move |time| Some(on(day, time)?.timestamp())));
    all.filter(|time| *time > oldest).min()
}

#[cfg(test)]
pub(crate) mod tests {
    use jiff::{SignedDuration, ToSpan};
    use ledger_fixtures::{fresh, waiting};

    use super::{
        super::{print_times::PrintTimes, printer_outlook::PrinterAhead},
        *,
    };

    /// A machine that fires after a day, an hour before a due date, and at five o'clock.
    fn machine() -> MachineProfile {
        machine_with_triggers("max_wait_secs = \"24h\"\nat = [\"17:00\"]\n")
    }

    /// A machine with these settings of its triggers.
    pub(crate) fn machine_with_triggers(settings: &str) -> MachineProfile {
        let folder = tempfile::tempdir().unwrap();
        let profile = format!("volume_mm = [100, 100, 100]\n[trigger]\n{settings}");
        std::fs::create_dir(folder.path().join("profiles")).unwrap();
        std::fs::write(folder.path().join("profiles/m.toml"), profile).unwrap();
        std::fs::write(folder.path().join("nestd.toml"), "").unwrap();
        let mut settings = settings::load_settings(Some(&folder.path().join("nestd.toml")), None).unwrap();
        settings.profiles.remove("m").unwrap()
    }

    fn facts(oldest: Timestamp, due: Option<Timestamp>, knows_the_date: bool) -> TriggerFacts {
        TriggerFacts {
            copies: 1,
            oldest,
            due: due_facts(&machine(), 0.0, due, oldest),
            height_mm: 0.0,
            density: 0.0,
            full: false,
            flush: false,
            takes_over: false,
            is_date_trusted: knows_the_date,
        }
    }

    /// Nothing is known of its printers.
    fn without_printers(machine: &MachineProfile) -> PrinterOutlook {
        PrinterOutlook { printers: Vec::new(), times: PrintTimes::of_settings(machine) }
    }

    /// The facts of a part that is due then and is the only one that arrived.
    fn due_facts(
        machine: &MachineProfile,
        height_mm: f64,
        due: Option<Timestamp>,
        arrived: Timestamp,
    ) -> Option<DueFacts> {
        let due = DueArrival { due_at: due?.into(), arrived_at: arrived.into() };
        DueFacts::of_arrivals(machine, &without_printers(machine), height_mm, &[due], arrived)
    }

    fn at(hour: i8, minute: i8) -> Timestamp {
        jiff::civil::date(2026, 11, 20)
            .at(hour, minute, 0, 0)
            .to_zoned(jiff::tz::TimeZone::system())
            .unwrap()
            .timestamp()
    }

    #[tokio::test]
    async fn a_clock_that_is_set_by_a_day_neither_fires_nor_forgets_a_wait() {
        let (machine, day) = (machine(), SignedDuration::from_hours(24));
        for jump in [day, -day, SignedDuration::from_hours(24 * 365), SignedDuration::from_mins(-90)] {
            let ledger = fresh().await;
            let claimed = at(8, 0);
            let ledger = ledger.ledger.clone().with_clock(move || claimed);
            let part = waiting(&ledger, "a", 1).await;
            let oldest = async || ledger.find_part(part).await.unwrap().unwrap().times.claimed_at.0;
            // Twenty minutes later the clock is set.
            ledger.shift_claim_times(jump).await.unwrap();
            let now = at(8, 20).checked_add(jump).unwrap();
            assert_eq!(find_trigger(&machine, &facts(oldest().await, None, false), now), None, "set by {jump:#}");
            let just_before = now.checked_add((23.hours()).minutes(39)).unwrap();
            assert_eq!(
                find_trigger(&machine, &facts(oldest().await, None, false), just_before),
                None,
                "set by {jump:#}"
            );
            let then = now.checked_add((23.hours()).minutes(41)).unwrap();
            assert_eq!(find_trigger(&machine, &facts(oldest().await, None, false), then), Some(FireTrigger::MaxWait));
        }
    }

    #[test]
    fn dates_wait_while_the_clock_is_not_sure_and_are_not_forgotten() {
        let machine = machine();
        let due = Some(at(12, 0));
        assert_eq!(find_trigger(&machine, &facts(at(8, 0), due, true), at(10, 30)), None);
        assert_eq!(find_trigger(&machine, &facts(at(8, 0), due, true), at(11, 30)), Some(FireTrigger::Due));
        assert_eq!(find_trigger(&machine, &facts(at(8, 0), due, false), at(11, 30)), None);
        assert_eq!(find_trigger(&machine, &facts(at(8, 0), None, false), at(17, 1)), None);
        assert_eq!(find_trigger(&machine, &facts(at(8, 0), None, true), at(17, 6)), Some(FireTrigger::At));
    }

    #[test]
    fn overdue_parts_are_gathered_until_nothing_came_for_a_while_and_not_for_ever() {
        let machine = machine_with_triggers("gather_secs = \"15m\"\nmax_wait_secs = \"24h\"\n");
        let overdue = |arrived: Timestamp| DueArrival { due_at: at(0, 0).into(), arrived_at: arrived.into() };
        let fires = |dues: &[DueArrival], newest: Timestamp| {
            DueFacts::of_arrivals(&machine, &without_printers(&machine), 10.0, dues, newest).unwrap().fires_at(&machine)
        };
        assert_eq!(fires(&[overdue(at(8, 0))], at(8, 0)), at(8, 15));
        // Any part that arrives counts, also one without a date.
        assert_eq!(fires(&[overdue(at(8, 0))], at(8, 14)), at(8, 29));
        // A drizzle, in which each part is longer overdue than the one before.
        let earlier = DueArrival { due_at: at(0, 0).checked_sub(24.hours()).unwrap().into(), ..overdue(at(8, 50)) };
        assert_eq!(fires(&[overdue(at(8, 0)), earlier], at(8, 50)), at(9, 0));
        let at_once = machine_with_triggers("gather_secs = 0\n");
        let due = DueFacts::of_arrivals(&at_once, &without_printers(&at_once), 10.0, &[overdue(at(8, 0))], at(8, 14))
            .unwrap();
        assert_eq!(due.fires_at(&at_once), at(8, 0));
    }

    #[test]
    fn gathering_does_not_cost_a_due_date_that_can_still_be_met() {
        let mut machine = machine_with_triggers("gather_secs = \"15m\"\ndue_margin_secs = \"30m\"\n");
        machine.search.final_secs = 0.0;
        // 10 mm take an hour: it must begin at 11:00, and is near from 10:30 on.
        let due = |arrived: Timestamp| DueArrival { due_at: at(12, 0).into(), arrived_at: arrived.into() };
        let fires = |arrived: Timestamp, newest: Timestamp| {
            DueFacts::of_arrivals(&machine, &without_printers(&machine), 10.0, &[due(arrived)], newest)
                .unwrap()
                .fires_at(&machine)
        };
        assert_eq!(fires(at(8, 0), at(8, 0)), at(10, 30));
        assert_eq!(fires(at(8, 0), at(10, 20)), at(10, 35));
        assert_eq!(fires(at(8, 0), at(10, 50)), at(11, 0), "not after it must begin");
        assert_eq!(fires(at(10, 55), at(10, 55)), at(11, 0));
        assert_eq!(fires(at(11, 5), at(11, 5)), at(11, 20), "it is late in any case");
    }

    #[test]
    fn a_file_is_in_the_queue_before_its_printer_closes() {
        let printer = "[[printer]]\nname = \"day\"\nhours = \"Mon-Fri 6-22\"\n";
        let mut machine = machine_with_triggers(&format!("gather_secs = \"15m\"\n{printer}"));
        machine.time_zone = jiff::tz::TimeZone::UTC.into();
        machine.search.final_secs = 90.0;
        let time = |text: &str| text.parse::<Timestamp>().unwrap();
        // A Friday; the date is on Sunday.
        let free = PrinterAhead { place: 0, free_at: time("2026-11-20T08:00:00Z"), builds: 0, takes_at: Vec::new() };
        let outlook = PrinterOutlook { printers: vec![free], times: PrintTimes::of_settings(&machine) };
        let arrived_at = time("2026-11-20T21:50:00Z");
        let due = DueArrival { due_at: time("2026-11-22T20:00:00Z").into(), arrived_at: arrived_at.into() };
        let facts = DueFacts::of_arrivals(&machine, &outlook, 10.0, &[due, due], arrived_at).unwrap();
        assert_eq!(facts.fires_at(&machine), time("2026-11-20T21:56:59Z"), "three minutes before it closes");
    }

    #[test]
    fn a_batch_fires_at_the_moment_that_was_told_and_not_a_second_before() {
        let (day, second) = (SignedDuration::from_hours(24), SignedDuration::from_secs(1));
        let mut seen = std::collections::BTreeSet::new();
        for case in 0..2000_i64 {
            let mut machine = machine();
            let arrived = at(0, 0).checked_add(SignedDuration::from_millis(case * 7_919_311)).unwrap();
            machine.trigger.max_wait_secs = (case * 104_729 % 200_000) as f64 + 0.123_456_7;
            machine.trigger.at = if case % 3 == 0 {
                Vec::new()
            } else {
                vec![jiff::civil::time((case % 24) as i8, (case % 60) as i8, 0, 0)]
            };
            machine.trigger.due_margin_secs = (case % 5 != 0).then_some(case as f64 * 1.7);
            machine.space.print_hours_per_mm = 0.013 * (case % 7) as f64;
            let due = (case % 2 == 0).then(|| arrived.checked_add(day * (case % 4) as i32).unwrap());
            machine.trigger.gather_secs = (case % 13) as f64 * 700.3;
            let height_mm = (case % 90) as f64 * 0.37;
            let due = due_facts(&machine, height_mm, due, arrived);
            let facts = TriggerFacts { height_mm, due, ..facts(arrived, None, case % 11 != 0) };
            let (then, by) = next_timed_trigger(&machine, &facts).unwrap();
            assert_eq!(find_trigger(&machine, &facts, then), Some(by), "case {case}");
            assert_eq!(find_trigger(&machine, &facts, then.checked_sub(second).unwrap()), None, "case {case}");
            seen.insert(by.to_string());
        }
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), ["at", "due", "max_wait"]);
    }
}
