//! Words that come late: tickets and lists after their part, revisions, control files, and parts that wait for a yes.

use std::fs;

use ledger::{CommandKind, CommandState, PartState};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, QUICK, block},
};

fn publish(farm: &mut HandDrivenFarm, builds: usize) {
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(builds);
    farm.pass_secs(1.0);
}

fn copies(farm: &HandDrivenFarm, build: usize) -> usize {
    build_file::read_build(&farm.queued()[build], &build_file::ReadLimits::default()).unwrap().len()
}

#[test]
fn a_ticket_that_comes_after_its_part_changes_it_before_the_build() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.drop_bytes("bracket.stl.toml", b"copies = 9\norder = \"brandt\"\npriority = 80\n");
    farm.pass_until("it is applied", |farm| farm.parts(PartState::Waiting)[0].wanted_copies() == 9);
    farm.pass_secs(3.0);
    assert!(!farm.folder("inbox").join("bracket.stl.toml").exists(), "it is archived");
    publish(&mut farm, 1);
    assert_eq!(copies(&farm, 0), 9);
    let part = farm.parts(PartState::Built).remove(0);
    assert_eq!((part.terms.order_name.as_str(), part.terms.priority), ("brandt", 80));
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_ticket_that_comes_after_the_build_is_refused_with_what_became_of_the_part_and_a_remedy_that_works() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    publish(&mut farm, 1);
    farm.drop_bytes("bracket.stl.toml", b"copies = 10\npriority = 80\n");
    let reason = farm.folder("error").join("bracket.stl.toml.reason.txt");
    farm.pass_until("it is refused", |_| reason.exists());
    let text = fs::read_to_string(&reason).unwrap();
    assert!(text.contains("is in build 1, published") && text.contains("with 1 copy"), "{text}");
    assert!(text.contains(&format!("Order 9 more with `nestd edit {} --copies 10`", part.id)), "{text}");
}

#[test]
fn a_ticket_that_comes_after_the_build_and_wants_no_more_is_said_to_and_nothing_is_printed_again() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    publish(&mut farm, 1);
    farm.drop_bytes("bracket.stl.toml", b"copies = 1\n");
    farm.pass_until("it is told", |farm| farm.has_alert(AlertKind::Incomplete));
    let told = farm.alert_text(AlertKind::Incomplete);
    assert!(told.contains("bracket.stl, which is in a build already") && !told.contains("not there"), "{told}");
    assert!(AlertKind::Incomplete.remedy().contains("none that is in a build"));
    farm.pass_until("nothing waits any more", |farm| !farm.has_alert(AlertKind::Incomplete));
    assert!(!farm.folder("inbox").join("bracket.stl.toml").exists(), "it says what is so, and is archived");
    assert!(!farm.folder("error").join("bracket.stl.toml.reason.txt").exists());
    assert_eq!((farm.queued().len(), farm.parts(PartState::Built).len()), (1, 1));
}

#[test]
fn a_late_ticket_that_cannot_be_moved_away_does_not_undo_what_a_person_changed_since() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    // A file stands where the ticket is to go.
    let blocked = farm.folder("archive").join("late-tickets");
    fs::write(&blocked, "in the way").unwrap();
    farm.drop_bytes("bracket.stl.toml", b"copies = 9\n");
    let wanted = |farm: &HandDrivenFarm| farm.parts(PartState::Waiting)[0].wanted_copies();
    farm.pass_until("it is applied", |farm| wanted(farm) == 9);
    farm.ask(async |ledger| ledger.cancel_copies(part, 6, "ann@farm").await.unwrap());
    farm.pass_secs(1.2);
    assert!(farm.folder("inbox").join("bracket.stl.toml").exists());
    assert_eq!(wanted(&farm), 3, "Ann said so last");
    fs::remove_file(&blocked).unwrap();
    farm.pass_until("it is archived", |farm| !farm.folder("inbox").join("bracket.stl.toml").exists());
    assert_eq!(wanted(&farm), 3);
}

#[test]
fn a_late_ticket_that_was_applied_and_cannot_be_moved_away_is_not_refused_for_want_of_its_part() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    fs::write(farm.folder("archive").join("late-tickets"), "in the way").unwrap();
    farm.drop_bytes("bracket.stl.toml", b"copies = 9\n");
    farm.pass_until("it left the hot folder", |farm| !farm.folder("inbox").join("bracket.stl.toml").exists());
    assert_eq!(farm.parts(PartState::Waiting)[0].wanted_copies(), 9);
    let text = fs::read_to_string(farm.folder("error").join("bracket.stl.toml.reason.txt")).unwrap();
    assert!(text.contains(&format!("was applied to bracket.stl (part {part})")), "{text}");
    assert!(!text.contains("waited"), "{text}");
}

#[test]
fn a_list_that_comes_after_its_loose_parts_changes_them() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("b.stl", &block(11.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.drop_bytes("order.csv", b"file;copies\na.stl;3\nb.stl;2\n");
    farm.pass_until("it is applied", |farm| {
        farm.parts(PartState::Waiting).iter().map(|part| part.wanted_copies()).sum::<u32>() == 5
    });
    farm.pass_until("the list is archived", |farm| !farm.folder("inbox").join("order.csv").exists());
    publish(&mut farm, 1);
    assert_eq!(copies(&farm, 0), 5);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_late_row_that_fits_parts_in_two_folders_changes_neither() {
    let mut farm = HandDrivenFarm::open(QUICK);
    for side in ["left", "right"] {
        std::fs::create_dir_all(farm.folder("inbox").join("K-7").join(side)).unwrap();
        farm.drop_part(
            &format!("K-7/{side}/bracket.stl"),
            &block(10.0, 12.0, if side == "left" { 14.0 } else { 15.0 }),
        );
    }
    farm.wait_for_parts(PartState::Waiting, 2);
    std::fs::create_dir_all(farm.folder("inbox").join("K-7")).unwrap();
    farm.drop_bytes("K-7/l.csv", b"file,qty\nbracket.stl,4\n");
    let reason = farm.folder("error").join("K-7/l.csv.reason.txt");
    farm.pass_until("it is refused", |_| reason.is_file());
    let told = std::fs::read_to_string(&reason).unwrap();
    assert!(told.contains("(K-7/left/bracket.stl)") && told.contains("(K-7/right/bracket.stl)"), "{told}");
    assert!(farm.parts(PartState::Waiting).iter().all(|part| part.wanted_copies() == 1), "{told}");
    farm.drop_bytes("K-7/l.csv", b"file,qty\nright/bracket.stl,4\n");
    farm.pass_until("one is meant", |farm| farm.open_copies().len() == 5);
}

#[test]
fn a_revision_takes_the_place_of_the_first_with_all_that_was_asked() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("brandt/hinge.stl.toml", b"copies = 4\nnote = \"black\"\n");
    farm.drop_part("brandt/hinge.stl", &block(10.0, 12.0, 14.0));
    let old = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    farm.drop_part("brandt/hinge.stl", &block(10.0, 12.0, 16.0));
    farm.wait_for_parts(PartState::Refused, 1);
    let new = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!((new.wanted_copies(), new.terms.note.as_str(), new.size_mm().unwrap()[2]), (4, "black", 16.0));
    assert_eq!(farm.parts(PartState::Refused)[0].owed.replaced_by, Some(new.id));
    assert!(!farm.has_alert(AlertKind::Refused), "it was meant so");
    publish(&mut farm, 1);
    assert_eq!(copies(&farm, 0), 4);
    // Where both were meant, the first is taken back.
    assert_eq!(farm.order_and_wait(CommandKind::Retry, Some(old.id)).state, CommandState::Done);
    publish(&mut farm, 2);
    assert_eq!(copies(&farm, 1), 4);
}

#[test]
fn of_a_file_and_its_copy_one_waits_for_a_yes_whichever_came_first() {
    for (first, second) in [("x.stl", "kopia_x.stl"), ("kopia_x.stl", "x.stl"), ("x_1.stl", "x.stl")] {
        for is_at_once in [false, true] {
            let mut farm = HandDrivenFarm::open(QUICK);
            farm.drop_part(first, &block(10.0, 12.0, 14.0));
            if !is_at_once {
                farm.wait_for_parts(PartState::Waiting, 1);
            }
            farm.drop_part(second, &block(10.0, 12.0, 15.0));
            farm.drop_part("max.stl", &block(10.0, 12.0, 16.0));
            let parts = farm.wait_for_parts(PartState::Waiting, 3);
            let asked: Vec<&str> =
                parts.iter().filter(|part| !part.owed.question.is_empty()).map(|part| part.name.as_str()).collect();
            assert!(is_at_once && asked.len() == 1 || asked == [second], "{first}, then {second}: {asked:?}");
            farm.pass_until("it is told", |farm| farm.alert_text(AlertKind::Question).contains("a copy of"));
        }
    }
    // What a ticket orders is wanted.
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("kopia_x.stl.toml", b"copies = 2\n");
    farm.drop_part("kopia_x.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.drop_part("x.stl", &block(10.0, 12.0, 15.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    assert!(!farm.has_alert(AlertKind::Question));
}

#[test]
fn a_speck_waits_for_a_yes() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("cover.stl", &block(0.9, 0.8, 0.7));
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let speck = parts.iter().find(|part| part.name == "cover.stl").unwrap();
    assert!(speck.owed.question.contains("read in inches instead of millimetres it would be 22.9 x 20.3 x 17.8 mm"));
    farm.pass_until("it is asked", |farm| farm.has_alert(AlertKind::Question));
    let questions = farm.status_json()["questions"].clone();
    assert_eq!(
        (&questions[0]["kind"], &questions[0]["name"]),
        (&"confirmation".into(), &"cover.stl".into()),
        "{questions:#}"
    );
    assert!(questions[0]["remedy"].as_str().unwrap().contains("`nestd confirm "), "{questions:#}");
    publish(&mut farm, 1);
    assert_eq!(copies(&farm, 0), 1);
    assert_eq!(farm.order_and_wait(CommandKind::Confirm, Some(speck.id)).state, CommandState::Done);
    farm.pass_until("nobody is asked any more", |farm| !farm.has_alert(AlertKind::Question));
    publish(&mut farm, 2);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_late_ticket_of_a_part_that_waits_for_a_yes_is_applied_and_said_to_be_no_answer() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("cover.stl", &block(0.9, 0.8, 0.7));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.drop_bytes("cover.stl.toml", b"copies = 2\n");
    farm.pass_until("it is applied", |farm| farm.parts(PartState::Waiting)[0].wanted_copies() == 2);
    farm.pass_secs(3.0);
    assert!(!farm.folder("inbox").join("cover.stl.toml").exists(), "it is archived");
    let told = farm.alert_text(AlertKind::Question);
    assert!(told.contains("cover.stl.toml came later and is applied, and is no answer"), "{told}");
    let part = farm.parts(PartState::Waiting).remove(0).id;
    assert_eq!(farm.order_and_wait(CommandKind::Confirm, Some(part)).state, CommandState::Done);
    publish(&mut farm, 1);
    assert_eq!(copies(&farm, 0), 2);
}

#[test]
fn an_empty_file_is_a_command_and_is_answered_in_the_status() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.drop_bytes("PAUSE", b"");
    let status =
        |farm: &HandDrivenFarm| fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap_or_default();
    farm.pass_until("it is paused", |farm| status(farm).contains("PAUSED by file PAUSE"));
    farm.pass_until("it is gone", |farm| !farm.folder("inbox").join("PAUSE").exists());
    farm.drop_bytes("resume.txt", b"");
    farm.pass_until("it is resumed", |farm| status(farm).contains("RESUME,") && !status(farm).contains("PAUSED"));
    farm.drop_bytes("flush", b"");
    farm.wait_for_queued(1);
    farm.pass_until("it is answered", |farm| status(farm).contains("FLUSH,") && status(farm).contains("build 1"));
}
