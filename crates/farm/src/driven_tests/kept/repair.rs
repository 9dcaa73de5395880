//! Repair of a ledger that has missed what another farm did in its folders.

use std::{fs, process::Command, time::Duration};

use ledger::{CommandKind, PartState, PrintOutcome, ToldOutcome};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block},
};

/// Prints a part in a farm of its own, and puts the build and its record into the folders of another farm. The build is
/// of a later minute: with the same number and the same second, its file would have the name of the other's.
fn print_in_folders_of(farm: &HandDrivenFarm, name: &str) {
    let mut other = HandDrivenFarm::open(QUICK);
    other.jump(Duration::from_secs(60));
    other.drop_part(name, &block(14.0, 12.0, 10.0));
    other.wait_for_parts(PartState::Waiting, 1);
    other.order(CommandKind::Flush, None);
    other.wait_for_queued(1);
    other.wait_for_parts(PartState::Built, 1);
    other.stop();
    for kind in ["queue", "archive"] {
        for entry in fs::read_dir(other.folder(kind)).unwrap().map(Result::unwrap) {
            if !entry.file_name().to_string_lossy().starts_with('.') {
                let copied = Command::new("cp").arg("-a").arg(entry.path()).arg(farm.folder(kind)).status().unwrap();
                assert!(copied.success());
            }
        }
    }
}

#[test]
fn a_build_of_another_farm_with_the_same_number_does_not_empty_the_own_build_and_is_checked_by_its_contents() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x5.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    let copies: Vec<_> = (0..5).map(|copy| (part.id, copy)).collect();
    farm.ask(async |ledger| {
        let build = ledger.open_build(MACHINE).await.unwrap();
        ledger.begin_nesting(build.id, "flush", &copies).await.unwrap();
    });
    farm.stop();
    print_in_folders_of(&farm, "b_x5.stl");
    let repaired = farm.repair();
    assert!(repaired.done.iter().any(|line| line.contains("was published")), "{repaired:?}");
    farm.start();
    farm.pass_secs(30.0);
    assert!(!farm.has_alert(AlertKind::BuildFailed), "an empty build has paused the machine");
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(2);
    farm.wait_for_parts(PartState::Built, 2);
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_nesting_build_without_copies_is_ended_and_pauses_nothing() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x2.stl", &block(10.0, 10.0, 10.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    let copies = [(part.id, 0), (part.id, 1)];
    farm.ask(async |ledger| {
        let build = ledger.open_build(MACHINE).await.unwrap();
        ledger.begin_nesting(build.id, "flush", &copies).await.unwrap();
        ledger.release_copies(build.id, &copies, "its build was published after the backup was made").await.unwrap();
    });
    let events = farm.ask(async |ledger| ledger.events_of_part(part.id).await.unwrap());
    assert!(events.iter().all(|event| !event.detail.contains("found no place")), "{events:?}");
    farm.pass_secs(30.0);
    assert!(!farm.has_alert(AlertKind::BuildFailed));
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
}

#[test]
fn a_part_whose_original_was_being_fetched_at_the_time_of_the_backup_is_printed_again() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x2.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(1.0);
    let build = farm.ask(async |ledger| ledger.read_history(&Default::default()).await.unwrap()[0].build);
    let failed = ToldOutcome::new(PrintOutcome::Failed, "", "ann");
    farm.ask(async |ledger| ledger.record_outcome(build, &failed).await.unwrap());
    farm.stop();
    print_in_folders_of(&farm, "b.stl");
    let repaired = farm.repair();
    assert!(!repaired.doubts.iter().any(|doubt| doubt.contains("a_x2.stl")), "{repaired:?}");
    farm.start();
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(3);
    farm.wait_for_parts(PartState::Built, 2);
}
