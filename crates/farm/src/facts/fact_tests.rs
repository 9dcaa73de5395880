use jiff::Timestamp;
use ledger::{
    AwaitedMaterial, BuildId, BuildState, DownPrinter, MachineStatus, NestingBuild, OccupyingBuild, PauseStatus,
};
use settings::MachineProfile;

use super::{
    machine_fact::{MachineFact, MachineWord, machine_fact},
    printer_fact::{PrinterFact, PrinterWord, printer_fact},
};
use crate::decisions::{
    print_times::PrintTimes,
    printer_choice::{BuildStage, build_spans},
    trigger::tests::machine_with_triggers,
};

/// A Wednesday, and hours after its begin.
pub(super) fn at(hour: f64) -> Timestamp {
    "2026-11-25T00:00:00Z".parse::<Timestamp>().unwrap() + jiff::SignedDuration::from_secs_f64(3600.0 * hour)
}

/// A machine with these printers, in UTC.
fn machine(printers: &[&str]) -> MachineProfile {
    let printers: String = printers.iter().map(|rules| format!("[[printer]]\n{rules}\n")).collect();
    let mut profile = machine_with_triggers(&printers);
    profile.time_zone = jiff::tz::TimeZone::UTC.into();
    profile
}

/// A build of 100 mm that lies in the queue of the printer "left" since midnight.
fn queued(id: i64) -> OccupyingBuild {
    OccupyingBuild {
        build: BuildId(id),
        printer: Some("left".to_owned()),
        state: BuildState::Published,
        height_mm: Some(100.0),
        published_at: Some(at(0.0).into()),
        begun_at: None,
    }
}

fn taken(id: i64, hour: f64) -> OccupyingBuild {
    OccupyingBuild { begun_at: Some(at(hour).into()), ..queued(id) }
}

fn told(id: i64, hour: f64) -> OccupyingBuild {
    OccupyingBuild { state: BuildState::Printing, ..taken(id, hour) }
}

fn made(id: i64) -> OccupyingBuild {
    OccupyingBuild { state: BuildState::Nesting, published_at: None, ..queued(id) }
}

/// What is so of each printer. 100 mm are printed in ten hours, and cool for four.
fn facts(profile: &MachineProfile, builds: &[OccupyingBuild], down: &[&str], now: f64) -> Vec<PrinterFact> {
    let times = PrintTimes { hours_per_mm: 0.1, cool_down_hours: 4.0, learned_from: 0 };
    let spans = build_spans(profile, builds, &times, |printer| down.contains(&printer), at(now));
    let down_printer = |name: &str| DownPrinter {
        printer: name.to_owned(),
        machine: profile.name.clone(),
        reason: "its laser".to_owned(),
        told_by: "ann@farm".to_owned(),
        down_at: at(0.0).into(),
    };
    let fact = |rules: &settings::PrinterRules| {
        let down = down.contains(&rules.name.as_str()).then(|| down_printer(&rules.name));
        printer_fact(profile, rules, &spans[&rules.name], down, &times, at(now))
    };
    profile.printers.iter().map(fact).collect()
}

#[test]
fn of_a_printer_that_is_down_nobody_knows_when_it_begins_what_it_has_not_begun() {
    let profile = machine(&["name = \"left\""]);
    let waits = facts(&profile, &[queued(1)], &["left"], 1.0).remove(0);
    assert_eq!(
        (waits.state, waits.build, waits.until, waits.free_at),
        (PrinterWord::Down, Some(BuildId(1)), None, None)
    );
    let prints = facts(&profile, &[told(1, 1.0), queued(2)], &["left"], 2.0).remove(0);
    assert_eq!((prints.build, prints.until), (Some(BuildId(1)), Some(at(11.0).into())), "what it had begun goes on");
}

#[test]
fn what_lies_in_a_printer_behind_another_print_is_no_more_in_its_queue() {
    let (profile, times) =
        (machine(&["name = \"left\""]), PrintTimes { hours_per_mm: 0.1, cool_down_hours: 4.0, learned_from: 0 });
    let spans = build_spans(&profile, &[taken(1, 1.0), taken(2, 2.0), queued(3)], &times, |_| false, at(3.0));
    let stages: Vec<BuildStage> = spans["left"].iter().map(|span| span.stage(at(3.0))).collect();
    assert_eq!(stages, [BuildStage::Printing, BuildStage::Taken, BuildStage::Queued]);
}

fn one(builds: &[OccupyingBuild], now: f64) -> PrinterFact {
    facts(&machine(&["name = \"left\""]), builds, &[], now).remove(0)
}

#[test]
fn a_printer_prints_cools_and_should_be_done_until_somebody_tells() {
    let steps = [
        (vec![], 1.0, PrinterWord::Free, "free now"),
        (vec![made(1)], 1.0, PrinterWord::Expecting, "build 1 is made for it, free from about today 15:00"),
        (vec![queued(1)], 1.0, PrinterWord::Queued, "build 1 lies in its queue, free from about today 15:00"),
        (
            vec![taken(1, 1.0), queued(2)],
            2.0,
            PrinterWord::Printing,
            "printing build 1 until about today 11:00 (estimated), then 1 more build, free from about tomorrow 05:00",
        ),
        (
            vec![told(1, 1.0)],
            2.0,
            PrinterWord::Printing,
            "printing build 1 until about today 11:00, free from about today 15:00",
        ),
        (
            vec![taken(1, 1.0)],
            12.0,
            PrinterWord::Cooling,
            "cooling build 1 until about today 15:00 (estimated), free from about today 15:00",
        ),
        (
            vec![taken(1, 1.0)],
            40.0,
            PrinterWord::Ended,
            "build 1 should be done since about yesterday 15:00: nobody told how it printed",
        ),
        (
            vec![told(1, 1.0), queued(2)],
            16.0,
            PrinterWord::Ended,
            "build 1 should be done since about today 15:00: nobody told how it printed, then 1 more build",
        ),
        // It took the next file: the first one is over.
        (
            vec![taken(1, 1.0), taken(2, 15.0)],
            16.0,
            PrinterWord::Printing,
            "printing build 2 until about tomorrow 01:00 (estimated), free from about tomorrow 05:00",
        ),
    ];
    for (builds, now, word, text) in steps {
        let fact = one(&builds, now);
        assert_eq!((fact.state, fact.doing.as_str()), (word, text));
    }
}

#[test]
fn a_printer_that_took_a_file_is_never_free_until_its_outcome_is_told() {
    for hour in 0..20 * 24 {
        let fact = one(&[taken(1, 0.0)], f64::from(hour));
        assert!(fact.state != PrinterWord::Free && !fact.doing.contains("free now"), "{hour} h: {fact:?}");
    }
}

#[test]
fn a_printer_is_free_in_its_hours_and_one_that_is_down_says_why() {
    let closed = machine(&["name = \"left\"\nhours = \"Mon-Fri 6-22\""]);
    let fact = facts(&closed, &[], &[], 3.0).remove(0);
    assert_eq!((fact.state, fact.doing.as_str()), (PrinterWord::Closed, "closed until today 06:00"));
    assert_eq!((fact.until, fact.free_at), (Some(at(6.0).into()), Some(at(6.0).into())));
    assert_eq!(facts(&closed, &[], &[], 7.0).remove(0).state, PrinterWord::Free);
    let goes_on = facts(&closed, &[taken(1, 1.0)], &[], 3.0).remove(0);
    assert_eq!(goes_on.state, PrinterWord::Printing, "a print goes on at any time");
    let never = machine(&["name = \"left\"\ndays_off = [\"2026-01-01..2040-01-01\"]"]);
    let fact = facts(&never, &[], &[], 3.0).remove(0);
    assert_eq!((fact.state, fact.doing.as_str()), (PrinterWord::Closed, "its calendar is not open again"));
    let down = facts(&machine(&["name = \"left\""]), &[taken(1, 1.0)], &["left"], 3.0).remove(0);
    assert_eq!((down.state, down.free_at), (PrinterWord::Down, None));
    assert_eq!(down.doing, "down since today 00:00 by ann@farm: its laser");
}

fn waiting(machine: &str) -> MachineStatus {
    MachineStatus {
        machine: machine.to_owned(),
        waiting_parts: 1,
        waiting_copies: 3,
        collecting_copies: 3,
        ..MachineStatus::default()
    }
}

#[test]
fn a_machine_that_is_closed_says_until_when_unless_a_printer_of_it_is_free() {
    let hours = ["name = \"left\"\nhours = \"Mon-Fri 6-22\"", "name = \"right\"\nhours = \"Mon-Fri 2-22\""];
    let said = |printers: &[&str], hour: f64, status: &MachineStatus| {
        let profile = machine(printers);
        let fact = machine_fact(status, None, facts(&profile, &[], &[], hour), &[]);
        (fact.state, fact.doing)
    };
    let (nothing, three) = (MachineStatus::default(), waiting("m"));
    let closed = "closed until today 06:00".to_owned();
    assert_eq!(said(&hours[..1], 1.0, &nothing), (MachineWord::Closed, closed.clone()));
    assert_eq!(said(&hours[..1], 1.0, &three), (MachineWord::Collecting, closed + "; collecting 3 copies"));
    let both = "left: closed until today 06:00; right: closed until today 02:00".to_owned();
    assert_eq!(said(&hours, 1.0, &nothing), (MachineWord::Closed, both));
    let one = "left: closed until today 06:00; right: free now".to_owned();
    assert_eq!(said(&hours, 3.0, &nothing), (MachineWord::Free, one));
}

#[test]
fn a_proved_build_waits_for_a_yes_and_what_is_asked_is_not_collected() {
    let profile = machine(&["name = \"left\""]);
    let build = NestingBuild {
        build: BuildId(4),
        state: BuildState::Verified,
        copies: 12,
        fired_by: "full".to_owned(),
        attempts: 1,
        nesting_at: None,
    };
    let status = MachineStatus { nesting: vec![build], collecting_copies: 2, asked_copies: 1, ..waiting("m") };
    let said = |awaiting: &[BuildId]| {
        let fact = machine_fact(&status, None, facts(&profile, &[], &[], 3.0), awaiting);
        (fact.state, fact.doing)
    };
    let rest = "collecting 2 copies; 1 copy waits for an answer";
    assert_eq!(said(&[]), (MachineWord::Nesting, format!("build 4 is proved (12 copies); {rest}")));
    let yes = format!("build 4 waits for a yes (12 copies); {rest}");
    assert_eq!(said(&[BuildId(4)]), (MachineWord::AwaitsYes, yes));
}

#[test]
fn a_machine_says_what_is_most_urgent_first_and_all_that_is_so() {
    let profile = machine(&["name = \"left\"", "name = \"right\""]);
    let machine_of = |status: &MachineStatus, builds: &[OccupyingBuild], down: &[&str]| -> MachineFact {
        machine_fact(status, None, facts(&profile, builds, down, 2.0), &[])
    };
    let status = waiting(&profile.name);
    let idle = machine_of(&MachineStatus::default(), &[], &[]);
    assert_eq!((idle.state, idle.doing.as_str(), idle.free_at), (MachineWord::Free, "free now", Some(at(2.0).into())));
    let collecting = machine_of(&status, &[], &[]);
    assert_eq!((collecting.state, collecting.doing.as_str()), (MachineWord::Collecting, "collecting 3 copies"));
    let awaiting = vec![AwaitedMaterial { material: "PA11".to_owned(), parts: 1, copies: 3 }];
    let awaiting = machine_of(&MachineStatus { awaiting, collecting_copies: 0, ..status.clone() }, &[], &[]);
    assert_eq!((awaiting.state, awaiting.doing.as_str()), (MachineWord::Free, "3 copies wait for PA11"));
    let printing = machine_of(&status, &[taken(1, 1.0)], &[]);
    assert_eq!(printing.state, MachineWord::Printing);
    assert_eq!(
        printing.doing,
        "left: printing build 1 until about today 11:00 (estimated), free from about today 15:00; right: free now; collecting 3 copies"
    );
    assert_eq!(printing.free_at, Some(at(2.0).into()), "the other one is free");
    let nesting = NestingBuild {
        build: BuildId(4),
        state: BuildState::Nesting,
        copies: 12,
        fired_by: "full".to_owned(),
        attempts: 1,
        nesting_at: None,
    };
    let busy = MachineStatus { nesting: vec![nesting], ..status.clone() };
    let busy = machine_of(&busy, &[], &[]);
    assert_eq!(
        (busy.state, busy.doing.as_str()),
        (MachineWord::Nesting, "build 4 is being searched (12 copies); collecting 3 copies")
    );
    let cause = ledger::PauseCause::Person;
    let paused = PauseStatus { paused_by: "ben@farm".to_owned(), cause, paused_at: at(1.0).into() };
    let paused = machine_of(&MachineStatus { paused: Some(paused), ..status.clone() }, &[taken(1, 1.0)], &[]);
    assert_eq!(paused.state, MachineWord::Paused);
    assert!(paused.doing.starts_with("paused by ben@farm; left: printing"), "{}", paused.doing);
    let down = machine_of(&status, &[], &["left", "right"]);
    assert_eq!((down.state, down.free_at), (MachineWord::Down, None));
}
