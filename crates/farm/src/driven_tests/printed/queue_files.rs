//! Build files in a queue folder that should not be there, or are not what was proved: told within a look, until that is over.

use std::{fs, path::PathBuf};

use ledger::{
    BuildRow, BuildState, CommandKind, InQueueError, LedgerError, OperatorWord, PartState, PrintOutcome, ToldOutcome,
};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block},
};

/// A farm with one published build, and its file.
fn one_build() -> (HandDrivenFarm, BuildRow, PathBuf) {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_parts(PartState::Built, 1);
    let build = farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()).remove(0);
    let file = farm.queued().remove(0);
    (farm, build, file)
}

fn find(farm: &HandDrivenFarm, build: &BuildRow) -> BuildRow {
    farm.ask(async |ledger| ledger.find_build(build.id).await.unwrap().unwrap())
}

fn told(build: &BuildRow, outcome: PrintOutcome) -> OperatorWord {
    OperatorWord::Outcome(build.id, ToldOutcome::new(outcome, "", "ann@farm"))
}

fn expect_told(farm: &mut HandDrivenFarm, text: &str) {
    farm.pass_until(text, |farm| farm.alert_text(AlertKind::QueueAltered).contains(text));
}

fn expect_over(farm: &mut HandDrivenFarm) {
    farm.pass_until("it is over", |farm| !farm.has_alert(AlertKind::QueueAltered));
}

/// The same ZIP package with a comment behind it: other bytes, of which the same copies are printed.
fn with_comment(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len();
    bytes[end - 2] = 5;
    bytes.extend(b"again");
    bytes
}

#[test]
fn a_copy_with_other_bytes_is_told_whatever_became_of_its_build() {
    for ends in ["withdrawn", "complete", "published"] {
        let (mut farm, build, file) = one_build();
        let (bytes, copy) = (with_comment(fs::read(&file).unwrap()), file.with_file_name("Kopie.build.3mf"));
        fs::write(&copy, &bytes).unwrap();
        let failed = told(&build, PrintOutcome::Failed);
        if ends == "withdrawn" {
            let refused = farm.say(&failed, true);
            assert!(matches!(refused, Err(LedgerError::InQueue(InQueueError::Copied { .. }))), "{refused:?}");
            fs::remove_file(&copy).unwrap();
            farm.say(&failed, true).unwrap();
            farm.pass_until("it is taken back", |farm| find(farm, &build).state == BuildState::Failed);
            fs::write(&copy, &bytes).unwrap();
        } else if ends == "complete" {
            fs::remove_file(&file).unwrap();
            farm.pass_secs(2.0);
            farm.say(&told(&build, PrintOutcome::Complete), false).unwrap();
        }
        expect_told(&mut farm, &format!("Kopie.build.3mf at test holds the copies of build {} ({ends})", build.id));
        // That name is taken, or what lies there under it is told, too.
        let text = farm.alert_text(AlertKind::QueueAltered);
        assert!(!text.contains("or give it that name back"), "{text}");
        farm.stop();
        farm.start();
        expect_told(&mut farm, "Kopie.build.3mf");
        fs::remove_file(&copy).unwrap();
        if ends == "published" {
            // It may have been printed: a person says that it was not.
            expect_told(&mut farm, "Kopie.build.3mf at test, and is gone");
            farm.say(&OperatorWord::SeenTo(build.id), false).unwrap();
        }
        expect_over(&mut farm);
    }
}

#[test]
fn a_file_that_is_put_back_when_its_build_is_over_is_told() {
    for ends in ["failed", "complete", "withdrawn"] {
        let (mut farm, build, file) = one_build();
        let aside = farm.root().join("aside");
        if ends == "withdrawn" {
            fs::copy(&file, &aside).unwrap();
            farm.say(&OperatorWord::Withdraw(build.id, String::new()), false).unwrap();
            farm.pass_until("it is withdrawn", |farm| {
                let place = find(farm, &build).place;
                place.withdrawn_at.is_some() && place.withdraw_by.is_none()
            });
        } else {
            fs::rename(&file, &aside).unwrap();
            farm.pass_until("it is gone", |farm| find(farm, &build).place.taken_at.is_some());
            let outcome = if ends == "failed" { PrintOutcome::Failed } else { PrintOutcome::Complete };
            farm.say(&told(&build, outcome), false).unwrap();
        }
        farm.pass_secs(2.0);
        assert!(!farm.has_alert(AlertKind::QueueAltered));
        fs::copy(&aside, &file).unwrap();
        expect_told(&mut farm, &format!("is the file of build {}", build.id));
        assert!(farm.alert_text(AlertKind::QueueAltered).contains(ends));
        let status = farm.folder("inbox").join("STATUS.txt");
        let is_there =
            |_: &HandDrivenFarm| fs::read_to_string(&status).unwrap().contains("must not be printed as it is");
        farm.pass_until("the hot folder says so", is_there);
        fs::remove_file(&file).unwrap();
        expect_over(&mut farm);
        if ends == "failed" {
            // The remedy that the alert names, where it was printed all the same.
            let corrected =
                ToldOutcome { is_correction: true, ..ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm") };
            farm.say(&OperatorWord::Outcome(build.id, corrected), false).unwrap();
            assert_eq!((find(&farm, &build).state, farm.parts(PartState::Waiting).len()), (BuildState::Complete, 0));
        }
    }
}

#[test]
fn a_file_at_another_machine_is_sent_to_its_own_only_while_its_build_is_to_be_printed() {
    for ends in ["published", "failed", "complete"] {
        let (mut farm, build, file) = one_build();
        farm.write_profile("other", QUICK);
        farm.reload();
        farm.pass_secs(5.0);
        let (aside, name) = (farm.root().join("aside"), file.file_name().unwrap().to_owned());
        fs::rename(&file, &aside).unwrap();
        farm.pass_until("it is gone", |farm| find(farm, &build).place.taken_at.is_some());
        match ends {
            "failed" => drop(farm.say(&told(&build, PrintOutcome::Failed), true).unwrap()),
            "complete" => drop(farm.say(&told(&build, PrintOutcome::Complete), true).unwrap()),
            _ => {}
        }
        for there in [name.to_str().unwrap(), "Kopie.build.3mf"] {
            let there = farm.folder_of("queue", "other").join(there);
            fs::copy(&aside, &there).unwrap();
            expect_told(&mut farm, &format!("build {}", build.id));
            let text = farm.alert_text(AlertKind::QueueAltered);
            let is_sent = ends == "published" && there.file_name() == Some(&*name);
            assert_eq!(text.contains("take it to a queue of"), is_sent, "{ends}: {text}");
            assert_eq!(text.contains("take it out"), !is_sent, "{ends}: {text}");
            assert!(!text.contains("that name back"), "{ends}: {text}");
            fs::remove_file(&there).unwrap();
            expect_over(&mut farm);
        }
    }
}

#[test]
fn a_taken_file_that_comes_back_lies_in_the_queue_again_within_a_look_and_one_that_stays_is_no_fault() {
    let (mut farm, build, file) = one_build();
    let aside = farm.root().join("aside");
    fs::rename(&file, &aside).unwrap();
    farm.pass_until("it is gone", |farm| find(farm, &build).place.taken_at.is_some());
    fs::rename(&aside, &file).unwrap();
    farm.pass_until("it is back", |farm| find(farm, &build).place.taken_at.is_none());
    farm.say(&told(&build, PrintOutcome::Complete), false).unwrap();
    farm.pass_secs(5.0);
    assert!(!farm.has_alert(AlertKind::QueueAltered), "people leave the files of good prints where they are");
    fs::rename(&file, farm.root().join("aside")).unwrap();
    fs::write(&file, b"another").unwrap();
    fs::write(file.with_file_name("foreign.build.3mf"), b"of somebody else").unwrap();
    farm.pass_secs(5.0);
    assert!(farm.folder_of("queue", MACHINE).join("foreign.build.3mf").exists());
}

#[test]
fn a_published_file_that_was_changed_and_kept_its_size_is_told_until_it_is_as_it_was() {
    let (mut farm, build, file) = one_build();
    let bytes = fs::read(&file).unwrap();
    let mut changed = bytes.clone();
    changed[bytes.len() / 2] ^= 1;
    farm.pass_secs(5.0);
    for restarts in [false, true] {
        assert!(!farm.has_alert(AlertKind::QueueAltered));
        if restarts {
            farm.stop();
        }
        let time = fs::metadata(&file).unwrap().modified().unwrap();
        fs::write(&file, &changed).unwrap();
        fs::File::options().write(true).open(&file).unwrap().set_modified(time).unwrap();
        if restarts {
            farm.start();
        }
        expect_told(&mut farm, &format!("is not the file that was proved as build {}", build.id));
        fs::write(&file, &bytes).unwrap();
        expect_over(&mut farm);
    }
}

#[test]
fn what_a_take_back_finds_changed_is_told_until_the_file_is_out_of_the_queue() {
    let (mut farm, build, file) = one_build();
    let mut bytes = fs::read(&file).unwrap();
    bytes[100] ^= 1;
    farm.say(&OperatorWord::Withdraw(build.id, String::new()), false).unwrap();
    fs::write(&file, &bytes).unwrap();
    farm.pass_until("the withdrawal has ended", |farm| find(farm, &build).place.withdraw_by.is_none());
    expect_told(&mut farm, "is not the file that was proved");
    assert_eq!(find(&farm, &build).state, BuildState::Published);
    fs::remove_file(&file).unwrap();
    expect_over(&mut farm);
}
