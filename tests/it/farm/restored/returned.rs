//! A ledger that went back in time, and what appears afterwards: the same content under another name, folders that were
//! away, claims without a record.

use std::{fs, time::Duration};

use ledger::PartState;

use super::restore::{copy_ledger, hash_of, printed_copies, replace_ledger, text};
use crate::support::{MACHINE, QUICK, TestFarm, block, wait_until_or};

#[test]
fn the_same_content_under_another_name_is_printed_beside_the_first_after_a_restore() {
    for duplicates in ["accept", "warn"] {
        for is_published in [false, true] {
            let mut farm = TestFarm::running(&format!("{QUICK}duplicates = {duplicates:?}\n"));
            let backup = farm.root().join("ledger.backup");
            farm.drop_part("first_x2.stl", &block(20.0, 20.0, 20.0));
            farm.wait_for_parts(PartState::Waiting, 1);
            farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
            farm.drop_part("second_x3.stl", &block(20.0, 20.0, 20.0));
            let is_taken = || farm.parts(PartState::Waiting).iter().map(|part| part.owed.copies).sum::<u32>() == 5;
            wait_until_or("both are taken", 30.0, || farm.log(), is_taken);
            if is_published {
                farm.flush();
                farm.wait_for_queued(1);
                wait_until_or("nothing waits", 30.0, || farm.log(), || farm.parts(PartState::Batched).is_empty());
            }
            farm.stop();
            let output_text = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
            farm.start();
            let hash = hash_of(&block(20.0, 20.0, 20.0));
            let began = std::time::Instant::now();
            let mut count = 0;
            while began.elapsed() < Duration::from_secs(12) && (count < 5 || is_published) {
                let _ = farm.nestd(&["flush", MACHINE]);
                std::thread::sleep(Duration::from_millis(500));
                count = farm.queued().iter().map(|file| printed_copies(file)[&hash]).sum();
                if is_published && began.elapsed() > Duration::from_secs(4) {
                    break;
                }
            }
            let reported = output_text.lines().filter(|line| line.contains("LOOK AT")).collect::<String>();
            assert!(count <= 5, "{duplicates} {is_published}: {count} are printed\n{output_text}\n{}", farm.log());
            assert!(
                count == 5 || (reported.contains("second_x3.stl") || reported.contains(&hash)),
                "{duplicates} {is_published}: {count} of 5 are printed and nobody is told\n{output_text}\n{}",
                farm.log()
            );
        }
    }
}

#[test]
fn a_folder_that_was_away_is_held_against_the_ledger_when_it_comes_back() {
    for leaves_empty in [false, true] {
        let mut farm = TestFarm::running(QUICK);
        let copy = copy_ledger_with_a_part(&farm);
        let (store, kept) = (farm.root().join("state/store"), farm.root().join("kept-store"));
        copy_tree(&store, &kept);
        farm.flush();
        farm.wait_for_parts(PartState::Built, 1);
        farm.stop();
        // The printer has taken the build, the share with the archive is away, and the old state folder is put back.
        farm.queued().iter().for_each(|file| fs::remove_file(file).unwrap());
        let (archive, away) = (farm.folder("archive"), farm.root().join("away"));
        fs::rename(&archive, &away).unwrap();
        if leaves_empty {
            fs::create_dir(&archive).unwrap();
        }
        replace_ledger(&farm, &copy);
        copy_tree(&kept, &store);
        farm.start();
        let _ = farm.nestd(&["flush", MACHINE]);
        let is_reported = |words: &str| farm.nestd_ok(&["status"]).contains(words);
        let missing = || is_reported("The archive cannot be used");
        wait_until_or("it is told", 10.0, || farm.nestd_ok(&["status"]) + &farm.log(), missing);
        if leaves_empty {
            fs::remove_dir_all(&archive).unwrap();
        }
        fs::rename(&away, &archive).unwrap();
        let is_behind = || is_reported("older than the folders");
        wait_until_or("it is behind", 10.0, || farm.nestd_ok(&["status"]) + &farm.log(), is_behind);
        let _ = farm.nestd(&["flush", MACHINE]);
        std::thread::sleep(Duration::from_secs(2));
        assert!(farm.queued().is_empty(), "{leaves_empty}: printed twice\n{}", farm.log());
        farm.stop();
        farm.nestd_ok(&["check", "--deep", "--repair"]);
        farm.start();
        farm.wait_for_parts(PartState::Built, 1);
    }
}

/// A ledger in which a part waits.
fn copy_ledger_with_a_part(farm: &TestFarm) -> std::path::PathBuf {
    farm.drop_part("a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    copy_ledger(farm)
}

fn copy_tree(from: &std::path::Path, to: &std::path::Path) {
    for file in intake::files_below(from).unwrap() {
        let target = to.join(file.strip_prefix(from).unwrap());
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(file, target).unwrap();
    }
}

#[test]
fn a_claim_without_a_row_is_reported_once_it_is_old_and_no_daemon_runs() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let claim = farm.folder("inbox").join(".claimed/20260101T000000Z-1-left");
    fs::create_dir_all(&claim).unwrap();
    fs::write(claim.join("b.stl"), crate::support::stl(&block(9.0, 9.0, 9.0))).unwrap();
    let young = text(&farm.nestd(&["check"]));
    assert!(!young.contains("20260101T000000Z-1-left"), "a claim may be as old as a crash: {young}");
    let old = std::time::SystemTime::now() - Duration::from_secs(3600);
    fs::File::open(&claim).unwrap().set_modified(old).unwrap();
    let reported = farm.nestd(&["check"]);
    assert!(!reported.status.success() && text(&reported).contains("20260101T000000Z-1-left"), "{}", text(&reported));
    assert!(text(&reported).contains("start the daemon"), "{}", text(&reported));
}

#[test]
fn what_was_said_of_a_print_since_the_backup_is_named_with_the_command_that_says_it_again() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a_x3.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    fs::remove_file(farm.wait_for_queued(1).remove(0)).unwrap();
    farm.nestd_ok(&["outcome", "1", "printing"]);
    let backup = farm.root().join("ledger.backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    let again = ["outcome", "1", "complete", "--bad", "1=2"];
    farm.nestd_ok(&again);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let restored = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(restored.contains("said `nestd outcome 1 complete --bad 1=2`. Say it again"), "{restored}");
    assert!(!restored.contains("outcome 1 printing"), "the backup knows that: {restored}");
    assert_eq!(farm.parts(PartState::Waiting).len(), 0, "{restored}");
    farm.nestd_ok(&again);
    assert_eq!(farm.parts(PartState::Waiting)[0].owed.copies, 3);
    let backup = farm.root().join("newer.backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    let restored = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(!restored.contains("nestd outcome"), "it is known now: {restored}");
}
