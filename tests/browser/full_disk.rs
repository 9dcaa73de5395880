//! A full disk and a read-only queue are temporary: nothing is refused or given up, and work continues when there is
//! room.

use std::{fs, time::Duration};

use ledger::{BuildState, PartState};

use crate::support::{QUICK, TestFarm, block, small_disk::SmallDisk, wait_until_or};

fn a_daemon_that_starts_on_a_full_disk_is_not_called_dead_and_what_it_needs_is_told() {
    let mut farm = TestFarm::new(QUICK);
    let disk = SmallDisk::new(&farm.root().join("state"), 4 << 20);
    farm.start();
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    disk.fill();
    farm.kill();
    farm.start();
    farm.drop_part("b.stl", &block(10.0, 20.0, 10.0));
    let status = || String::from_utf8_lossy(&farm.nestd(&["status"]).stdout).into_owned();
    wait_until_or(
        "status tells of the daemon and of its trouble",
        30.0,
        || format!("{}\n{}", status(), farm.log()),
        || {
            let said = status();
            said.contains("A daemon runs, but nothing was written")
                && said.contains("Free some room where the disk is full")
        },
    );
    let checked = farm.nestd(&["check"]);
    assert!(String::from_utf8_lossy(&checked.stdout).contains("could not write into the ledger"), "{checked:?}");
    let flushed = farm.nestd(&["flush", "test"]);
    let said = String::from_utf8_lossy(&flushed.stderr).into_owned();
    assert!(said.contains("Free some room on the disk of the state folder") && !said.contains("code: 13"), "{said}");
    disk.free();
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
    drop(disk);
}

fn says(farm: &TestFarm, words: &str) {
    wait_until_or(&format!("the log says {words:?}"), 20.0, || farm.log(), || farm.log().contains(words));
}

/// A running farm that tries a build once, with a part dropped, and its queue on a small disk.
fn farm_with_small_queue() -> (TestFarm, SmallDisk) {
    let mut farm = TestFarm::new(&QUICK.replace("max_attempts = 50", "max_attempts = 1"));
    let disk = SmallDisk::new(&farm.folder("queue"), 1 << 20);
    farm.start();
    says(&farm, "The farm is open");
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    wait_until_or("the queue is marked", 10.0, || farm.log(), || disk.at.join(".nestd-queue").exists());
    (farm, disk)
}

/// A running farm with its state folder on a small disk.
fn farm_with_small_state() -> (TestFarm, SmallDisk) {
    let mut farm = TestFarm::new(QUICK);
    let disk = SmallDisk::new(&farm.root().join("state"), 3 << 20);
    farm.start();
    says(&farm, "The farm is open");
    (farm, disk)
}

/// Asserts that the build waits with its part while the queue is unusable, which status tells as `told`, and is published
/// afterwards.
fn waits_for_its_queue(farm: &TestFarm, told: &str, mend: impl FnOnce()) {
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    says(farm, "A build cannot be made now");
    let status = || farm.nestd_ok(&["status"]);
    wait_until_or("status tells it", 40.0, || farm.log(), || status().contains(told));
    let build = farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Nesting).await.unwrap()).remove(0);
    assert!(farm.parts(PartState::Batched).len() == 1 && build.attempts <= 1, "{} attempts", build.attempts);
    mend();
    farm.wait_for_queued(1);
    farm.wait_for_parts(PartState::Built, 1);
    assert!(farm.query_ledger(async |ledger| ledger.paused_machines().await.unwrap()).is_empty());
}

fn a_build_waits_for_room_in_a_full_queue() {
    let (mut farm, disk) = farm_with_small_queue();
    disk.fill();
    waits_for_its_queue(&farm, "A build cannot be made now", || disk.free());
    farm.stop();
}

fn a_build_waits_for_a_queue_that_is_read_only() {
    let (mut farm, disk) = farm_with_small_queue();
    disk.read_only(true);
    waits_for_its_queue(&farm, "The queue folder cannot be used", || disk.read_only(false));
    farm.stop();
}

fn a_part_waits_for_room_in_the_state_folder_and_a_start_does_too() {
    let (mut farm, disk) = farm_with_small_state();
    disk.fill();
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    says(&farm, "No space left on device");
    std::thread::sleep(Duration::from_secs(2));
    disk.free();
    farm.wait_for_parts(PartState::Waiting, 1);
    assert!(farm.parts(PartState::Refused).is_empty());
    farm.stop();

    fs::remove_file(farm.root().join("log")).unwrap();
    for file in ["nestd.db-wal", "nestd.db-shm"] {
        let _ = fs::remove_file(farm.root().join("state").join(file));
    }
    disk.fill();
    farm.start();
    says(&farm, "is tried again");
    disk.free();
    says(&farm, "The farm is open");
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    farm.stop();
}

fn a_daemon_that_cannot_write_for_a_full_state_disk_runs_all_the_same() {
    let (mut farm, disk) = farm_with_small_state();
    let shows = || String::from_utf8_lossy(&farm.nestd(&["status"]).stdout).into_owned();
    wait_until_or("the daemon has said that it runs", 20.0, || farm.log(), || shows().contains("The daemon runs"));
    disk.fill();
    // Longer than a heartbeat stays valid.
    let until = std::time::Instant::now() + Duration::from_secs(20);
    while std::time::Instant::now() < until {
        let status = farm.nestd(&["status"]);
        let shown = String::from_utf8_lossy(&status.stdout).into_owned();
        assert!(status.status.success() && shown.contains("The daemon runs"), "{shown}\n{}", farm.log());
        std::thread::sleep(Duration::from_millis(500));
    }
    disk.free();
    farm.stop();
    assert!(farm.nestd_ok(&["status"]).contains("The daemon does not run."));
}

/// The tests, by name.
pub const CASES: [(&str, fn()); 5] = [
    (
        "a_daemon_that_starts_on_a_full_disk_is_not_called_dead_and_what_it_needs_is_told",
        a_daemon_that_starts_on_a_full_disk_is_not_called_dead_and_what_it_needs_is_told,
    ),
    ("a_build_waits_for_room_in_a_full_queue", a_build_waits_for_room_in_a_full_queue),
    ("a_build_waits_for_a_queue_that_is_read_only", a_build_waits_for_a_queue_that_is_read_only),
    (
        "a_part_waits_for_room_in_the_state_folder_and_a_start_does_too",
        a_part_waits_for_room_in_the_state_folder_and_a_start_does_too,
    ),
    (
        "a_daemon_that_cannot_write_for_a_full_state_disk_runs_all_the_same",
        a_daemon_that_cannot_write_for_a_full_state_disk_runs_all_the_same,
    ),
];
