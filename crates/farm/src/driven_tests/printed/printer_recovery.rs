//! Several printers after a crash, a restored ledger, or an outcome that was told in between: no build is printed twice, and
//! none is left where no printer sees it.

use std::{fs, path::Path, sync::Arc};

use delivery::queue::{OpenQueue, PrinterQueue, QueueFolder};
use ledger::{
    BuildRow, BuildState, CommandKind, LedgerError, OperatorWord, PartId, PartState, PrintOutcome, PrinterPlace,
    ToldOutcome,
};
use ledger_fixtures::ToldWords;

use super::printers::{bring_up, build_part, published, queue, take_down, two_printers, visible};
use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block, hand_driven_farm::farm_files::list_build_files},
    scanning::queue_files::QueueFileLook,
};

fn open_queue(farm: &HandDrivenFarm, printer: &str) -> QueueFolder {
    QueueFolder::open(queue(farm, printer)).unwrap()
}

/// One build that is published on the left.
fn one_build() -> (HandDrivenFarm, BuildRow, String) {
    let mut farm = two_printers("");
    build_part(&mut farm, "a.stl", 20.0);
    let build = published(&farm).remove(0);
    let file = build.staged.file_name.clone().unwrap();
    assert_eq!(visible(&farm), [1, 0]);
    (farm, build, file)
}

fn verified(farm: &HandDrivenFarm) -> Vec<BuildRow> {
    farm.ask(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap())
}

fn tell_failed(farm: &HandDrivenFarm, build: &BuildRow) {
    let told = ToldOutcome::new(PrintOutcome::Failed, "", "a@test");
    farm.ask(async |ledger| ledger.record_outcome(build.id, &told).await.unwrap());
}

/// Takes the file back on the left, stages it on the right and records that, as the farm does.
fn stage_on_the_right(farm: &HandDrivenFarm, build: &BuildRow, file: &str) {
    let [left, right] = ["left", "right"].map(|printer| open_queue(farm, printer));
    farm.ask(async |ledger| {
        ledger.begin_move(build.id, "right").await.unwrap();
        left.take_back(file, &|_| Ok(true)).unwrap();
        right.stage_taken_back(&left, file).unwrap();
        ledger.record_move(build.id, "right", right.id()).await.unwrap();
        left.remove_taken_back(file).unwrap();
    });
}

/// A daemon that was killed, and starts after somebody told that the print failed.
fn start_after_failure(farm: &mut HandDrivenFarm, build: &BuildRow) {
    tell_failed(farm, build);
    farm.stop();
    farm.start();
}

fn wait_for_end_of_move(farm: &mut HandDrivenFarm, build: &BuildRow) {
    farm.pass_until("the move has ended", |farm| {
        farm.ask(async |ledger| ledger.find_build(build.id).await.unwrap().unwrap()).place.move_to.is_none()
    });
}

#[test]
fn a_build_that_a_restored_ledger_takes_for_unpublished_is_not_made_for_another_printer() {
    let mut farm = two_printers("approve = \"always\"\n");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.pass_until("it waits for a yes", |farm| farm.has_alert(AlertKind::ReleaseDue));
    let backup = farm.write_backup("before.db");
    let build = verified(&farm).remove(0);
    assert_eq!(build.place.printer.as_deref(), Some("left"));
    release(&farm, &build);
    farm.pass_until("it is published", |farm| visible(farm) == [1, 0]);
    farm.pass_secs(2.0);
    farm.stop();
    // The printer takes it, and then the ledger is put back.
    fs::remove_file(&list_build_files(&queue(&farm, "left"))[0]).unwrap();
    let restored = farm.restore(&backup);
    assert!(restored.doubts.iter().any(|doubt| doubt.contains("`nestd printer NAME down` again")), "{restored:?}");
    farm.start();
    assert_eq!(verified(&farm).len(), 1);
    take_down(&farm, "left");
    farm.pass_secs(30.0);
    assert_eq!(verified(&farm), [], "it is not proposed for another printer");
    let now = published(&farm).remove(0);
    assert_eq!((now.id, now.place.printer.as_deref(), visible(&farm)), (build.id, Some("left"), [0, 0]));
    farm.assert_ledger_agrees_with_folders();
}

fn release(farm: &HandDrivenFarm, build: &BuildRow) {
    farm.say(&OperatorWord::Release { build: build.id, seen: None }, false).unwrap();
}

#[test]
fn a_file_that_was_taken_back_and_belongs_to_no_move_gets_into_a_queue_again() {
    let (mut farm, build, file) = one_build();
    // As after a crash in a move that a restored ledger does not know.
    farm.stop();
    let left = open_queue(&farm, "left");
    left.take_back(&file, &|_| Ok(true)).unwrap();
    farm.start();
    farm.pass_until("a printer can take it", |farm| visible(farm) == [1, 0]);
    wait_for_end_of_move(&mut farm, &build);
    assert!(!left.withdrawn_path(&file).exists());
    farm.assert_ledger_agrees_with_folders();
    // It had been moved to the other printer before it was taken back there.
    farm.stop();
    let right = open_queue(&farm, "right");
    left.take_back(&file, &|_| Ok(true)).unwrap();
    for entry in fs::read_dir(left.folder_path()).unwrap().map(Result::unwrap) {
        if entry.file_name().to_str().unwrap().ends_with(".moving") {
            fs::rename(entry.path(), right.folder_path().join(entry.file_name())).unwrap();
        }
    }
    farm.start();
    farm.pass_until("a printer can take it", |farm| visible(farm).iter().sum::<usize>() == 1);
    wait_for_end_of_move(&mut farm, &build);
    assert!(!right.withdrawn_path(&file).exists());
    assert_eq!(published(&farm)[0].place.taken_at, None);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_file_that_lies_at_another_printer_than_the_ledger_says_was_not_taken() {
    let (mut farm, _, file) = one_build();
    farm.stop();
    let (left, right) = (open_queue(&farm, "left"), open_queue(&farm, "right"));
    fs::rename(left.published_path(&file), right.published_path(&file)).unwrap();
    farm.start();
    farm.pass_secs(10.0);
    let now = published(&farm).remove(0);
    assert_eq!((now.place.printer.as_deref(), now.place.taken_at), (Some("right"), None));
    take_down(&farm, "right");
    farm.pass_until("it is moved", |farm| visible(farm) == [1, 0]);
}

#[test]
fn a_build_whose_failure_was_told_after_it_became_visible_at_the_other_printer_is_taken_back_there() {
    let (mut farm, build, file) = one_build();
    stage_on_the_right(&farm, &build, &file);
    open_queue(&farm, "right").publish(&file).unwrap();
    start_after_failure(&mut farm, &build);
    wait_for_end_of_move(&mut farm, &build);
    assert_eq!(visible(&farm), [0, 0], "its copies wait again");
    assert!(!farm.has_alert(AlertKind::PublishingFails));
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_person_learns_that_the_other_printer_took_a_build_whose_failure_was_told() {
    for outcome in [PrintOutcome::Failed, PrintOutcome::Complete] {
        let (mut farm, build, file) = one_build();
        stage_on_the_right(&farm, &build, &file);
        let right = open_queue(&farm, "right");
        right.publish(&file).unwrap();
        fs::remove_file(right.published_path(&file)).unwrap();
        start_after_failure(&mut farm, &build);
        wait_for_end_of_move(&mut farm, &build);
        let is_told = |farm: &HandDrivenFarm| farm.alert_text(AlertKind::NotTakenBack).contains("which has taken it");
        farm.pass_until("it is told", is_told);
        assert!(!farm.has_alert(AlertKind::PublishingFails), "{}", farm.status_text());
        let now = farm.ask(async |ledger| ledger.find_build(build.id).await.unwrap().unwrap());
        assert!(now.place.printer.as_deref() == Some("right") && now.place.taken_at.is_some(), "{:?}", now.place);
        farm.pass_secs(5.0);
        assert!(is_told(&farm), "nobody has looked yet");
        let told = ToldOutcome { is_correction: true, ..ToldOutcome::new(outcome, "", "a@test") };
        farm.ask(async |ledger| ledger.record_outcome(build.id, &told).await.unwrap());
        farm.pass_until("it is over", |farm| !is_told(farm));
    }
}

#[test]
fn what_the_ledger_does_not_know_of_one_folder_is_not_settled_by_its_absence() {
    let (mut farm, _, file) = one_build();
    let (right, away) = (queue(&farm, "right"), farm.root().join("away"));
    fs::rename(&right, &away).unwrap();
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueAway));
    let unknown = away.join(file.replace("000001", "000099"));
    assert_ne!(unknown.file_name(), Path::new(&file).file_name());
    fs::copy(queue(&farm, "left").join(&file), &unknown).unwrap();
    fs::rename(&away, &right).unwrap();
    farm.pass_until("the ledger is behind", |farm| farm.has_alert(AlertKind::LedgerBehind));
    fs::rename(&right, &away).unwrap();
    farm.pass_secs(20.0);
    assert!(farm.has_alert(AlertKind::LedgerBehind), "{MACHINE} may not claim before it is settled");
    fs::remove_file(&unknown).unwrap();
    fs::rename(&away, &right).unwrap();
    farm.pass_until("it is settled", |farm| !farm.has_alert(AlertKind::LedgerBehind));
}

#[test]
fn a_person_learns_that_a_file_that_was_taken_back_has_no_printer_to_go_to() {
    let (mut farm, build, file) = one_build();
    farm.ask(async |ledger| ledger.begin_move(build.id, "right").await.unwrap());
    open_queue(&farm, "left").take_back(&file, &|_| Ok(true)).unwrap();
    take_down(&farm, "left");
    take_down(&farm, "right");
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::PublishingFails));
    assert!(farm.status_text().contains("No printer is in use"));
    bring_up(&farm, "right");
    farm.pass_until("it is published", |farm| visible(farm) == [0, 1]);
    farm.pass_until("it is settled", |farm| !farm.has_alert(AlertKind::PublishingFails));
    farm.assert_ledger_agrees_with_folders();
}

/// The machine goes on without its left printer.
fn remove_left(farm: &mut HandDrivenFarm) {
    farm.write_profile(MACHINE, &format!("{QUICK}orientation = \"fixed\"\n[[printer]]\nname = \"right\"\n"));
    farm.reload();
}

#[test]
fn a_person_learns_that_builds_lie_at_a_printer_that_is_configured_no_more() {
    let (mut farm, build, _) = one_build();
    remove_left(&mut farm);
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::QueueReplaced));
    tell_failed(&farm, &build);
    farm.pass_until("it is settled", |farm| !farm.has_alert(AlertKind::QueueReplaced));
}

#[test]
fn a_move_from_a_printer_that_is_configured_no_more_ends_when_the_outcome_is_told() {
    let (mut farm, build, file) = one_build();
    farm.ask(async |ledger| ledger.begin_move(build.id, "right").await.unwrap());
    let left = open_queue(&farm, "left");
    left.take_back(&file, &|_| Ok(true)).unwrap();
    remove_left(&mut farm);
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::PublishingFails));
    assert!(left.withdrawn_path(&file).exists() && visible(&farm) == [0, 0]);
    tell_failed(&farm, &build);
    wait_for_end_of_move(&mut farm, &build);
    farm.pass_until("it is settled", |farm| !farm.has_alert(AlertKind::PublishingFails));
}

#[test]
fn a_build_whose_failure_was_told_while_its_file_had_no_printer_to_go_to_never_counts_as_printed() {
    let (mut farm, build, file) = one_build();
    farm.ask(async |ledger| ledger.begin_move(build.id, "right").await.unwrap());
    open_queue(&farm, "left").take_back(&file, &|_| Ok(true)).unwrap();
    take_down(&farm, "left");
    take_down(&farm, "right");
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::PublishingFails));
    let told = |outcome, is_correction| {
        let told = ToldOutcome { is_correction, ..ToldOutcome::new(outcome, "", "a@test") };
        OperatorWord::Outcome(build.id, told)
    };
    farm.say(&told(PrintOutcome::Failed, false), false).unwrap();
    wait_for_end_of_move(&mut farm, &build);
    let refused = farm.say(&told(PrintOutcome::Complete, true), true);
    assert!(matches!(refused, Err(LedgerError::TakenBack(_))), "{refused:?}");
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_word_about_a_file_that_lies_at_another_printer_is_told_and_holds_when_it_is_said_once_more() {
    for outcome in [PrintOutcome::Failed, PrintOutcome::Interrupted] {
        let (mut farm, build, file) = one_build();
        let bad = if outcome == PrintOutcome::Failed { Vec::new() } else { vec![(PartId(1), 1)] };
        let word = OperatorWord::Outcome(build.id, ToldOutcome { bad, ..ToldOutcome::new(outcome, "", "a@test") });
        farm.say(&word, true).unwrap();
        fs::rename(queue(&farm, "left").join(&file), queue(&farm, "right").join(&file)).unwrap();
        farm.pass_until("it is told", |farm| farm.alert_text(AlertKind::NotTakenBack).contains("it lies at right"));
        assert_eq!((visible(&farm), farm.parts(PartState::Waiting).len()), ([0, 1], 0));
        farm.say(&word, true).unwrap();
        farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::NotTakenBack));
        farm.wait_for_parts(PartState::Waiting, 1);
        assert_eq!(visible(&farm), [0, 0]);
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_file_that_is_moved_to_another_printer_while_a_word_waits_for_it_is_no_second_file() {
    let (farm, build, file) = one_build();
    let queues =
        ["left", "right"].map(|printer| (printer.to_owned(), Arc::new(open_queue(&farm, printer)) as OpenQueue));
    let at = |printer: &str| queue(&farm, printer).join(&file);
    let noted = BuildRow {
        place: PrinterPlace { withdraw_by: Some("a@test".to_owned()), ..build.place.clone() },
        ..build.clone()
    };
    let second = || {
        let look = QueueFileLook {
            profile: &farm.profiles()[MACHINE],
            queues: &queues,
            find_build: &|_| Ok(Some(noted.clone())),
            has_bad_copies: &|_| Ok(false),
            second_files: &|_| Ok(Vec::new()),
            copied: &[],
        };
        look.look().unwrap().second.into_iter().map(|(_, place)| place).collect::<Vec<_>>()
    };
    fs::rename(at("left"), at("right")).unwrap();
    assert_eq!(second(), [""; 0]);
    fs::copy(at("right"), at("left")).unwrap();
    assert_eq!(second(), [format!("{file} at right")]);
    open_queue(&farm, "left").take_back(&file, &|_| Ok(true)).unwrap();
    assert_eq!(second(), [format!("{file} at right")], "the other one is on its way");
}
