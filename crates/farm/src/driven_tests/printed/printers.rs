//! Printers alike behind one hot folder: both are kept busy, one that is down gets nothing, and what lies at it moves to the
//! other. And builds that wait for a person's yes.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use delivery::queue::{PrinterQueue, QueueFolder};
use ledger::{BuildRow, BuildState, CommandKind, EventKind, OperatorWord, PartState};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{
        HandDrivenFarm, MACHINE, QUICK, block,
        hand_driven_farm::farm_files::{assert_each_copy_once, list_build_files},
    },
    preview_release,
};

const PRINTERS: &str = "[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\n";

pub(super) fn two_printers(options: &str) -> HandDrivenFarm {
    HandDrivenFarm::open(&format!("{QUICK}orientation = \"fixed\"\n{options}{PRINTERS}"))
}

pub(crate) fn queue(farm: &HandDrivenFarm, printer: &str) -> PathBuf {
    farm.folder_of("queue", printer)
}

/// Builds that printers can see: on the left and on the right.
pub(crate) fn visible(farm: &HandDrivenFarm) -> [usize; 2] {
    ["left", "right"].map(|printer| list_build_files(&queue(farm, printer)).len())
}

/// Drops a part and has it built.
pub(crate) fn build_part(farm: &mut HandDrivenFarm, name: &str, height_mm: f64) {
    let built = farm.parts(PartState::Built).len();
    farm.drop_part(name, &block(20.0, 20.0, height_mm));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, built + 1);
}

pub(crate) fn take_down(farm: &HandDrivenFarm, printer: &str) {
    let (machine, printer, reason) = (MACHINE.to_owned(), printer.to_owned(), "its lamp".to_owned());
    farm.say(&OperatorWord::PrinterDown { machine, printer, reason }, false).unwrap();
}

pub(crate) fn bring_up(farm: &HandDrivenFarm, printer: &str) {
    let word = OperatorWord::PrinterUp { machine: MACHINE.to_owned(), printer: printer.to_owned() };
    assert!(farm.say(&word, false).unwrap().sentences[0].ends_with("takes builds again."));
}

pub(crate) fn published(farm: &HandDrivenFarm) -> Vec<BuildRow> {
    farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap())
}

fn names_in(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn two_printers_alike_are_both_kept_busy() {
    let mut farm = two_printers("");
    for number in 0..4 {
        build_part(&mut farm, &format!("{number}.stl"), 20.0);
        let [left, right] = visible(&farm);
        assert!(left.abs_diff(right) <= 1, "after {number}: {left} and {right}");
    }
    // A tall build occupies its printer for longer than two low ones do the other.
    build_part(&mut farm, "tall.stl", 100.0);
    build_part(&mut farm, "low.stl", 20.0);
    build_part(&mut farm, "flat.stl", 10.0);
    let at = |name: &str| {
        let part = farm.parts(PartState::Built).into_iter().find(|part| part.name == name).unwrap();
        let placed = farm.ask(async |ledger| ledger.placements_of_part(part.id).await.unwrap());
        let build = farm.ask(async |ledger| ledger.find_build(placed[0].build_id).await.unwrap().unwrap());
        build.place.printer.unwrap()
    };
    assert!(at("low.stl") == at("flat.stl") && at("tall.stl") != at("low.stl"));
    let all = [list_build_files(&queue(&farm, "left")), list_build_files(&queue(&farm, "right"))].concat();
    assert_each_copy_once(&all, 7);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_printer_that_is_down_gets_nothing_and_without_any_nothing_is_fired() {
    let mut farm = two_printers("");
    take_down(&farm, "left");
    for number in 0..3 {
        build_part(&mut farm, &format!("{number}.stl"), 20.0);
    }
    assert_eq!(visible(&farm), [0, 3]);
    take_down(&farm, "right");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let refused = farm.order_and_wait(CommandKind::Flush, None);
    assert!(refused.answer.contains("`nestd printer left up`"), "{}", refused.answer);
    farm.pass_secs(60.0);
    assert_eq!((visible(&farm), farm.parts(PartState::Waiting).len()), ([0, 3], 1));
    let text = farm.status_text();
    assert!(text.contains("No printer is in use: nothing is fired."), "{text}");
    assert!(text.contains("left: down since") && text.contains("by ann@farm: its lamp;"), "{text}");
    bring_up(&farm, "left");
    farm.tick();
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 4);
    farm.pass_until("all of it is at the printer that is in use", |farm| visible(farm) == [4, 0]);
    assert_eq!(farm.status_json()["printers"][1]["down"]["reason"], "its lamp");
}

#[test]
fn a_build_in_the_queue_of_a_printer_that_went_down_goes_to_the_other_and_comes_back() {
    let mut farm = two_printers("");
    build_part(&mut farm, "a.stl", 20.0);
    assert_eq!(visible(&farm), [1, 0]);
    let files = names_in(&queue(&farm, "left"));
    for (from, to, seen) in [("left", "right", [0, 1]), ("right", "left", [1, 0])] {
        take_down(&farm, from);
        farm.pass_until("the build is moved", |farm| visible(farm) == seen);
        farm.pass_until("it is recorded", |farm| published(farm)[0].place.printer.as_deref() == Some(to));
        assert_eq!(names_in(&queue(&farm, to)), files, "with all that belongs to it");
        assert!(names_in(&queue(&farm, from)).iter().all(|name| name.starts_with(".nestd-")), "nothing stays");
        farm.assert_ledger_agrees_with_folders();
        bring_up(&farm, from);
    }
    let build = published(&farm).remove(0);
    let events = farm.ask(async |ledger| ledger.events_of_build(build.id).await.unwrap());
    let moves: Vec<&str> =
        events.iter().filter(|event| event.kind == EventKind::Relocated).map(|event| event.detail.as_str()).collect();
    assert_eq!(moves, ["from left to right", "from right to left"]);
    farm.stop();
    farm.start();
    assert_eq!(visible(&farm), [1, 0]);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn what_its_printer_took_is_not_said_to_lie_in_a_queue_and_its_place_is_that_of_its_printer() {
    let mut farm = two_printers("");
    build_part(&mut farm, "a.stl", 20.0);
    take_down(&farm, "left");
    farm.pass_until("the build is moved", |farm| visible(farm) == [0, 1]);
    for file in list_build_files(&queue(&farm, "right")) {
        fs::remove_file(file).unwrap();
    }
    farm.pass_until("it is seen", |farm| published(farm)[0].place.taken_at.is_some());
    let build = published(&farm).remove(0);
    let profile = farm.profiles()[MACHINE].clone();
    let file = crate::locate_build_file(&profile, &build).unwrap();
    assert_eq!(file.parent().unwrap(), queue(&farm, "right"), "{}", file.display());
    // Of a machine that is configured no more, nobody makes a plan.
    let history = farm.ask(async |ledger| ledger.read_history(&ledger::HistoryQuery::default()).await.unwrap());
    let dated = farm.ask(async |ledger| {
        crate::DatedBuild::of_rows(ledger, [], history.clone(), jiff::Timestamp::now()).await.unwrap()
    });
    assert_eq!(
        (crate::build_fact(&build, &[]).word, &*dated[0].fact.word),
        ("at the printer".to_owned(), "at the printer")
    );
}

#[test]
fn a_build_that_its_printer_took_stays_with_it() {
    let mut farm = two_printers("");
    build_part(&mut farm, "a.stl", 20.0);
    fs::remove_file(&list_build_files(&queue(&farm, "left"))[0]).unwrap();
    take_down(&farm, "left");
    farm.pass_secs(30.0);
    let build = published(&farm).remove(0);
    assert_eq!((build.place.printer.as_deref(), build.place.move_to.as_deref()), (Some("left"), None));
    assert!(build.place.taken_at.is_some() && visible(&farm) == [0, 0]);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_build_that_was_told_while_it_moves_is_published_nowhere() {
    let mut farm = two_printers("");
    build_part(&mut farm, "a.stl", 20.0);
    let build = published(&farm).remove(0);
    // As after a crash: the file was taken back, and then somebody told that the print failed.
    farm.stop();
    let file = build.staged.file_name.clone().unwrap();
    let folder = QueueFolder::open(queue(&farm, "left")).unwrap();
    folder.take_back(&file, &|_| Ok(true)).unwrap();
    farm.start();
    farm.ask(async |ledger| ledger.begin_move(build.id, "right").await.unwrap());
    let told = ledger::ToldOutcome::new(ledger::PrintOutcome::Failed, "", "a@test");
    farm.ask(async |ledger| ledger.record_outcome(build.id, &told).await.unwrap());
    farm.pass_until("the move has ended", |farm| {
        farm.ask(async |ledger| ledger.find_build(build.id).await.unwrap().unwrap()).place.move_to.is_none()
    });
    assert_eq!(visible(&farm), [0, 0]);
    assert!(!folder.withdrawn_path(&file).exists());
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn the_queue_folder_of_one_printer_that_is_away_does_not_keep_the_other_from_printing() {
    let mut farm = two_printers("");
    build_part(&mut farm, "a.stl", 20.0);
    let away = farm.root().join("away");
    fs::rename(queue(&farm, "right"), &away).unwrap();
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueAway));
    build_part(&mut farm, "b.stl", 20.0);
    assert_eq!(visible(&farm), [2, 0]);
    fs::rename(&away, queue(&farm, "right")).unwrap();
    farm.pass_until("it is there again", |farm| !farm.has_alert(AlertKind::QueueAway));
    farm.pass_secs(5.0);
    build_part(&mut farm, "c.stl", 20.0);
    assert_eq!(visible(&farm), [2, 1]);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_machine_that_gets_a_second_printer_goes_on_with_what_lies_in_its_queue() {
    let mut farm = HandDrivenFarm::open(QUICK);
    build_part(&mut farm, "a.stl", 20.0);
    assert_eq!(published(&farm)[0].place.printer.as_deref(), Some(MACHINE));
    let printers = "[[printer]]\nname = \"left\"\nqueue = \"queue/test\"\n[[printer]]\nname = \"right\"\n";
    farm.write_profile(MACHINE, &format!("{QUICK}{printers}"));
    farm.reload();
    farm.pass_secs(5.0);
    build_part(&mut farm, "b.stl", 20.0);
    let seen = |farm: &HandDrivenFarm| [farm.queued().len(), list_build_files(&queue(farm, "right")).len()];
    assert_eq!(seen(&farm).iter().sum::<usize>(), 2);
    farm.assert_ledger_agrees_with_folders();
    // What was published under the name of the machine lies at the printer that has its folder now.
    take_down(&farm, "left");
    farm.pass_until("all of it is at the other one", |farm| seen(farm) == [0, 2]);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_thin_build_waits_for_a_yes_and_goes_to_the_printer_that_is_up_then() {
    let mut farm = two_printers("approve = \"thin\"\nthin = 0.5\n");
    build_part(&mut farm, "tall.stl", 80.0);
    assert!(!farm.has_alert(AlertKind::ReleaseDue), "80 of 120 mm is not thin");
    let ticket = "due = 2026-01-01\n";
    fs::write(farm.folder("inbox").join("low.stl.toml"), ticket).unwrap();
    farm.drop_part("low.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.pass_until("it waits for a yes", |farm| farm.has_alert(AlertKind::ReleaseDue));
    farm.pass_secs(30.0);
    assert_eq!(visible(&farm).iter().sum::<usize>(), 1);
    let verified = |farm: &HandDrivenFarm| {
        farm.ask(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap()).pop()
    };
    let build = verified(&farm).unwrap();
    let (profile, now) = (farm.profiles()[MACHINE].clone(), farm.date());
    let preview = farm.ask(async |ledger| preview_release(ledger, &profile, &build, now).await.unwrap());
    assert!(preview.awaits_release && preview.copies == 1, "{preview:?}");
    assert!((preview.height_mm - 20.0).abs() < 1e-3 && (preview.print_hours - 2.0).abs() < 1e-3, "{preview:?}");
    assert_eq!((preview.late.len(), preview.late[0].name.as_str()), (1, "low.stl"));
    assert_eq!(build.place.printer.as_deref(), Some("right"));
    // Its printer goes down before it was published: it is made for the other one, and still waits.
    take_down(&farm, "right");
    farm.pass_until("it is made for the other printer", |farm| {
        verified(farm).is_some_and(|build| build.place.printer.as_deref() == Some("left"))
    });
    farm.pass_secs(10.0);
    assert_eq!(visible(&farm), [1, 0]);
    farm.say(&OperatorWord::Release { build: build.id, seen: None }, false).unwrap();
    farm.pass_until("it is published", |farm| visible(farm) == [2, 0]);
    farm.pass_until("nobody is asked any more", |farm| !farm.has_alert(AlertKind::ReleaseDue));
    farm.assert_ledger_agrees_with_folders();
}
