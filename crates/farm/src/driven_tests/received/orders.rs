//! Commands that people give to the daemon.

use std::fs;

use ledger::{CommandArgument, CommandKind, CommandState, NewCommand, PartEdit, PartState};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block, stl},
};

#[test]
fn a_paused_machine_fires_nothing_until_it_is_resumed() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ncopies = 1\n"));
    assert_eq!(farm.order_and_wait(CommandKind::Pause, None).state, CommandState::Done);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!(farm.order_and_wait(CommandKind::Flush, None).state, CommandState::Refused);
    farm.pass_secs(60.0);
    assert!(farm.queued().is_empty());
    assert_eq!(farm.order_and_wait(CommandKind::Resume, None).state, CommandState::Done);
    farm.wait_for_queued(1);
}

#[test]
fn a_pause_by_a_user_who_is_called_like_the_daemon_is_not_a_failed_build() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let asked_by = "nestd".to_owned();
    farm.submit_command(&NewCommand {
        kind: CommandKind::Pause,
        machine: MACHINE.to_owned(),
        part: None,
        argument: Default::default(),
        asked_by,
    });
    farm.pass_secs(10.0);
    assert_eq!(farm.ask(async |ledger| ledger.paused_machines().await.unwrap()), [MACHINE]);
    assert!(!farm.has_alert(AlertKind::BuildFailed));
}

#[test]
fn a_cancelled_part_is_in_no_build() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.drop_part("b.stl", &block(12.0, 10.0, 10.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let a = parts.iter().find(|p| p.name == "a.stl").unwrap();
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(a.id)).state, CommandState::Done);
    farm.order(CommandKind::Flush, None);
    let built = farm.wait_for_parts(PartState::Built, 1);
    assert_eq!(built[0].name, "b.stl");
    assert_eq!(farm.parts(PartState::Refused)[0].name, "a.stl");
    let copy = farm.folder("error").join(format!("part-{}", a.id)).join("a.stl");
    assert!(copy.exists(), "the original of a cancelled part is given back");
}

#[test]
fn a_part_that_was_cancelled_and_taken_back_is_printed_and_leaves_the_error_folder() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x2.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(part.id)).state, CommandState::Done);
    let folder = farm.folder("error").join(format!("part-{}", part.id));
    assert!(folder.join("a_x2.stl").exists());
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(part.id)).state, CommandState::Refused);
    assert_eq!(farm.order_and_wait(CommandKind::Retry, Some(part.id)).state, CommandState::Done);
    farm.wait_for_parts(PartState::Waiting, 1);
    assert!(!folder.exists());
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_part_that_is_cancelled_again_while_it_is_taken_back_is_in_the_error_folder() {
    let mut farm = HandDrivenFarm::open(QUICK);
    // Its reading takes longer than a copy.
    farm.drop_part("a.stl", &sample_parts::boulder(30.0, 60));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(part.id)).state, CommandState::Done);
    farm.order(CommandKind::Retry, Some(part.id));
    farm.begin_tick();
    farm.order(CommandKind::Cancel, Some(part.id));
    farm.begin_tick();
    farm.wait_for_parts(PartState::Refused, 1);
    assert!(farm.folder("error").join(format!("part-{}", part.id)).join("a.stl").exists());
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_part_that_is_refused_while_it_is_read_again_is_copied_into_the_error_folder_before_the_ledger_says_so() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("batch/a.stl", &sample_parts::boulder(30.0, 60));
    let first = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    farm.drop_part("batch/a.stl", &block(10.0, 10.0, 10.0));
    let replaced = |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.replaced_parts().await.unwrap());
    farm.pass_until("a newer revision is taken", |farm| !replaced(farm).is_empty());
    let again = PartEdit { orientation: Some(nester::OrientationRule::Upright), ..PartEdit::default() };
    let argument = CommandArgument { edit: Some(again), ..CommandArgument::default() };
    let (machine, asked_by) = (String::new(), "ann@farm".to_owned());
    farm.submit_command(&NewCommand { kind: CommandKind::Edit, machine, part: Some(first), argument, asked_by });
    // The power fails within any of these ticks: the ledger never says "refused" of a file that is not in the error folder.
    for _ in 0..100 {
        farm.begin_tick();
        let is_refused = !farm.parts(PartState::Refused).is_empty();
        assert!(!is_refused || farm.folder("error").join(format!("part-{first}/a.stl")).exists());
        farm.pass_secs(0.1);
        if is_refused {
            return farm.assert_ledger_agrees_with_folders();
        }
    }
    panic!("the earlier revision stays");
}

#[test]
fn a_copy_into_the_error_folder_that_a_crash_cut_short_is_made_again() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let bytes = stl(&block(10.0, 10.0, 10.0));
    farm.drop_bytes("a.stl", &bytes);
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0).id;
    // All bytes were written, and the rename to the right name was not.
    let folder = farm.folder("error").join(format!("part-{part}"));
    fs::create_dir_all(&folder).unwrap();
    let reason = format!("Cancelled by ann.\n\nPart {part} of the machine {MACHINE}.\n");
    fs::write(folder.join("a.stl.reason.txt"), reason).unwrap();
    fs::write(folder.join(".nestd-0123456789abcdef01234567.tmp"), &bytes).unwrap();
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(part)).state, CommandState::Done);
    assert!(folder.join("a.stl").exists());
    farm.assert_ledger_agrees_with_folders();
}
