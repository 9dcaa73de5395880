//! `nestd check --deep`: the invariants hold on a farm after work, and each violation is found and named.

use std::{fs, path::PathBuf};

use farm::{AskedCopies, InvariantExpectations};
use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, stl, wait_until};

/// A stopped farm that has built a part, has refused one and holds a waiting one.
fn farm_after_work() -> TestFarm {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("built_x2.stl", &block(20.0, 20.0, 10.0));
    farm.drop_bytes("refused.stl", b"solid nonsense\nendsolid\n");
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.wait_for_parts(PartState::Refused, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.drop_part("waits.stl", &block(10.0, 20.0, 30.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    wait_until("the claims are ended", 10.0, || {
        fs::read_dir(farm.folder("inbox").join(".claimed")).unwrap().count() == 0
    });
    farm.stop();
    farm
}

fn violations_at_rest(farm: &TestFarm) -> Vec<String> {
    let files = [stl(&block(20.0, 20.0, 10.0)), b"solid nonsense\nendsolid\n".to_vec(), stl(&block(10.0, 20.0, 30.0))];
    let dropped = files.iter().map(|bytes| (blake3::hash(bytes).to_hex().to_string(), 1)).collect();
    farm.broken_invariants(&InvariantExpectations { at_rest: true, dropped, ..InvariantExpectations::default() })
}

fn only_file(folder: PathBuf) -> PathBuf {
    let mut files = intake::files_below(&folder).unwrap();
    // Skips the record of a build and the marker of a folder, which nestd writes for itself.
    files.retain(|file| !file.ends_with(".nestd-build.json") && !file.ends_with(".nestd-owner"));
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

#[test]
fn the_invariants_hold_on_a_farm_that_has_worked_and_what_breaks_one_is_named() {
    let farm = farm_after_work();
    assert_eq!(violations_at_rest(&farm), Vec::<String>::new());
    assert!(farm.nestd_ok(&["check", "--deep"]).contains("I1 to I5 hold"));

    let waiting = farm.parts(PartState::Waiting).remove(0);
    let stored = farm.root().join("state/store").join(&waiting.file.content_hash[..2]).join(&waiting.file.content_hash);
    let whole = fs::read(&stored).unwrap();
    fs::write(&stored, [&whole[..whole.len() - 1], b"!"].concat()).unwrap();
    let found = violations_at_rest(&farm);
    assert!(found.len() == 1 && found[0].starts_with("I1: part 3 (waits.stl) is waiting"), "{found:?}");
    let output = farm.nestd(&["check", "--deep"]);
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.code() == Some(1) && output_text.contains("-> put the file with the BLAKE3"),
        "{output_text}"
    );
    fs::write(&stored, whole).unwrap();

    let original = only_file(farm.folder("archive"));
    let kept = fs::read(&original).unwrap();
    fs::remove_file(&original).unwrap();
    let found = violations_at_rest(&farm);
    assert!(found.len() == 1 && found[0].contains("its original is not in"), "{found:?}");
    // People may remove files from an archive: that is a warning, not a failure.
    assert!(farm.nestd_ok(&["check", "--deep"]).contains("WARNING"));
    fs::write(&original, kept).unwrap();

    let refused = farm.folder("error").join("refused.stl");
    fs::rename(&refused, farm.root().join("elsewhere")).unwrap();
    let found = violations_at_rest(&farm);
    assert!(found.len() == 1 && found[0].contains("not in the error folder"), "{found:?}");
    fs::rename(farm.root().join("elsewhere"), &refused).unwrap();

    let build = farm.queued().remove(0);
    let copies_asked = |wanted| {
        let built = blake3::hash(&stl(&block(20.0, 20.0, 10.0))).to_hex().to_string();
        let asked = AskedCopies { wanted, bad: 0 };
        let waiting = (waiting.file.content_hash.clone(), AskedCopies { wanted: 1, bad: 0 });
        farm.broken_invariants(&InvariantExpectations {
            asked: Some([(built, asked), waiting].into()),
            ..InvariantExpectations::default()
        })
    };
    assert_eq!(copies_asked(2), Vec::<String>::new());
    let found = copies_asked(1);
    assert!(found.len() == 1 && found[0].starts_with("I5: built_x2.stl (part 1): 1 copies wanted, 2 in"), "{found:?}");
    fs::copy(&build, build.with_file_name("copied.build.3mf")).unwrap();
    let found = violations_at_rest(&farm);
    assert!(
        found.len() == 1 && found[0].starts_with("I3: ") && found[0].contains("no build of the ledger"),
        "{found:?}"
    );
    fs::remove_file(build.with_file_name("copied.build.3mf")).unwrap();
    let mut bytes = fs::read(&build).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&build, bytes).unwrap();
    let found = violations_at_rest(&farm);
    assert!(found.iter().any(|text| text.contains("not the file that was proved as build 1")), "{found:?}");
}

#[test]
fn a_cancelled_part_that_is_taken_back_leaves_no_second_copy_in_the_error_folder() {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.nestd_ok(&["cancel", "1"]);
    farm.wait_for_parts(PartState::Refused, 1);
    assert_eq!(farm.broken_invariants(&InvariantExpectations::default()), Vec::<String>::new());
    farm.nestd_ok(&["retry", "1"]);
    farm.wait_for_parts(PartState::Waiting, 1);
    wait_until("it is gone from the error folder", 5.0, || {
        let files = intake::files_below(&farm.folder("error")).unwrap();
        files.iter().all(|file| file.ends_with(".nestd-owner"))
    });
}
