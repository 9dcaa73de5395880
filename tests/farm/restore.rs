//! Backup and restore as an operator does them: nothing that was published since the backup is printed again.

use std::{fs, path::PathBuf, process::Output};

use nestd::ledger::PartState;

use super::support::{QUICK, TestFarm, block};

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// A farm that has stopped, and its backup: `a` waited when it was made and was published later, `b` was dropped and
/// published later, `c` was dropped later and waits. The printer has taken the first build.
fn farm_and_backup() -> (TestFarm, PathBuf) {
    let mut farm = TestFarm::running(QUICK);
    let backup = farm.root().join("ledger.backup");
    farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert!(farm.nestd_ok(&["backup", backup.to_str().unwrap()]).contains("every page checked"));
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.drop_part("b_x3.stl", &block(21.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 2);
    farm.drop_part("c_x4.stl", &block(22.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let queued = farm.queued();
    assert_eq!(queued.len(), 2);
    fs::remove_file(&queued[0]).unwrap();
    (farm, backup)
}

/// Lets the farm run, and asserts that nothing of `a` and `b` is printed once more.
fn runs_and_prints_nothing_again(farm: &mut TestFarm) {
    let parts = farm.parts(PartState::Built);
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["a_x2.stl", "b_x3.stl"], "{}", farm.log());
    let before = farm.queued();
    farm.start();
    farm.drop_part("new.stl", &block(23.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 3);
    let now = farm.wait_for_queued(before.len() + 1);
    let new = now.iter().find(|file| !before.contains(file)).unwrap();
    let placed = nestd::format::read_build(new, &Default::default()).unwrap();
    assert_eq!(placed.len(), 1, "only what was dropped after the restore");
    assert!(placed[0].part_number.as_deref().unwrap().parse::<i64>().unwrap() > 3, "a number was given out twice");
    assert_eq!(farm.ask(async |ledger| ledger.faults().await.unwrap()), Vec::<String>::new());
    farm.stop();
}

#[test]
fn a_restored_backup_learns_from_the_folders_what_was_published_since() {
    let (mut farm, backup) = farm_and_backup();
    let said = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert_eq!(said.matches("was published; its copies are taken in").count(), 2, "{said}");
    let stored = said.lines().find(|line| line.contains("LOOK AT")).unwrap_or_else(|| panic!("c is not told: {said}"));
    assert!(stored.contains("/store/") && stored.contains("drop it again"), "{stored}");
    assert!(said.contains("The one before is kept as"), "{said}");
    let history = farm.nestd_ok(&["history", "--json"]);
    assert_eq!(history.matches("\"height_mm\": 19.99").count(), 2, "the heights are back: {history}");
    let deep = farm.nestd_ok(&["check", "--deep"]);
    assert!(deep.contains("I1 to I4 hold"), "{deep}");
    runs_and_prints_nothing_again(&mut farm);
}

#[test]
fn a_backup_that_was_copied_back_by_hand_is_not_served_until_it_is_repaired() {
    let (mut farm, backup) = farm_and_backup();
    let state = farm.root().join("state");
    for suffix in ["", ".b3"] {
        let from = format!("{}{suffix}", backup.display());
        fs::copy(from, state.join(format!("nestd.db{suffix}"))).unwrap();
    }
    let refused = farm.nestd(&["run"]);
    assert!(!refused.status.success());
    assert!(
        text(&refused).contains("older than the folders") && text(&refused).contains("--repair"),
        "{}",
        text(&refused)
    );
    assert!(farm.nestd_ok(&["status"]).contains("needs a person"));
    let told = fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap();
    assert!(told.contains("does not run") && told.contains("ATTENTION") && told.contains("--repair"), "{told}");
    let said = farm.nestd_ok(&["check", "--deep", "--repair"]);
    assert_eq!(said.matches("was published; its copies are taken in").count(), 2, "{said}");
    runs_and_prints_nothing_again(&mut farm);
}

#[test]
fn without_records_the_build_files_in_the_queue_tell() {
    let (mut farm, backup) = farm_with_a_published();
    let said = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert_eq!(said.matches("was published; its copies are taken in").count(), 1, "{said}");
    assert_eq!(farm.parts(PartState::Built).len(), 1);
    farm.start();
    farm.flush();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert_eq!(farm.queued().len(), 1, "printed twice\n{}", farm.log());
}

/// Published after its backup; its record is gone, as with an archive that was emptied.
fn farm_with_a_published() -> (TestFarm, PathBuf) {
    let mut farm = TestFarm::running(QUICK);
    let backup = farm.root().join("ledger.backup");
    farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    fs::remove_dir_all(farm.folder("archive")).unwrap();
    (farm, backup)
}

#[test]
fn a_part_that_was_cancelled_after_the_backup_is_not_printed() {
    let mut farm = TestFarm::running(QUICK);
    let backup = farm.root().join("ledger.backup");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1)[0].id;
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.nestd_ok(&["cancel", &part.to_string()]);
    farm.stop();
    let said = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(said.contains("LOOK AT: part") && said.contains("refused or cancelled"), "{said}");
    assert_eq!(farm.parts(PartState::Rejected).len(), 1);
    farm.start();
    farm.nestd_ok(&["retry", &part.to_string()]);
    farm.wait_for_parts(PartState::Waiting, 1);
}

#[test]
fn a_lost_ledger_is_noticed_and_a_new_one_begun_from_what_the_folders_tell() {
    let (mut farm, _) = farm_and_backup();
    for suffix in ["", ".b3"] {
        fs::remove_file(farm.root().join(format!("state/nestd.db{suffix}"))).unwrap();
    }
    let refused = text(&farm.nestd(&["run"]));
    assert!(refused.contains("there is no ledger") && refused.contains("nestd restore"), "{refused}");
    let said = farm.nestd_ok(&["restore", "--empty"]);
    assert_eq!(said.matches("was published; its copies are taken in").count(), 2, "{said}");
    runs_and_prints_nothing_again(&mut farm);
}

#[test]
fn a_restore_is_refused_while_the_daemon_runs_and_from_what_is_no_whole_backup() {
    let farm = TestFarm::running(QUICK);
    let backup = farm.root().join("ledger.backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    assert!(!farm.nestd(&["backup", backup.to_str().unwrap()]).status.success(), "it overwrote a backup");
    let busy = farm.nestd(&["restore", backup.to_str().unwrap()]);
    assert!(!busy.status.success() && text(&busy).contains("another nestd"), "{}", text(&busy));
    let mut farm = farm;
    farm.stop();
    let before = fs::read(farm.root().join("state/nestd.db")).unwrap();
    let mut bytes = fs::read(&backup).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&backup, bytes).unwrap();
    let refused = farm.nestd(&["restore", backup.to_str().unwrap()]);
    assert!(!refused.status.success() && text(&refused).contains("is damaged"), "{}", text(&refused));
    assert_eq!(fs::read(farm.root().join("state/nestd.db")).unwrap(), before, "the ledger was touched");
}
