//! A backup is copied over the ledger by hand after a part was cancelled or taken back: a cancelled part is not
//! printed, and a part that was taken back is put where people see it.

use std::{fs, path::PathBuf, time::Duration};

use intake::ContentStore;
use ledger::{PartId, PartState};
use solids::Mesh;

use super::restore::{copy_ledger, replace_ledger, text};
use crate::support::{MACHINE, QUICK, TestFarm, block, leaning_block, stl};

const NAMED: &str = "the last decision about a.stl";

fn farm_with_a_part() -> (TestFarm, PartId) {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1)[0].id;
    (farm, part)
}

fn order(farm: &TestFarm, what: &str, part: PartId, state: PartState) {
    farm.nestd_ok(&[what, &part.to_string()]);
    farm.wait_for_parts(state, 1);
}

/// The only note in the store: its path, and the number of decisions in it.
fn note(farm: &TestFarm) -> (PathBuf, u32) {
    let store = ContentStore::from_dir(farm.root().join("state/store"));
    let kept = store.list_contents().unwrap();
    assert_eq!(kept.len(), 1, "{kept:?}");
    let (hash, content) = kept.iter().next().unwrap();
    let claims: Vec<_> = content.claims.iter().collect();
    assert_eq!(claims.len(), 1, "{kept:?}");
    (store.note_path(hash, claims[0].0).unwrap(), *claims[0].1)
}

/// Asserts that the start is refused, that the check says why and the repair what to look at; then the daemon starts.
fn is_refused_and_mended(farm: &mut TestFarm, part: &Mesh) {
    let refused = farm.nestd(&["run"]);
    let output_text = text(&refused);
    assert!(!refused.status.success() && output_text.contains("older than the folders"), "{output_text}");
    assert!(output_text.contains(NAMED) && output_text.contains("--repair"), "{output_text}");
    for args in [vec!["check"], vec!["check", "--deep"]] {
        let output = farm.nestd(&args);
        assert!(!output.status.success() && text(&output).contains(NAMED), "{args:?}: {}", text(&output));
    }
    let output_text = farm.nestd_ok(&["check", "--deep", "--repair"]);
    assert!(
        output_text.contains("LOOK AT: part 1 (a.stl)") && output_text.contains("`nestd retry 1` takes it back"),
        "{output_text}"
    );
    assert!(farm.nestd_ok(&["check", "--deep"]).contains("I1 to I5 hold"));
    assert_eq!(farm.parts(PartState::Refused).len(), 1);
    let file = farm.folder("error").join("part-1/a.stl");
    assert_eq!(fs::read(file).unwrap(), stl(part), "the file is to be seen");
    farm.start();
    let _ = farm.nestd(&["flush", MACHINE]);
    std::thread::sleep(Duration::from_secs(2));
    assert!(farm.queued().is_empty(), "it is printed\n{}", farm.log());
    order(farm, "retry", PartId(1), PartState::Waiting);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    assert!(farm.nestd_ok(&["check", "--deep"]).contains("I1 to I5 hold"));
}

#[test]
fn a_part_that_was_cancelled_is_not_printed_by_an_older_ledger() {
    // With its copy in the error folder, and after a person has removed that copy.
    for is_tidied in [false, true] {
        let (mut farm, part) = farm_with_a_part();
        let copy = copy_ledger(&farm);
        order(&farm, "cancel", part, PartState::Refused);
        farm.stop();
        if is_tidied {
            fs::remove_dir_all(farm.folder("error").join("part-1")).unwrap();
        }
        replace_ledger(&farm, &copy);
        is_refused_and_mended(&mut farm, &block(20.0, 20.0, 20.0));
    }
}

#[test]
fn a_part_that_was_taken_back_is_shown_by_an_older_ledger() {
    let (mut farm, part) = farm_with_a_part();
    order(&farm, "cancel", part, PartState::Refused);
    let copy = copy_ledger(&farm);
    order(&farm, "retry", part, PartState::Waiting);
    farm.stop();
    replace_ledger(&farm, &copy);
    is_refused_and_mended(&mut farm, &block(20.0, 20.0, 20.0));
}

#[test]
fn a_part_that_was_taken_and_cancelled_is_not_printed_by_a_ledger_that_never_knew_it() {
    let mut farm = TestFarm::running(QUICK);
    let copy = copy_ledger(&farm);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1)[0].id;
    order(&farm, "cancel", part, PartState::Refused);
    farm.stop();
    fs::remove_dir_all(farm.folder("error").join("part-1")).unwrap();
    replace_ledger(&farm, &copy);
    let output_text = farm.nestd_ok(&["check", "--deep", "--repair"]);
    assert!(output_text.contains("LOOK AT: part 1 (a.stl) is not printed"), "{output_text}");
    assert!(farm.nestd_ok(&["check", "--deep"]).contains("I1 to I5 hold"));
    farm.start();
    farm.flush();
    std::thread::sleep(Duration::from_secs(2));
    assert!(farm.queued().is_empty() && farm.parts(PartState::Refused).len() == 1, "{}", farm.log());
}

#[test]
fn a_build_that_was_being_nested_is_given_up_where_its_part_was_decided_of_since() {
    let mut farm = TestFarm::running(&QUICK.replace("final_secs = 0.5", "final_secs = 600"));
    farm.drop_part("a.stl", &leaning_block());
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Batched, 1);
    let copy = copy_ledger(&farm);
    farm.kill();
    farm.write_profile(MACHINE, QUICK);
    // The state after the build failed and the part was cancelled.
    let (path, _) = note(&farm);
    fs::rename(&path, path.with_extension("1.json")).unwrap();
    replace_ledger(&farm, &copy);
    is_refused_and_mended(&mut farm, &leaning_block());
}

#[test]
fn a_daemon_that_was_killed_before_it_could_mark_starts_as_ever() {
    let (mut farm, part) = farm_with_a_part();
    for (what, state, count) in [("cancel", PartState::Refused, 1), ("retry", PartState::Waiting, 2)] {
        let (before, _) = note(&farm);
        let asked = |note: &PathBuf| {
            serde_json::from_str::<serde_json::Value>(&fs::read_to_string(note).unwrap()).unwrap()["part"].clone()
        };
        let dropped = asked(&before);
        order(&farm, what, part, state);
        farm.kill();
        let (after, marked) = note(&farm);
        assert_eq!((marked, asked(&after)), (count, dropped));
        fs::rename(after, before).unwrap();
        assert!(farm.nestd(&["check", "--deep"]).status.success());
        farm.start();
        farm.wait_for_parts(state, 1);
    }
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
    assert!(ContentStore::from_dir(farm.root().join("state/store")).list_contents().unwrap().is_empty());
}

#[test]
fn a_part_that_waits_is_not_refused_because_another_with_its_shape_was_cancelled_before() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    let part = farm.wait_for_parts(PartState::Waiting, 1)[0].id;
    order(&farm, "cancel", part, PartState::Refused);
    let copy = copy_ledger(&farm);
    farm.drop_part("b.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let reason = || std::fs::read_to_string(farm.folder("error").join("part-1/a.stl.reason.txt")).unwrap();
    let before = reason();
    for begin in [&["restore", copy.to_str().unwrap()][..], &["restore", "--empty"]] {
        let restored = farm.nestd_ok(begin);
        assert!(restored.contains("b.stl, 1 copy") && restored.contains("it is taken in and waits"), "{restored}");
        assert!(!restored.contains("b.stl) is not printed"), "{restored}");
        if begin[1] != "--empty" {
            assert_eq!(reason(), before, "of the other part");
        }
    }
    farm.start();
    assert_eq!(farm.wait_for_parts(PartState::Waiting, 1)[0].name, "b.stl");
}
