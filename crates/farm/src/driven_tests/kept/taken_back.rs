//! Ledgers that are put back to a time before nestd took the file of a build back out of the queue: no copy of it is lost, and none is
//! printed twice.

use std::fs;

use ledger::{
    BuildId, BuildRow, BuildState, CommandKind, OperatorWord, PartId, PartState, PickMark, PrintOutcome, ReprintTarget,
    ToldOutcome,
};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block, hand_driven_farm::farm_files::assert_each_copy_once},
};

const PART: PartId = PartId(1);

/// A farm with a part of three copies that waits.
fn three_copies(options: &str) -> HandDrivenFarm {
    let mut farm = HandDrivenFarm::open(&format!("{options}{QUICK}"));
    farm.drop_bytes("a.stl.toml", b"copies = 3\n");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm
}

fn in_state(farm: &HandDrivenFarm, state: BuildState) -> Vec<BuildRow> {
    farm.ask(async |ledger| ledger.builds_in_state(state).await.unwrap())
}

fn find(farm: &HandDrivenFarm, build: BuildId) -> BuildRow {
    farm.ask(async |ledger| ledger.find_build(build).await.unwrap().unwrap())
}

fn prove(farm: &mut HandDrivenFarm) -> BuildId {
    farm.ask(async |ledger| ledger.resume_machine(MACHINE, "a@test").await.unwrap());
    farm.tick();
    farm.order(CommandKind::Flush, None);
    farm.pass_until("a build is proved", |farm| !in_state(farm, BuildState::Verified).is_empty());
    in_state(farm, BuildState::Verified).remove(0).id
}

fn release(farm: &mut HandDrivenFarm, build: BuildId) {
    farm.say(&OperatorWord::Release { build, seen: None }, false).unwrap();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    farm.pass_secs(2.0);
}

fn wait_for_end(farm: &mut HandDrivenFarm, build: BuildId) {
    farm.pass_until("the word is carried out", |farm| find(farm, build).place.withdraw_by.is_none());
}

fn failed(build: BuildId) -> OperatorWord {
    OperatorWord::Outcome(build, ToldOutcome::new(PrintOutcome::Failed, "", "ann"))
}

#[test]
fn a_build_that_was_taken_back_untouched_does_not_count_as_printed_whenever_the_backup_was_made() {
    for (made_at, is_made_again) in ["read", "proved", "published"].into_iter().flat_map(|at| [(at, false), (at, true)])
    {
        let mut farm = three_copies("approve = \"always\"\n");
        let mut backup = farm.write_backup("read");
        let build = prove(&mut farm);
        if made_at == "proved" {
            backup = farm.write_backup(made_at);
        }
        release(&mut farm, build);
        if made_at == "published" {
            backup = farm.write_backup(made_at);
        }
        let word = if is_made_again { failed(build) } else { OperatorWord::Withdraw(build, String::new()) };
        farm.say(&word, true).unwrap();
        wait_for_end(&mut farm, build);
        farm.wait_for_parts(PartState::Waiting, 1);
        farm.pass_secs(2.0);
        if is_made_again {
            let again = prove(&mut farm);
            release(&mut farm, again);
        }
        let story = format!("backup of when it was {made_at}, made again: {is_made_again}");
        for _ in 0..2 {
            farm.stop();
            let told = farm.restore(&backup);
            let says_so = |said: &String| said.contains("taken back out of the queue untouched");
            assert!(told.done.iter().any(says_so), "{story}: {told:?}");
            farm.start();
            farm.pass_secs(5.0);
            assert_eq!(farm.violations(), [""; 0], "{story}");
            let waiting = if is_made_again { 0 } else { 1 };
            assert_eq!(farm.parts(PartState::Waiting).len(), waiting, "{story}");
            assert_eq!(farm.queued().len(), 1 - waiting, "{story}");
        }
        if !is_made_again {
            let again = prove(&mut farm);
            release(&mut farm, again);
        }
        assert_each_copy_once(&farm.queued(), 3);
        assert_eq!(farm.violations(), [""; 0], "{story}");
    }
}

/// Every word that has copies printed again, and how many.
fn words(farm: &HandDrivenFarm, build: BuildId) -> Vec<(OperatorWord, usize)> {
    let marks: Vec<_> = (0..3).map(|copy| (PART, copy)).collect();
    farm.ask(async |ledger| ledger.mark_picks(build, &marks, PickMark::Missing, "ann").await.unwrap());
    let bad = |outcome, copies| {
        OperatorWord::Outcome(build, ToldOutcome { bad: vec![(PART, copies)], ..ToldOutcome::new(outcome, "", "ann") })
    };
    vec![
        (failed(build), 3),
        (bad(PrintOutcome::Complete, 1), 1),
        (bad(PrintOutcome::Interrupted, 2), 2),
        (OperatorWord::BreakOut(build), 3),
        (OperatorWord::Reprint(ReprintTarget::Build(build)), 3),
        (OperatorWord::Requeue(build), 3),
        (OperatorWord::Withdraw(build, String::new()), 3),
    ]
}

#[test]
fn a_word_that_waited_for_the_file_when_the_backup_was_made_has_nothing_printed_twice_and_is_told() {
    for number in 0..7 {
        let mut farm = three_copies("");
        farm.order(CommandKind::Flush, None);
        farm.wait_for_parts(PartState::Built, 1);
        farm.pass_secs(2.0);
        let build = in_state(&farm, BuildState::Published).remove(0).id;
        let (word, again) = words(&farm, build).swap_remove(number);
        assert_eq!(farm.say(&word, true).unwrap().noted, [build]);
        let backup = farm.write_backup("backup");
        wait_for_end(&mut farm, build);
        farm.ask(async |ledger| ledger.resume_machine(MACHINE, "a@test").await.unwrap());
        farm.tick();
        farm.order(CommandKind::Flush, None);
        let (queued, aside) = (farm.wait_for_queued(1).remove(0), farm.root().join("taken.build.3mf"));
        fs::rename(queued, &aside).unwrap();
        farm.pass_secs(5.0);
        farm.stop();
        let told = farm.restore(&backup);
        let about = format!("build {build}");
        assert!(told.done.iter().chain(&told.doubts).any(|said| said.contains(&about)), "{word:?}: {told:?}");
        farm.start();
        farm.pass_secs(5.0);
        assert!(!farm.has_alert(AlertKind::NotTakenBack), "{word:?}: {}", farm.alert_text(AlertKind::NotTakenBack));
        for is_said_again in [false, true] {
            if is_said_again {
                let _ = farm.say(&word, true);
            }
            farm.order(CommandKind::Flush, None);
            farm.pass_secs(15.0);
            assert_eq!((farm.queued().len(), farm.parts(PartState::Waiting).len()), (0, 0), "{word:?} {is_said_again}");
        }
        assert_each_copy_once(&[aside], again);
        assert_eq!(farm.violations(), [""; 0], "{word:?}");
    }
}
