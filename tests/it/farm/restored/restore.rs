//! Backup and restore as an operator does them: nothing that was published since the backup is printed again.

use std::{collections::BTreeMap, fs, path::PathBuf, process::Output};

use ledger::PartState;

use crate::support::{MACHINE, QUICK, TestFarm, block, stl, wait_until};

pub fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// A stopped farm and its backup. Since the backup, parts `a` and `b` were published; `c` waits. The printer has taken the first build.
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

/// The number of copies of each content in a build file.
pub fn printed_copies(file: &std::path::Path) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for placed in build_file::read_build(file, &Default::default()).unwrap() {
        *counts.entry(placed.source_hash.unwrap()).or_default() += 1;
    }
    counts
}

pub fn hash_of(mesh: &solids::Mesh) -> String {
    blake3::hash(&stl(mesh)).to_hex().to_string()
}

/// Lets the farm run, and asserts that no copy of `a` and `b` is printed again, and that all copies of `c` are.
fn runs_and_prints_nothing_again(farm: &mut TestFarm) {
    let parts = farm.parts(PartState::Built);
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["a_x2.stl", "b_x3.stl"], "{}", farm.log());
    let before = farm.queued();
    farm.start();
    farm.drop_part("new.stl", &block(23.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 4);
    let now = farm.wait_for_queued(before.len() + 1);
    let new = now.iter().find(|file| !before.contains(file)).unwrap();
    let wanted = [(hash_of(&block(22.0, 20.0, 20.0)), 4), (hash_of(&block(23.0, 20.0, 20.0)), 1)];
    assert_eq!(
        printed_copies(new),
        BTreeMap::from(wanted),
        "what waited with its copies, and what was dropped after the restore"
    );
    let numbers = build_file::read_build(new, &Default::default()).unwrap();
    let number =
        |name: &str| numbers.iter().find(|p| p.source_hash.as_deref() == Some(name)).unwrap().part_number.clone();
    let fresh = number(&hash_of(&block(23.0, 20.0, 20.0))).unwrap();
    assert!(fresh.parse::<i64>().unwrap() > 3, "a number was given out twice");
    assert_eq!(farm.query_ledger(async |ledger| ledger.find_inconsistencies().await.unwrap()), Vec::<String>::new());
    farm.stop();
}

#[test]
fn a_restored_backup_learns_from_the_folders_what_was_published_since() {
    let (mut farm, backup) = farm_and_backup();
    let output_text = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert_eq!(output_text.matches("was published; its copies are taken in").count(), 2, "{output_text}");
    assert!(
        output_text.contains("c_x4.stl, 4 copies, for test) was taken after the backup was made"),
        "c is not told: {output_text}"
    );
    assert!(output_text.contains("The one before is kept as"), "{output_text}");
    let history = farm.nestd_ok(&["history", "--json"]);
    assert_eq!(history.matches("\"height_mm\": 19.99").count(), 2, "the heights are back: {history}");
    let deep = farm.nestd_ok(&["check", "--deep"]);
    assert!(deep.contains("I1 to I5 hold"), "{deep}");
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
    let output = fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap();
    assert!(output.contains("does not run") && output.contains("ATTENTION") && output.contains("--repair"), "{output}");
    let output_text = farm.nestd_ok(&["check", "--deep", "--repair"]);
    assert_eq!(output_text.matches("was published; its copies are taken in").count(), 2, "{output_text}");
    runs_and_prints_nothing_again(&mut farm);
}

#[test]
fn without_records_the_build_files_in_the_queue_tell() {
    let (mut farm, backup) = farm_with_a_published();
    let before = fs::read(farm.root().join("state/nestd.db")).unwrap();
    let refused = text(&farm.nestd(&["restore", backup.to_str().unwrap()]));
    assert!(refused.contains("archive/test cannot be looked at") && refused.contains("--new-folder"), "{refused}");
    assert_eq!(fs::read(farm.root().join("state/nestd.db")).unwrap(), before, "the ledger was touched");
    let archive = farm.folder("archive");
    let output_text = farm.nestd_ok(&["restore", backup.to_str().unwrap(), "--new-folder", archive.to_str().unwrap()]);
    assert_eq!(output_text.matches("was published; its copies are taken in").count(), 1, "{output_text}");
    assert_eq!(farm.parts(PartState::Built).len(), 1);
    // An empty marker: a person accepts the folder as it is.
    fs::write(archive.join(".nestd-owner"), "").unwrap();
    farm.start();
    farm.flush();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert_eq!(farm.queued().len(), 1, "printed twice\n{}", farm.log());
}

/// Makes a backup while a part of two copies waits, then publishes it and stops the daemon. Returns the backup.
fn publish_after_backup(farm: &mut TestFarm) -> PathBuf {
    let backup = farm.root().join("ledger.backup");
    farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    backup
}

/// A farm that published a build after its backup; the record is gone, as in an emptied archive.
fn farm_with_a_published() -> (TestFarm, PathBuf) {
    let mut farm = TestFarm::running(QUICK);
    let backup = publish_after_backup(&mut farm);
    // The old folder stays, so that the new one gets another inode.
    fs::rename(farm.folder("archive"), farm.root().join("archive-before")).unwrap();
    fs::create_dir(farm.folder("archive")).unwrap();
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
    let output_text = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(output_text.contains("LOOK AT: part") && output_text.contains("refused or cancelled"), "{output_text}");
    assert_eq!(farm.parts(PartState::Refused).len(), 1);
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
    let output_text = farm.nestd_ok(&["restore", "--empty"]);
    assert_eq!(output_text.matches("was published; its copies are taken in").count(), 2, "{output_text}");
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

/// A copy of the current ledger, which a test puts over the ledger by hand later.
pub fn copy_ledger(farm: &TestFarm) -> PathBuf {
    let copy = farm.root().join("copied.db");
    farm.nestd_ok(&["backup", copy.to_str().unwrap()]);
    copy
}

pub fn replace_ledger(farm: &TestFarm, copy: &std::path::Path) {
    let ledger = farm.root().join("state/nestd.db");
    for suffix in ["-wal", "-shm", ".b3"] {
        let _ = fs::remove_file(format!("{}{suffix}", ledger.display()));
    }
    fs::copy(copy, ledger).unwrap();
}

#[test]
fn a_ledger_rolled_back_with_no_build_in_between_forgets_no_order() {
    let mut farm = TestFarm::running(QUICK);
    let copy = copy_ledger(&farm);
    farm.drop_bytes("kit/order.csv", b"file;copies\none.stl;3\n");
    farm.drop_part("kit/one.stl", &block(20.0, 20.0, 20.0));
    farm.drop_bytes("two.stl.toml", b"copies = 2\nnote = \"by hand\"\n");
    farm.drop_part("two.stl", &block(21.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
    replace_ledger(&farm, &copy);
    let refused = text(&farm.nestd(&["run"]));
    assert!(refused.contains("older than the folders") && refused.contains("--repair"), "{refused}");
    for args in [vec!["check"], vec!["check", "--deep"]] {
        let output = farm.nestd(&args);
        assert!(
            !output.status.success() && text(&output).contains("kit/one.stl (3 copies for test)"),
            "{}",
            text(&output)
        );
        assert!(text(&output).contains("two.stl (2 copies for test)"), "{}", text(&output));
    }
    let output_text = farm.nestd_ok(&["check", "--deep", "--repair"]);
    assert!(output_text.contains("kit/one.stl, 3 copies, for test) was taken after"), "{output_text}");
    farm.start();
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let known = |name: &str| parts.iter().find(|part| part.name == name).unwrap();
    assert_eq!((known("one.stl").owed.copies, known("one.stl").terms.order_name.as_str()), (3, "kit"));
    assert_eq!((known("two.stl").owed.copies, known("two.stl").terms.note.as_str()), (2, "by hand"));
    farm.flush();
    farm.wait_for_parts(PartState::Built, 2);
    let wanted = [(hash_of(&block(20.0, 20.0, 20.0)), 3), (hash_of(&block(21.0, 20.0, 20.0)), 2)];
    assert_eq!(printed_copies(&farm.wait_for_queued(1)[0]), BTreeMap::from(wanted));
    farm.stop();
    let store = intake::ContentStore::from_dir(farm.root().join("state/store"));
    assert!(store.list_contents().unwrap().is_empty(), "what is built leaves no note: {:?}", store.list_contents());
}

#[test]
fn a_write_ahead_log_that_was_removed_with_its_index_forgets_no_order() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    wait_until("no claim is left", 30.0, || fs::read_dir(farm.folder("inbox").join(".claimed")).unwrap().count() == 0);
    farm.kill();
    for suffix in ["-wal", "-shm"] {
        fs::remove_file(farm.root().join(format!("state/nestd.db{suffix}"))).unwrap();
    }
    let refused = text(&farm.nestd(&["run"]));
    assert!(refused.contains("older than the folders") || refused.contains("nestd restore"), "{refused}");
    if refused.contains("--repair") {
        farm.nestd_ok(&["check", "--deep", "--repair"]);
        farm.start();
        assert_eq!(farm.wait_for_parts(PartState::Waiting, 1)[0].owed.copies, 2);
    }
}

#[test]
fn a_stored_file_of_which_nothing_is_noted_is_reported_by_name_and_kept() {
    let mut farm = TestFarm::running(QUICK);
    let copy = copy_ledger(&farm);
    farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    replace_ledger(&farm, &copy);
    let store = intake::ContentStore::from_dir(farm.root().join("state/store"));
    let hash = hash_of(&block(20.0, 20.0, 20.0));
    for claim in store.list_contents().unwrap()[&hash].claims.keys() {
        fs::remove_file(store.note_path(&hash, claim).unwrap()).unwrap();
    }
    assert!(!farm.nestd(&["run"]).status.success());
    let output_text = farm.nestd_ok(&["check", "--deep", "--repair"]);
    assert!(output_text.contains("LOOK AT") && output_text.contains(&format!("state/unknown/{hash}")), "{output_text}");
    assert_eq!(fs::read(farm.root().join("state/unknown").join(&hash)).unwrap(), stl(&block(20.0, 20.0, 20.0)));
    farm.start();
    farm.drop_part("new.stl", &block(9.0, 9.0, 9.0));
    farm.wait_for_parts(PartState::Waiting, 1);
}

#[test]
fn a_ledger_that_is_gone_is_a_problem_to_check() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    for suffix in ["", ".b3"] {
        fs::remove_file(farm.root().join(format!("state/nestd.db{suffix}"))).unwrap();
    }
    for args in [vec!["check"], vec!["check", "--deep"]] {
        let output = farm.nestd(&args);
        assert!(!output.status.success() && text(&output).contains("there is no ledger"), "{}", text(&output));
        assert!(text(&output).contains("nestd restore"), "{}", text(&output));
    }
    let refused = text(&farm.nestd(&["run"]));
    assert!(refused.contains("there is no ledger") && refused.contains("nestd restore"), "{refused}");
}

#[test]
fn a_part_that_was_taken_back_after_the_backup_is_refused_where_people_see_it() {
    let mut farm = TestFarm::running(QUICK);
    let backup = farm.root().join("ledger.backup");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1)[0].id;
    farm.nestd_ok(&["cancel", &part.to_string()]);
    farm.wait_for_parts(PartState::Refused, 1);
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.nestd_ok(&["retry", &part.to_string()]);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let output_text = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(
        output_text.contains("LOOK AT: part 1 (a.stl)") && output_text.contains("`nestd retry 1` takes it back"),
        "{output_text}"
    );
    let file = farm.folder("error").join("part-1/a.stl");
    assert_eq!(fs::read(&file).unwrap(), stl(&block(20.0, 20.0, 20.0)), "the file is to be seen");
    assert!(farm.nestd_ok(&["check", "--deep"]).contains("I1 to I5 hold"));
    farm.start();
    farm.nestd_ok(&["retry", "1"]);
    farm.wait_for_parts(PartState::Waiting, 1);
    assert!(!file.exists(), "it is in one place only");
}

#[test]
fn a_ledger_that_is_removed_or_replaced_is_left_at_once_and_saved() {
    for replaced in [false, true] {
        let mut farm = TestFarm::running(QUICK);
        let copy = copy_ledger(&farm);
        farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
        farm.wait_for_parts(PartState::Waiting, 1);
        let ledger = farm.root().join("state/nestd.db");
        match replaced {
            true => fs::rename(&copy, &ledger).unwrap(),
            false => fs::remove_file(&ledger).unwrap(),
        }
        wait_until("the daemon notices it", 5.0, || {
            farm.log().contains("removed, replaced or overwritten while nestd ran")
        });
        farm.drop_part("b.stl", &block(21.0, 20.0, 20.0));
        std::thread::sleep(std::time::Duration::from_millis(1500));
        assert!(farm.folder("inbox").join("b.stl").exists(), "it takes files into nowhere");
        let output = fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap();
        assert!(output.contains("ATTENTION") && output.contains("nestd restore"), "{output}");
        farm.stop();
        let saved = fs::read_dir(farm.root().join("state")).unwrap().map(|entry| entry.unwrap().path());
        let is_saved = |file: &PathBuf| file.to_string_lossy().contains(".saved-") && !file.ends_with(".b3");
        let saved = saved.filter(is_saved).find(|file| file.extension().is_none_or(|end| end != "b3")).unwrap();
        farm.nestd_ok(&["restore", saved.to_str().unwrap()]);
        farm.start();
        let parts = farm.wait_for_parts(PartState::Waiting, 2);
        assert_eq!(parts.iter().map(|part| part.owed.copies).sum::<u32>(), 3);
    }
}

#[test]
fn what_a_returning_machine_shows_is_compared_with_the_ledger_at_a_reload() {
    let mut farm = TestFarm::running(QUICK);
    farm.write_profile("other", QUICK);
    farm.reload();
    let backup = publish_after_backup(&mut farm);
    // Its machine is not configured while the ledger is restored, and comes back by a reload.
    let profile = farm.root().join(format!("config/profiles/{MACHINE}.toml"));
    fs::rename(&profile, farm.root().join("kept.toml")).unwrap();
    farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    farm.start();
    std::thread::sleep(std::time::Duration::from_millis(800));
    fs::rename(farm.root().join("kept.toml"), &profile).unwrap();
    farm.reload();
    wait_until("it is told", 10.0, || farm.nestd_ok(&["status"]).contains("older than the folders"));
    let _ = farm.nestd(&["flush", MACHINE]);
    std::thread::sleep(std::time::Duration::from_millis(3000));
    assert_eq!(farm.queued().len(), 1, "printed twice\n{}", farm.log());
    farm.stop();
    farm.nestd_ok(&["check", "--deep", "--repair"]);
    farm.start();
    farm.wait_for_parts(PartState::Built, 1);
}
