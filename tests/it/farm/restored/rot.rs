//! Bytes that change after nestd wrote them: nestd publishes only the proved bytes, and reads only the dropped ones.

use std::{
    fs,
    path::{Path, PathBuf},
};

use ledger::{BuildRow, BuildState, PartState};

use crate::support::{MACHINE, QUICK, TestFarm, block, wait_until, wait_until_or};

/// The one build in a state.
fn build_in(farm: &TestFarm, state: BuildState) -> Option<BuildRow> {
    farm.query_ledger(async |ledger| ledger.builds_in_state(state).await.unwrap()).pop()
}

/// A farm with a proved build whose publishing is blocked by a folder in the place of its record in the archive.
/// Returns that folder and the staged file.
fn farm_with_held_publishing() -> (TestFarm, PathBuf, PathBuf) {
    let farm = TestFarm::running(&QUICK.replace("final_secs = 0.5", "final_secs = 3"));
    farm.drop_part("ring_x3.stl", &block(20.0, 15.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    wait_until_or("a build is nested", 30.0, || farm.log(), || build_in(&farm, BuildState::Nesting).is_some());
    let build = build_in(&farm, BuildState::Nesting).unwrap();
    let name = build_file::build_file_name(
        build.times.nesting_at.unwrap().0,
        MACHINE,
        build.id.0.unsigned_abs(),
        Default::default(),
    );
    let record = farm.folder("archive").join(name.strip_suffix(".build.3mf").unwrap()).join(".nestd-build.json");
    fs::create_dir_all(&record).unwrap();
    wait_until_or("it is proved", 30.0, || farm.log(), || build_in(&farm, BuildState::Verified).is_some());
    wait_until_or("publishing fails", 30.0, || farm.log(), || farm.log().contains(".nestd-build.json"));
    let staged = farm.folder("queue").join(format!(".{name}.part"));
    assert!(staged.exists() && farm.queued().is_empty());
    (farm, record, staged)
}

/// Asserts that the build is published once, and that its visible file is the proved one.
fn assert_published_whole(farm: &TestFarm) {
    let file = &farm.wait_for_queued(1)[0];
    wait_until_or("its row says so", 30.0, || farm.log(), || build_in(farm, BuildState::Published).is_some());
    let row = build_in(farm, BuildState::Published).unwrap();
    assert_eq!(row.staged.file_hash.unwrap(), blake3::hash(&fs::read(file).unwrap()).to_hex().to_string());
    assert_eq!(farm.queued().len(), 1);
    farm.assert_nothing_lost_or_doubled();
    assert_eq!(farm.broken_invariants(&Default::default()), [""; 0]);
}

#[test]
fn a_staged_build_that_somebody_removed_while_publishing_was_held_up_is_written_again() {
    let (farm, record, staged) = farm_with_held_publishing();
    fs::remove_file(&staged).unwrap();
    fs::remove_dir(&record).unwrap();
    assert_published_whole(&farm);
}

#[test]
fn a_staged_build_that_is_not_the_proved_one_any_more_is_written_again() {
    let spoil: [fn(&Path); 3] = [
        |file| {
            let bytes = fs::read(file).unwrap();
            fs::write(file, &bytes[..bytes.len() / 2]).unwrap();
        },
        |file| {
            let mut bytes = fs::read(file).unwrap();
            let at = bytes.len() / 2;
            bytes[at] ^= 1;
            fs::write(file, bytes).unwrap();
        },
        // The staged pick list, by which people sort the printed parts.
        |file| {
            let staged = file.to_string_lossy().replace(".build.3mf.part", ".parts.csv.part");
            fs::write(staged, "another").unwrap();
        },
    ];
    for spoil in spoil {
        let (farm, record, staged) = farm_with_held_publishing();
        spoil(&staged);
        fs::remove_dir(&record).unwrap();
        assert_published_whole(&farm);
        let list = farm.queued()[0].to_string_lossy().replace(".build.3mf", ".parts.csv");
        assert!(fs::read_to_string(list).unwrap().contains("ring_x3.stl"));
    }
}

#[test]
fn a_staged_build_that_was_spoilt_while_the_daemon_was_down_is_written_again() {
    let (mut farm, record, staged) = farm_with_held_publishing();
    farm.kill();
    let bytes = fs::read(&staged).unwrap();
    fs::write(&staged, &bytes[..bytes.len() / 2]).unwrap();
    fs::remove_dir(&record).unwrap();
    farm.start();
    assert_published_whole(&farm);
}

#[test]
fn a_staged_build_that_was_removed_while_its_name_was_taken_is_written_again() {
    let (farm, record, staged) = farm_with_held_publishing();
    let name = staged.file_name().unwrap().to_string_lossy();
    let visible = staged.with_file_name(name.trim_start_matches('.').trim_end_matches(".part"));
    fs::write(&visible, "somebody else's").unwrap();
    fs::remove_dir(&record).unwrap();
    wait_until_or(
        "its name is taken",
        30.0,
        || farm.log(),
        || farm.log().contains("has the name of the build: take it out"),
    );
    fs::remove_file(&staged).unwrap();
    std::thread::sleep(std::time::Duration::from_secs(3));
    assert!(build_in(&farm, BuildState::Published).is_none(), "somebody else's file is no build of ours");
    fs::remove_file(&visible).unwrap();
    wait_until("the other file is gone", 5.0, || !visible.exists() || farm.queued().len() == 1);
    assert_published_whole(&farm);
}

/// The path of the only stored file.
fn stored_file(farm: &TestFarm) -> PathBuf {
    let hash = farm.query_ledger(async |ledger| ledger.drop_counts_by_hash().await.unwrap())[0].0.clone();
    farm.root().join("state/store").join(&hash[..2]).join(hash)
}

fn attention(farm: &TestFarm) -> String {
    fs::read_to_string(farm.root().join("state/attention.json")).unwrap_or_default()
}

/// Volumes of the printed parts, rounded, mm3.
fn printed_volumes(farm: &TestFarm) -> Vec<u64> {
    let placed = farm.queued().into_iter().flat_map(|file| build_file::read_build(&file, &Default::default()).unwrap());
    let mut volumes: Vec<u64> = placed.map(|item| item.mesh.volume_mm3().round() as u64).collect();
    volumes.sort_unstable();
    volumes
}

#[test]
fn a_stored_file_that_rotted_is_not_printed_and_the_same_file_dropped_again_heals_it() {
    let spoil: [fn(&Path); 3] = [
        // Another part in a file of the same length, 12 mm high instead of 10: it was printed before.
        |file| fs::write(file, crate::support::stl(&block(20.0, 15.0, 12.0))).unwrap(),
        |file| fs::write(file, "").unwrap(),
        |file| fs::remove_file(file).unwrap(),
    ];
    for spoil in spoil {
        let mut farm = TestFarm::running(QUICK);
        let ring = block(20.0, 15.0, 10.0);
        farm.drop_part("ring_x2.stl", &ring);
        farm.wait_for_parts(PartState::Waiting, 1);
        let file = stored_file(&farm);
        farm.stop();
        spoil(&file);
        farm.start();
        wait_until_or("it is asked for again", 40.0, || farm.log(), || attention(&farm).contains("file-damaged"));
        farm.drop_part("plate.stl", &block(30.0, 20.0, 5.0));
        farm.wait_for_parts(PartState::Waiting, 2);
        farm.flush();
        farm.wait_for_queued(1);
        assert_eq!(printed_volumes(&farm), [3000], "others go on, and nothing wrong is printed");
        // The good copy; its name says another number of copies, but the drop is no new order.
        farm.drop_part("again_x7.stl", &ring);
        wait_until_or("it is healed", 30.0, || farm.log(), || !attention(&farm).contains("file-damaged"));
        std::thread::sleep(std::time::Duration::from_secs(1));
        farm.flush();
        farm.wait_for_queued(2);
        assert_eq!(printed_volumes(&farm), [3000, 3000, 3000]);
        wait_until("both are built", 20.0, || farm.parts(PartState::Built).len() == 2);
        farm.assert_nothing_lost_or_doubled();
        assert_eq!(farm.broken_invariants(&Default::default()), [""; 0]);
    }
}

#[test]
fn a_file_that_rots_while_its_build_is_nested_leaves_the_build_and_the_others_are_printed() {
    let farm = TestFarm::running(&QUICK.replace("final_secs = 0.5", "final_secs = 3"));
    farm.drop_part("ring.stl", &block(20.0, 15.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let file = stored_file(&farm);
    farm.drop_part("plate.stl", &block(30.0, 20.0, 4.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.flush();
    wait_until_or("a build is nested", 30.0, || farm.log(), || build_in(&farm, BuildState::Nesting).is_some());
    fs::write(&file, crate::support::stl(&block(20.0, 15.0, 12.0))).unwrap();
    farm.wait_for_queued(1);
    assert_eq!(printed_volumes(&farm), [2400]);
    wait_until_or("it is asked for again", 40.0, || farm.log(), || attention(&farm).contains("file-damaged"));
    let aside = fs::read_dir(farm.root().join("state/damaged")).unwrap().count();
    assert_eq!(aside, 1, "what was damaged is kept");
    // Cancelling the part instead ends it, and the alert.
    farm.nestd_ok(&["cancel", "1"]);
    wait_until_or("nobody is asked any more", 40.0, || farm.log(), || !attention(&farm).contains("file-damaged"));
}
