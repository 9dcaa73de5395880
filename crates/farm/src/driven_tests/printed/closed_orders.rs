//! A person closes an order as it is, at every moment of its builds: what was said to be cancelled is not printed, and what was accepted is
//! printed once.

use ledger::{CommandKind, OperatorWord, PartEdit, PartId, PartState, PrintOutcome, ToldOutcome};

use super::printers::{bring_up, published, queue, take_down, two_printers, visible};
use crate::driven_tests::{
    HandDrivenFarm, MACHINE, QUICK, block,
    hand_driven_farm::farm_files::{assert_each_copy_once, list_build_files},
    stl,
};

const ORDER: &str = "A-17";

fn drop_order(farm: &mut HandDrivenFarm, copies: u32) {
    farm.drop_bytes(&format!("{ORDER}/a_x{copies}.stl"), &stl(&block(20.0, 20.0, 10.0)));
    farm.wait_for_parts(PartState::Waiting, 1);
}

fn close(farm: &HandDrivenFarm) -> Vec<String> {
    farm.say(&OperatorWord::CloseOrder(ORDER.to_owned()), false).unwrap().sentences
}

/// Wants so many copies of the only part.
fn want(farm: &HandDrivenFarm, copies: u32) {
    let edit = PartEdit { copies: Some(copies), ..PartEdit::default() };
    farm.ask(async |ledger| ledger.edit_part(PartId(1), &edit, "ann@farm").await.unwrap());
}

fn tell(farm: &HandDrivenFarm, outcome: PrintOutcome, anyway: bool) {
    let build = published(farm)[0].id;
    farm.say(&OperatorWord::Outcome(build, ToldOutcome::new(outcome, "", "ann@farm")), anyway).unwrap();
}

fn is_over(farm: &HandDrivenFarm) -> bool {
    farm.ask(async |ledger| ledger.find_order(ORDER).await.unwrap().unwrap().is_over())
}

fn rest(farm: &mut HandDrivenFarm) {
    farm.pass_secs(5.0);
    farm.order(CommandKind::Flush, None);
    farm.pass_secs(10.0);
}

#[test]
fn what_a_flush_was_about_to_take_is_not_printed_once_its_order_is_closed() {
    let mut farm = HandDrivenFarm::open(QUICK);
    drop_order(&mut farm, 5);
    farm.order(CommandKind::Flush, None);
    assert!(close(&farm)[1].contains("5 copies that wait are cancelled"));
    farm.pass_secs(15.0);
    assert!(farm.queued().is_empty(), "it was told to be cancelled");
    assert!(is_over(&farm) && farm.parts(PartState::Refused).len() == 1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn an_order_that_is_closed_while_its_build_is_made_gets_the_accepted_copies_once() {
    let mut farm = HandDrivenFarm::open(QUICK);
    drop_order(&mut farm, 2);
    farm.order(CommandKind::Flush, None);
    farm.begin_tick();
    farm.pass_until("it is nested", |farm| farm.parts(PartState::Batched).len() + farm.queued().len() > 0);
    want(&farm, 5);
    close(&farm);
    rest(&mut farm);
    assert_each_copy_once(&farm.queued(), 2);
    tell(&farm, PrintOutcome::Failed, true);
    rest(&mut farm);
    assert_each_copy_once(&farm.queued(), 2);
    tell(&farm, PrintOutcome::Complete, true);
    rest(&mut farm);
    assert!(is_over(&farm));
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn an_order_that_is_closed_while_its_build_moves_is_printed_where_it_goes() {
    let mut farm = two_printers("");
    drop_order(&mut farm, 2);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    assert_eq!(visible(&farm), [1, 0]);
    want(&farm, 4);
    take_down(&farm, "right");
    take_down(&farm, "left");
    farm.pass_secs(2.0);
    close(&farm);
    bring_up(&farm, "right");
    rest(&mut farm);
    let all = [list_build_files(&queue(&farm, "left")), list_build_files(&queue(&farm, "right"))].concat();
    assert_each_copy_once(&all, 2);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn more_copies_of_a_closed_order_are_printed_once_and_a_backup_from_before_tells_what_it_lacks() {
    let mut farm = HandDrivenFarm::open(QUICK);
    drop_order(&mut farm, 2);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    want(&farm, 5);
    farm.pass_secs(2.0);
    let backup = farm.write_backup("backup");
    close(&farm);
    rest(&mut farm);
    assert_each_copy_once(&farm.queued(), 2);
    want(&farm, 3);
    rest(&mut farm);
    assert_each_copy_once(&farm.queued(), 3);
    assert!(!is_over(&farm));
    farm.assert_ledger_agrees_with_folders();
    farm.stop();
    let told = farm.restore(&backup);
    farm.start();
    rest(&mut farm);
    assert_each_copy_once(&farm.queued(), 3);
    let waits = farm.ask(async |ledger| ledger.waiting_copies(MACHINE).await.unwrap().len());
    assert!(waits == 0 && told.done.len() + told.doubts.len() > 0, "{told:?}");
    farm.assert_ledger_agrees_with_folders();
}
