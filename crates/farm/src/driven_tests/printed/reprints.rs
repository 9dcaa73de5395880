//! What was printed badly is printed again, with all that was asked; and what was asked is changed after the drop.

use std::fs;

use ledger::{
    BuildId, CommandArgument, CommandKind, CommandState, NewCommand, PartEdit, PartId, PartState, PrintOutcome,
    ReprintTarget, ToldOutcome,
};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block},
};

/// Copies and sizes of the parts in a build file.
pub fn contents(farm: &HandDrivenFarm, build: usize) -> Vec<(String, u32, String)> {
    let placed = build_file::read_build(&farm.queued()[build], &build_file::ReadLimits::default()).unwrap();
    let size = |mesh: &solids::Mesh| format!("{:.2}", mesh.bounds().size().to_array().iter().product::<f64>());
    let mut all: Vec<_> =
        placed.iter().map(|p| (p.part_number.clone().unwrap(), p.copy.unwrap(), size(&p.mesh))).collect();
    all.sort();
    all
}

pub fn published(farm: &mut HandDrivenFarm, builds: usize) -> BuildId {
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(builds);
    farm.pass_secs(1.0);
    BuildId(farm.ask(async |ledger| ledger.read_history(&Default::default()).await.unwrap()[0].build.0))
}

pub fn tell(farm: &HandDrivenFarm, build: BuildId, outcome: PrintOutcome) {
    let told = ToldOutcome::new(outcome, "", "ann@farm");
    farm.ask(async |ledger| ledger.record_outcome(build, &told).await.unwrap());
}

pub fn change(
    farm: &mut HandDrivenFarm,
    kind: CommandKind,
    part: PartId,
    argument: CommandArgument,
    machine: &str,
) -> String {
    let id = farm.submit_command(&new_command(kind, part, argument, machine));
    let answer = |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.find_command(id).await.unwrap().unwrap());
    farm.pass_until("the command is answered", |farm| answer(farm).answered_at.is_some());
    let row = answer(farm);
    assert_eq!(row.state, CommandState::Done, "{}", row.answer);
    row.answer
}

fn new_command(kind: CommandKind, part: PartId, argument: CommandArgument, machine: &str) -> NewCommand {
    NewCommand { kind, machine: machine.to_owned(), part: Some(part), argument, asked_by: "ann@farm".to_owned() }
}

pub fn edit(edit: PartEdit) -> CommandArgument {
    CommandArgument { edit: Some(edit), copies: None, ..CommandArgument::default() }
}

#[test]
fn a_failed_build_comes_back_with_every_copy_in_the_unit_and_under_the_rules_that_were_asked() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_bytes("cover.stl.toml", b"copies = 3\nunit = \"inch\"\norientation = \"upright\"\norder = \"brandt\"\n");
    farm.drop_part("cover.stl", &block(1.0, 1.0, 1.0));
    farm.drop_part("pin_x2.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    let build = published(&mut farm, 1);
    let first = contents(&farm, 0);
    assert_eq!(first.len(), 5);
    assert!(first.iter().any(|(_, _, size)| size == "16387.06"), "inches: {first:?}");
    assert!(
        fs::read_dir(farm.root().join("state/store"))
            .unwrap()
            .next()
            .is_none_or(|entry| { fs::read_dir(entry.unwrap().path()).unwrap().next().is_none() }),
        "the originals are in the archive alone"
    );
    tell(&farm, build, PrintOutcome::Failed);
    farm.pass_secs(2.0);
    let waiting = farm.ask(async |ledger| ledger.waiting_copies(MACHINE).await.unwrap());
    assert_eq!(waiting.iter().map(|w| w.copies.len()).sum::<usize>(), 5);
    published(&mut farm, 2);
    assert_eq!(contents(&farm, 1), first, "the same copies in the same sizes");
    let line = farm.ask(async |ledger| ledger.order_lines("brandt").await.unwrap()).remove(0);
    assert_eq!((line.copies.wanted, line.copies.published(), line.copies.bad), (3, 3, 3));
}

#[test]
fn an_original_that_is_in_no_archive_any_more_is_asked_for_and_its_copies_wait() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x2.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let build = published(&mut farm, 1);
    for entry in fs::read_dir(farm.folder("archive")).unwrap().map(Result::unwrap).filter(|e| e.path().is_dir()) {
        fs::remove_file(entry.path().join("a_x2.stl")).unwrap();
    }
    tell(&farm, build, PrintOutcome::Failed);
    farm.pass_secs(2.0);
    assert!(farm.has_alert(AlertKind::FileDamaged));
    farm.drop_part("again.stl", &block(10.0, 10.0, 10.0));
    farm.pass_until("the file is taken in its place", |farm| !farm.has_alert(AlertKind::FileDamaged));
    published(&mut farm, 2);
    assert_eq!(contents(&farm, 1).len(), 2, "it was no order of its own");
}

#[test]
fn originals_that_are_dropped_again_together_are_no_orders_of_their_own() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x2.stl", &block(10.0, 10.0, 10.0));
    farm.drop_part("b.stl", &block(12.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    let build = published(&mut farm, 1);
    for entry in fs::read_dir(farm.folder("archive")).unwrap().map(Result::unwrap).filter(|e| e.path().is_dir()) {
        fs::remove_dir_all(entry.path()).unwrap();
    }
    tell(&farm, build, PrintOutcome::Failed);
    farm.pass_secs(2.0);
    farm.drop_part("a again.stl", &block(10.0, 10.0, 10.0));
    farm.drop_part("b again.stl", &block(12.0, 10.0, 10.0));
    farm.pass_until("both are taken in their place", |farm| !farm.has_alert(AlertKind::FileDamaged));
    published(&mut farm, 2);
    assert_eq!(contents(&farm, 1).len(), 3);
    assert_eq!(farm.parts(PartState::Built).len(), 2, "neither is a part of its own");
}

#[test]
fn a_part_that_a_build_takes_while_it_is_cancelled_is_not_in_the_error_folder() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    let build = published(&mut farm, 1);
    tell(&farm, build, PrintOutcome::Failed);
    farm.wait_for_parts(PartState::Waiting, 1);
    let cancel = farm.order(CommandKind::Cancel, Some(part));
    farm.begin_tick();
    farm.ask(async |ledger| ledger.requeue_build(build, "ann").await.unwrap());
    farm.wait_for_queued(2);
    farm.pass_secs(1.0);
    let answer = farm.ask(async |ledger| ledger.find_command(cancel).await.unwrap().unwrap());
    assert_eq!(answer.state, CommandState::Refused);
    assert!(!farm.folder("error").join(format!("part-{part}")).exists());
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn the_same_build_is_issued_once_more_copy_for_copy_and_pose_for_pose() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x4.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let build = published(&mut farm, 1);
    let new = farm.ask(async |ledger| ledger.requeue_build(build, "ann").await.unwrap());
    farm.wait_for_queued(2);
    farm.pass_secs(1.0);
    let (old, new) = farm.ask(async |ledger| {
        (ledger.placements_of_build(build).await.unwrap(), ledger.placements_of_build(new).await.unwrap())
    });
    assert_eq!((old.len(), new.len()), (4, 4));
    for (old, new) in old.iter().zip(&new) {
        let (old, new) = (old.pose().unwrap(), new.pose().unwrap());
        assert!((old.translation - new.translation).length() < 1e-6, "{old:?} {new:?}");
        assert!(old.rotation.dot(new.rotation).abs() > 1.0 - 1e-9, "{old:?} {new:?}");
    }
    assert_eq!(contents(&farm, 0), contents(&farm, 1));
}

#[test]
fn what_was_asked_is_changed_after_the_drop_and_the_next_build_has_it() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("other", QUICK);
    farm.reload();
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.drop_part("b.stl", &block(12.0, 10.0, 10.0));
    farm.drop_part("c.stl", &block(14.0, 10.0, 10.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 3);
    let id = |name: &str| parts.iter().find(|part| part.name == name).unwrap().id;
    let more = PartEdit { copies: Some(3), order_name: Some("brandt".into()), ..PartEdit::default() };
    let answer = change(&mut farm, CommandKind::Edit, id("a.stl"), edit(more), "");
    assert!(answer.contains("3 copies instead of 1") && answer.contains("order brandt instead of none"), "{answer}");
    let inches = PartEdit { unit: Some(build_file::LengthUnit::Centimeter), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, id("b.stl"), edit(inches), "");
    let answer = change(&mut farm, CommandKind::Move, id("c.stl"), CommandArgument::default(), "other");
    assert!(answer.contains("moved to other"), "{answer}");
    change(
        &mut farm,
        CommandKind::Cancel,
        id("a.stl"),
        CommandArgument { copies: Some(1), edit: None, ..CommandArgument::default() },
        "",
    );
    farm.wait_for_parts(PartState::Waiting, 3);
    let b = farm.ask(async |ledger| ledger.find_part(id("b.stl")).await.unwrap().unwrap());
    assert_eq!(b.size_mm().unwrap(), [120.0, 100.0, 100.0], "it was read again in the new unit");
    change(&mut farm, CommandKind::Cancel, id("b.stl"), CommandArgument::default(), "");
    published(&mut farm, 1);
    let built = contents(&farm, 0);
    assert_eq!(built.len(), 2, "two of a: {built:?}");
    assert!(built.iter().all(|(part, ..)| *part == id("a.stl").to_string()));
    // More of what is built already.
    let more = PartEdit { copies: Some(4), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, id("a.stl"), edit(more), "");
    published(&mut farm, 2);
    assert_eq!(contents(&farm, 1).len(), 2);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_part_that_is_cancelled_while_it_is_read_again_is_in_the_error_folder() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    let unit = PartEdit { unit: Some(build_file::LengthUnit::Centimeter), ..PartEdit::default() };
    // Both are carried out before the file is read again.
    farm.submit_command(&new_command(CommandKind::Edit, part, edit(unit), ""));
    farm.order(CommandKind::Cancel, Some(part));
    farm.wait_for_parts(PartState::Refused, 1);
    farm.pass_secs(1.0);
    assert!(farm.folder("error").join(format!("part-{part}/a.stl")).exists());
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_part_whose_unit_changes_while_its_original_is_fetched_is_read_when_it_is_there() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 8.0, 6.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    let build = published(&mut farm, 1);
    tell(&farm, build, PrintOutcome::Failed);
    let unit = PartEdit { unit: Some(build_file::LengthUnit::Centimeter), ..PartEdit::default() };
    // The edit is carried out, and the file would be read, in the tick that begins to fetch the original.
    farm.submit_command(&new_command(CommandKind::Edit, part, edit(unit), ""));
    farm.begin_tick();
    farm.pass_secs(1.0);
    published(&mut farm, 2);
    assert_eq!(contents(&farm, 1)[0].2, "480000.00");
}

#[test]
fn single_copies_broken_at_unpacking_are_printed_again_even_after_a_restart() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x5.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    let build = published(&mut farm, 1);
    tell(&farm, build, PrintOutcome::Complete);
    farm.ask(async |ledger| ledger.reprint_copies(&ReprintTarget::Part(part, Some(2)), "ann").await.unwrap());
    farm.stop();
    farm.start();
    published(&mut farm, 2);
    assert_eq!(contents(&farm, 1).len(), 2);
    let line = farm.ask(async |ledger| ledger.line_of_part(part).await.unwrap()).copies;
    assert_eq!((line.wanted, line.good, line.published(), line.bad), (5, 3, 2, 2));
}

#[test]
fn commands_are_answered_while_a_moved_part_waits_for_its_original() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("other", QUICK);
    farm.reload();
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    published(&mut farm, 1);
    farm.wait_for_parts(PartState::Built, 1);
    for entry in fs::read_dir(farm.folder("archive")).unwrap().map(Result::unwrap).filter(|e| e.path().is_dir()) {
        fs::remove_dir_all(entry.path()).unwrap();
    }
    farm.pass_secs(5.0);
    let more = PartEdit { copies: Some(3), ..PartEdit::default() };
    change(&mut farm, CommandKind::Edit, part, edit(more), "");
    farm.pass_secs(5.0);
    assert!(farm.has_alert(AlertKind::FileDamaged));
    change(&mut farm, CommandKind::Move, part, CommandArgument::default(), "other");
    for machine in ["test", "other"] {
        let flush = NewCommand {
            kind: CommandKind::Flush,
            machine: machine.to_owned(),
            part: None,
            argument: CommandArgument::default(),
            asked_by: "a@test".to_owned(),
        };
        let id = farm.submit_command(&flush);
        let is_answered = |farm: &HandDrivenFarm| {
            farm.ask(async |ledger| ledger.find_command(id).await.unwrap().unwrap().answered_at.is_some())
        };
        farm.pass_until("the flush is answered", is_answered);
    }
    // A change of what was asked is answered, too.
    let again = NewCommand {
        kind: CommandKind::Edit,
        machine: String::new(),
        part: Some(part),
        argument: edit(PartEdit { copies: Some(5), ..PartEdit::default() }),
        asked_by: "a@test".to_owned(),
    };
    let id = farm.submit_command(&again);
    farm.pass_secs(2.0);
    let answer = farm.ask(async |ledger| ledger.find_command(id).await.unwrap().unwrap().answer);
    assert!(answer.contains("waits for its file"), "{answer}");
    // After a restart, too.
    farm.stop();
    farm.start();
    farm.order_and_wait(CommandKind::Flush, None);
}

#[test]
fn a_part_that_a_revision_replaces_while_its_original_is_fetched_is_in_the_error_folder() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("brandt/a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let build = published(&mut farm, 1);
    let (archive, away) = (farm.folder("archive"), farm.root().join("away"));
    fs::rename(&archive, &away).unwrap();
    tell(&farm, build, PrintOutcome::Failed);
    farm.drop_part("brandt/a.stl", &block(10.0, 10.0, 12.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.pass_secs(5.0);
    fs::rename(&away, &archive).unwrap();
    farm.wait_for_parts(PartState::Refused, 1);
    farm.pass_secs(2.0);
    assert_eq!(farm.violations(), [""; 0]);
}
