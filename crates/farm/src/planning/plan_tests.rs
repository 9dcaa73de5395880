//! Tables of the plan: what is in each build, when it fires and is done, and what puts due dates at risk.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use ledger::{BuildId, PartId, PartRow, WaitingPart};
use ledger_fixtures::part_row;
use settings::MachineProfile;

use super::{
    build_plan::{ComingBuild, plan_builds},
    date_outlook::{EndReserve, MadeBuild, RiskCause, outlook_of_coming, outlook_of_made},
    earliest_date::plan_earliest,
    packing_experience::PackingExperience,
    plan_facts::{FiredBuild, PlanFacts, PlanHindrance, PlanLine, StandingLayout},
};
use crate::decisions::{
    print_times::PrintTimes,
    printer_choice::BuildStage,
    printer_outlook::{PrinterAhead, PrinterOutlook},
    trigger::tests::machine_with_triggers,
};

/// A Wednesday, 00:00 UTC, and hours after it.
fn at(hour: f64) -> Timestamp {
    let midnight: Timestamp = "2026-11-25T00:00:00Z".parse().unwrap();
    midnight.checked_add(SignedDuration::from_secs_f64(3600.0 * hour)).unwrap()
}

/// Hours after that Wednesday began.
fn hour(time: Timestamp) -> f64 {
    (time.duration_since(at(0.0)).as_secs_f64() / 36.0).round() / 100.0
}

/// A machine of 100 x 100 x 100 mm that prints 10 mm in an hour, and needs no time for its final search.
fn machine(more: &str) -> MachineProfile {
    let mut profile = machine_with_triggers(more);
    profile.search.final_secs = 0.0;
    profile.space.print_hours_per_mm = 0.1;
    profile.time_zone = jiff::tz::TimeZone::UTC.into();
    profile
}

/// A part of cubes of 10 mm, due at this hour.
fn cubes(id: i64, copies: u32, due: Option<f64>) -> WaitingPart {
    let mut part: PartRow = part_row(PartId(id), copies, at(0.0));
    part.terms.due_at = due.map(|hour| at(hour).into());
    part.measures.volume_mm3 = Some(1e3);
    [part.measures.size_x_mm, part.measures.size_y_mm, part.measures.size_z_mm] = [Some(10.0); 3];
    WaitingPart { part, copies: (0..copies).collect() }
}

/// Facts at the usual density: 100 cubes stand 100 mm high.
fn facts(profile: &MachineProfile, waiting: Vec<WaitingPart>) -> PlanFacts {
    let times = PrintTimes { hours_per_mm: 0.1, cool_down_hours: 0.0, learned_from: 0 };
    let idle = |place| PrinterAhead { place, free_at: at(0.0), builds: 0, takes_at: Vec::new() };
    let printers = (0..profile.printers.len()).map(idle).collect();
    PlanFacts {
        lines: PlanFacts::rank_lines(profile, waiting, &Default::default()),
        layout: None,
        newest: at(0.0),
        fired: Vec::new(),
        outlook: PrinterOutlook { printers, times },
        hindrance: None,
        packing: PackingExperience::learn(profile, &[]),
    }
}

/// (part, copies) of a build, its height, and the hours at which it fires, begins and ends.
type BuildLine = (Vec<(i64, u32)>, f64, [f64; 3]);

fn lines(builds: &[ComingBuild]) -> Vec<BuildLine> {
    let line = |build: &ComingBuild| {
        let parts = build.lines.iter().map(|line| (line.part.id.0, line.copies)).collect();
        let print = build.print.unwrap();
        let fires = build.fires.map_or(f64::NAN, |(at, _)| hour(at));
        (parts, build.height_mm.round(), [fires, hour(print.begins_at), hour(print.ends_at)])
    };
    builds.iter().map(line).collect()
}

#[test]
fn full_builds_fire_at_once_one_after_the_other_and_the_rest_waits_for_its_trigger() {
    let profile = machine("max_wait_secs = \"24h\"\ndue_margin_secs = \"1h\"\ngather_secs = 0\n");
    let waiting = vec![cubes(1, 90, None), cubes(2, 60, Some(30.0)), cubes(3, 70, Some(40.0))];
    let builds = plan_builds(&profile, &facts(&profile, waiting), at(0.0));
    let expected: Vec<BuildLine> = vec![
        (vec![(2, 60), (3, 40)], 100.0, [0.0, 0.0, 10.0]),
        (vec![(3, 30), (1, 70)], 100.0, [0.0, 10.0, 20.0]),
        (vec![(1, 20)], 20.0, [24.0, 24.0, 26.0]),
    ];
    assert_eq!(lines(&builds), expected);
}

#[test]
fn a_build_fires_early_enough_for_its_due_date_and_goes_to_the_printer_that_is_free_first() {
    let printers = "[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\nhours = \"Mon-Fri 6-22\"\n";
    let rules = format!("max_wait_secs = \"100h\"\ndue_margin_secs = \"1h\"\ngather_secs = 0\n{printers}");
    let profile = machine(&rules);
    let plan = |due: f64, left: f64, right: f64| {
        let mut facts = facts(&profile, vec![cubes(1, 40, Some(due))]);
        (facts.outlook.printers[0].free_at, facts.outlook.printers[1].free_at) = (at(left), at(right));
        let builds = plan_builds(&profile, &facts, at(0.0));
        let print = builds[0].print.unwrap();
        let name = profile.printers[print.place].name.clone();
        (name, hour(builds[0].fires.unwrap().0), hour(print.begins_at), hour(print.ends_at))
    };
    // It prints for 4 hours, and fires an hour before that.
    assert_eq!(plan(20.0, 0.0, 0.0), ("left".to_owned(), 15.0, 15.0, 19.0));
    assert_eq!(plan(20.0, 18.0, 0.0), ("right".to_owned(), 15.0, 15.0, 19.0));
    assert_eq!(plan(28.0, 40.0, 0.0), ("right".to_owned(), 21.0, 21.0, 25.0), "the right one closes at 22");
    // None can begin it in time.
    assert_eq!(plan(8.0, 10.0, 0.0), ("right".to_owned(), 3.0, 6.0, 10.0), "the right one begins at six");
    assert_eq!(plan(8.0, 5.0, 0.0), ("left".to_owned(), 3.0, 5.0, 9.0));
    assert_eq!(plan(2.0, 30.0, 30.0), ("left".to_owned(), 0.0, 30.0, 34.0));
}

#[test]
fn an_order_that_no_plan_reaches_the_end_of_has_no_date() {
    let profile = machine("max_wait_secs = 0\n");
    let order = |copies: u32| {
        plan_earliest(&profile, &facts(&profile, Vec::new()), &[Arc::new(cubes(1, copies, None).part)], false, at(0.0))
    };
    let (done, place) = order(10_000).done.unwrap();
    assert_eq!((hour(done), place), (1000.0, 99));
    assert_eq!(order(10_001).done, None, "only a hundred builds are planned");
}

#[test]
fn where_the_queue_is_full_a_build_stays_open_until_a_printer_takes_a_file() {
    let mut profile = machine("max_wait_secs = 0\n");
    let fires = |profile: &MachineProfile| {
        let builds = plan_builds(profile, &facts(profile, vec![cubes(1, 350, None)]), at(0.0));
        lines(&builds).into_iter().map(|(_, _, [fires, begins, _])| (fires, begins)).collect::<Vec<_>>()
    };
    assert_eq!(fires(&profile), [(0.0, 0.0), (0.0, 10.0), (0.0, 20.0), (0.0, 30.0)]);
    profile.printing.queue_depth = 1;
    assert_eq!(fires(&profile), [(0.0, 0.0), (0.0, 10.0), (10.0, 20.0), (20.0, 30.0)]);
    profile.printing.queue_depth = 2;
    assert_eq!(fires(&profile), [(0.0, 0.0), (0.0, 10.0), (0.0, 20.0), (10.0, 30.0)]);
}

#[test]
fn the_layout_of_the_open_build_stands_and_what_joins_it_is_estimated() {
    let profile = machine("max_wait_secs = \"24h\"\n");
    let standing = (0..50).map(|copy| (PartId(1), copy)).collect();
    let layout = StandingLayout { build: Some(BuildId(7)), height_mm: 30.0, part_volume_mm3: 5e4 };
    let plan = |waiting: Vec<WaitingPart>| {
        let lines = PlanFacts::rank_lines(&profile, waiting, &standing);
        let facts = PlanFacts { lines, layout: Some(layout), ..facts(&profile, Vec::new()) };
        plan_builds(&profile, &facts, at(0.0))
    };
    let alone = plan(vec![cubes(1, 50, None)]);
    assert_eq!((alone[0].build, alone[0].height_mm, alone[0].is_nested), (Some(BuildId(7)), 30.0, true));
    // It is packed tighter than usual: what joins it is, too.
    let joined = plan(vec![cubes(1, 50, None), cubes(2, 50, None)]);
    assert_eq!((joined.len(), joined[0].height_mm.round(), joined[0].is_nested), (1, 60.0, false));
    // A tall part that may not be turned needs its height.
    let mut tall = cubes(3, 1, None);
    (tall.part.measures.size_z_mm, tall.part.terms.orientation) = (Some(80.0), nester::OrientationRule::Fixed);
    assert_eq!(plan(vec![cubes(1, 50, None), tall])[0].height_mm, 80.0);
}

#[test]
fn builds_that_have_fired_come_before_the_others_and_nothing_fires_while_the_machine_is_paused() {
    let profile = machine("max_wait_secs = \"1h\"\n");
    let mut facts = facts(&profile, vec![cubes(1, 10, None)]);
    facts.fired = vec![FiredBuild { build: BuildId(3), height_mm: 50.0 }];
    let builds = plan_builds(&profile, &facts, at(0.0));
    assert_eq!((builds[0].build, builds[0].fires), (Some(BuildId(3)), None));
    let print = builds[1].print.unwrap();
    assert_eq!((hour(print.ready_at), hour(print.begins_at)), (1.0, 5.0));
    facts.hindrance = Some(PlanHindrance::Paused);
    let paused = plan_builds(&profile, &facts, at(0.0));
    assert!(paused[0].print.is_some() && paused[1].print.is_none() && paused[1].fires.is_none());
}

/// The cause of the risk of the last part, which is due at this hour, and whether it would be late.
fn cause(profile: &MachineProfile, facts: &PlanFacts, due: f64) -> Option<(RiskCause, bool)> {
    let mut facts = facts.clone();
    let last = facts.lines.last_mut().unwrap();
    let mut part = (*last.part).clone();
    part.terms.due_at = Some(at(due).into());
    last.part = Arc::new(part);
    let builds = plan_builds(profile, &facts, at(0.0));
    let has = |line: &PlanLine| line.part.terms.due_at.is_some_and(|at| at.0 == self::at(due));
    let build = builds.iter().rev().find(|build| build.lines.iter().any(has)).unwrap();
    let first = builds.iter().find(|build| build.fires.is_some());
    let reserve = EndReserve { print_hours: 1.0 };
    let found = outlook_of_coming(profile, &facts, (build, first), reserve, at(due), at(0.0));
    found.map(|outlook| (outlook.cause, outlook.is_late))
}

#[test]
fn a_due_date_at_risk_has_the_cause_that_would_have_to_go() {
    // Without a due date trigger: it fires after ten hours.
    let mut waits = machine("max_wait_secs = \"10h\"\n");
    waits.trigger.due_margin_secs = None;
    let base = facts(&waits, vec![cubes(1, 40, None)]);
    // It prints for 4 hours. The height is an estimate: 15 % more are held back, and an hour.
    assert_eq!(cause(&waits, &base, -1.0), Some((RiskCause::Passed, true)));
    assert_eq!(cause(&waits, &base, 3.0), Some((RiskCause::TooLong, true)));
    assert_eq!(cause(&waits, &base, 5.0), Some((RiskCause::AwaitsFire, true)), "it could be done");
    assert_eq!(cause(&waits, &base, 15.0), Some((RiskCause::AwaitsFire, false)), "one hour is little");
    assert_eq!(cause(&waits, &base, 16.0), None);
    let mut busy = base.clone();
    busy.outlook.printers[0].free_at = at(20.0);
    assert_eq!(cause(&waits, &busy, 23.0), Some((RiskCause::PrinterBusy, true)));
    assert_eq!(cause(&waits, &busy, 12.0), Some((RiskCause::PrinterBusy, true)), "a flush would not help");
    let mut paused = base.clone();
    paused.hindrance = Some(PlanHindrance::Paused);
    assert_eq!(cause(&waits, &paused, 3.0), Some((RiskCause::Paused, true)));
    assert_eq!(cause(&waits, &paused, 30.0), None, "it may be resumed before");
    let closed = machine("max_wait_secs = 0\n[[printer]]\nname = \"m\"\nhours = \"Fri 6-22\"\n");
    let day = facts(&closed, vec![cubes(1, 40, None)]);
    assert_eq!(cause(&closed, &day, 30.0), Some((RiskCause::PrinterClosed, true)));
    let full = facts(&waits, vec![cubes(1, 100, Some(1.0)), cubes(2, 10, None)]);
    assert_eq!(cause(&waits, &full, 10.5), Some((RiskCause::LeftOut, true)));
}

#[test]
fn a_build_that_waits_for_a_yes_or_behind_others_is_named_by_that() {
    let profile = machine("");
    let facts = facts(&profile, Vec::new());
    let made = |free: f64, begins: f64, awaits_release: bool| MadeBuild {
        height_mm: 40.0,
        stage: BuildStage::Queued,
        awaits_release,
        awaits_printer: false,
        free_at: at(free),
        begins_at: at(begins),
        printed_at: at(begins + 3.0),
        ends_at: at(begins + 4.0),
    };
    let reserve = EndReserve { print_hours: 0.5 };
    let cause = |build: &MadeBuild, due: f64| {
        outlook_of_made(&facts, build, reserve, at(due), at(0.0)).map(|outlook| (outlook.cause, outlook.is_late))
    };
    assert_eq!(cause(&made(0.0, 0.0, false), 5.0), None);
    assert_eq!(cause(&made(0.0, 0.0, false), 4.2), Some((RiskCause::TooLong, false)));
    assert_eq!(cause(&made(6.0, 6.0, false), 8.0), Some((RiskCause::PrinterBusy, true)));
    assert_eq!(cause(&made(2.0, 6.0, false), 8.0), Some((RiskCause::PrinterClosed, true)));
    assert_eq!(cause(&made(6.0, 6.0, true), 8.0), Some((RiskCause::AwaitsRelease, true)));
    let never = Timestamp::MAX;
    let down = MadeBuild { awaits_printer: true, begins_at: never, ends_at: never, ..made(0.0, 0.0, false) };
    assert_eq!(cause(&down, 30.0), None, "its printer may be up again before");
    assert_eq!(cause(&down, 4.2), Some((RiskCause::NoPrinter, false)));
    assert_eq!(cause(&down, 3.0), Some((RiskCause::NoPrinter, true)));
}
