//! A ledger that is gone, or that somebody put there by hand: what is told is true, and what is asked for works.

use std::fs;

use nestd::ledger::PartState;

use super::support::{QUICK, TestFarm, block, wait_until_or};

/// A farm with one waiting part.
fn farm_with_waiting_part() -> TestFarm {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm
}

fn all_output(farm: &TestFarm, args: &[&str]) -> String {
    let output = farm.nestd(args);
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[test]
fn a_ledger_that_was_removed_is_told_truly_everywhere_and_the_saved_copy_is_put_back() {
    let mut farm = farm_with_waiting_part();
    let state = farm.root().join("state");
    for file in fs::read_dir(&state).unwrap().map(|entry| entry.unwrap().path()) {
        if file.file_name().unwrap().to_string_lossy().starts_with("nestd.db") {
            fs::remove_file(file).unwrap();
        }
    }
    wait_until_or(
        "it is noticed",
        20.0,
        || farm.log(),
        || farm.log().contains("was removed or replaced while nestd ran"),
    );
    let status_txt = farm.folder("inbox").join("STATUS.txt");
    let status_text = || fs::read_to_string(&status_txt).unwrap_or_default();
    wait_until_or("STATUS.txt tells it", 20.0, status_text, || status_text().contains("is not scanned"));
    assert!(status_text().contains("ATTENTION") && !status_text().contains("Nothing waits"), "{}", status_text());
    for command in [&["status"][..], &["show", "1"], &["flush", "test"]] {
        let said = all_output(&farm, command);
        assert!(said.contains("A daemon runs") && !said.contains("makes it"), "{said}");
    }
    farm.stop();
    assert!(
        status_text().contains("ATTENTION") && !status_text().contains("taken when it runs again"),
        "{}",
        status_text()
    );
    assert!(all_output(&farm, &["status"]).contains("No daemon runs, and none starts"));
    let said = all_output(&farm, &["check"]);
    let (_, rest) = said.split_once("nestd saved all that it knew as ").unwrap();
    let saved = rest.split_once(", which is newer").unwrap().0;
    farm.nestd_ok(&["restore", saved]);
    farm.start();
    wait_until_or("it is open", 20.0, || farm.log(), || farm.log().matches("The farm is open").count() == 2);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
}

#[test]
fn a_backup_that_was_copied_over_a_sealed_ledger_is_answered_with_what_works() {
    let mut farm = farm_with_waiting_part();
    let backup = farm.root().join("backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.drop_part("b.stl", &block(10.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
    fs::copy(&backup, farm.root().join("state/nestd.db")).unwrap();
    let said = all_output(&farm, &["check"]);
    assert!(said.contains("nestd restore FILE") && !said.contains("--repair"), "{said}");
    farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    farm.start();
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
}

#[test]
fn a_part_whose_file_is_gone_is_not_said_to_be_taken_back_by_retry() {
    let mut farm = farm_with_waiting_part();
    let backup = farm.root().join("backup");
    farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    farm.flush();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    let store = farm.root().join("state/store");
    let is_empty = || nestd::intake::files_below(&store).is_ok_and(|files| files.is_empty());
    wait_until_or("the store has forgotten it", 20.0, || farm.log(), is_empty);
    farm.stop();
    for kind in ["queue", "archive"] {
        for entry in fs::read_dir(farm.folder(kind)).unwrap().map(Result::unwrap) {
            if !entry.file_name().to_string_lossy().starts_with('.') {
                let path = entry.path();
                if path.is_dir() { fs::remove_dir_all(path).unwrap() } else { fs::remove_file(path).unwrap() }
            }
        }
    }
    let said = farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(said.contains("drop its file again") && !said.contains("nestd retry") && !said.contains(".."), "{said}");
    let said = all_output(&farm, &["check", "--deep"]);
    assert!(!said.contains("PROBLEM I4") && !said.contains("PROBLEM invariants: I4"), "{said}");
}
