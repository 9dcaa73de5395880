//! A part's life: dropped, claimed, read, waiting, batched, nested, verified, published, history.

use std::{fs, time::Duration};

use ledger::{BuildState, HistoryQuery, PartState};

use crate::support::{QUICK, TestFarm, block, stl, wait_until};

#[test]
fn dropped_parts_become_one_build_in_the_queue_with_its_height_in_the_history() {
    let farm = TestFarm::running(QUICK);
    for (at, sample) in sample_parts::all_samples().iter().take(5).enumerate() {
        farm.drop_part(&format!("{at}_{}_x2.stl", sample.name), &sample.mesh);
    }
    farm.wait_for_parts(PartState::Waiting, 5);
    farm.flush();
    let file = farm.wait_for_queued(1).remove(0);
    farm.wait_for_parts(PartState::Built, 5);
    let placed = build_file::read_build(&file, &build_file::ReadLimits::default()).unwrap();
    assert_eq!(placed.len(), 10);
    let top_mm = placed.iter().map(|p| p.mesh.bounds_at(&p.pose).max.z).fold(0.0, f64::max);
    let rows = farm.query_ledger(async |ledger| ledger.read_history(&HistoryQuery::default()).await.unwrap());
    assert_eq!(rows.len(), 1);
    assert!(
        (rows[0].measures.height_mm.unwrap() - top_mm).abs() < 1e-3,
        "{:?} is not {top_mm}",
        rows[0].measures.height_mm
    );
    assert!(rows[0].measures.clearance_proved_mm.is_none_or(|c| c >= 2.0));
    let stem = file.to_string_lossy().replace(".build.3mf", "");
    for suffix in [".report.json", ".parts.csv", ".png"] {
        assert!(fs::metadata(format!("{stem}{suffix}")).unwrap().len() > 0, "{suffix} is missing");
    }
    assert!(farm.nestd(&["verify", file.to_str().unwrap()]).status.success());
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn the_same_part_of_two_orders_stands_together_for_each() {
    let farm = TestFarm::running(&QUICK.replace("[120, 120, 120]", "[200, 14, 20]"));
    for (at, order) in ["Acme", "Brandt", "Acme", "Brandt"].into_iter().enumerate() {
        farm.drop_bytes(&format!("{order}/plate-{at}.stl"), &stl(&block(14.0, 12.0, 6.0)));
        farm.wait_for_parts(PartState::Waiting, at + 1);
    }
    farm.flush();
    let file = farm.wait_for_queued(1).remove(0);
    let mut placed = build_file::read_build(&file, &build_file::ReadLimits::default()).unwrap();
    placed.sort_by(|a, b| a.pose.translation.x.total_cmp(&b.pose.translation.x));
    let mut orders: Vec<_> = placed.into_iter().map(|copy| copy.words.order.unwrap()).collect();
    assert_eq!(orders.len(), 4);
    orders.dedup();
    assert_eq!(orders.len(), 2, "the copies of the orders stand among each other: {orders:?}");
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_stop_in_the_middle_of_a_final_search_publishes_nothing_and_the_next_start_goes_on_with_the_time_that_is_left() {
    const FINAL_SECS: f64 = 12.0;
    let machine = QUICK.replace("final_secs = 0.5", &format!("final_secs = {FINAL_SECS}"));
    let mut farm = TestFarm::running(&machine);
    farm.drop_part("a_x6.stl", &sample_parts::all_samples()[0].mesh);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    let nesting = |farm: &TestFarm| {
        farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Nesting).await.unwrap()).pop()
    };
    let (mut searched, mut height_mm) = (0.0, f64::INFINITY);
    for stop in 0..2 {
        wait_until("it is searched", 30.0, || nesting(&farm).is_some_and(|build| build.searches > 0));
        std::thread::sleep(Duration::from_secs(2));
        farm.stop();
        assert!(farm.queued().is_empty(), "nothing is published that was hardly searched");
        let build = nesting(&farm).unwrap();
        let found_mm = build.measures.height_mm.unwrap();
        assert!(build.search.wall_secs.unwrap() > searched && found_mm <= height_mm + 1e-6, "stop {stop}: {build:?}");
        (searched, height_mm) = (build.search.wall_secs.unwrap(), found_mm);
        farm.start();
    }
    farm.wait_for_parts(PartState::Built, 1);
    assert_eq!(farm.queued().len(), 1);
    let build =
        farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()).remove(0);
    let secs = build.search.wall_secs.unwrap();
    assert!((0.9 * FINAL_SECS..1.5 * FINAL_SECS).contains(&secs), "it was searched for {secs} s");
    assert!(build.attempts == 1 && build.measures.height_mm.unwrap() <= height_mm + 1e-6, "{height_mm}: {build:?}");
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_second_daemon_on_the_same_ledger_is_refused() {
    let farm = TestFarm::running(QUICK);
    let output = farm.nestd(&["run"]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("another nestd"));
}

#[test]
fn a_reload_adds_changes_and_removes_machines_without_a_restart() {
    let farm = TestFarm::running(QUICK);
    farm.write_profile("second", QUICK);
    farm.reload();
    let inbox = farm.root().join("inbox/second");
    wait_until("the new machine has its hot folder", 5.0, || inbox.is_dir());
    fs::write(inbox.join("cube.stl"), stl(&block(10.0, 10.0, 10.0))).unwrap();
    assert_eq!(farm.wait_for_parts(PartState::Waiting, 1)[0].machine, "second");
    farm.write_profile("second", "volume_mm = \"wrong\"");
    farm.reload();
    std::thread::sleep(Duration::from_millis(500));
    farm.nestd_ok_with_old_profile("second");
}

impl TestFarm {
    /// Asserts that a wrong configuration leaves the old one in force: the machine still publishes.
    fn nestd_ok_with_old_profile(&self, name: &str) {
        self.write_profile(name, QUICK);
        self.flush_machine(name);
        self.wait_for_parts(PartState::Built, 1);
    }
}

#[test]
fn reloads_while_a_build_is_made_do_not_take_its_file_away() {
    let profile = QUICK.replace("final_secs = 0.5", "final_secs = 2");
    let farm = TestFarm::running(&profile);
    farm.drop_part("a_x4.stl", &sample_parts::all_samples()[1].mesh);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    for days in 1..60 {
        farm.write_profile("test", &format!("{profile}archive_days = {days}\n"));
        farm.reload();
        std::thread::sleep(Duration::from_millis(60));
    }
    farm.wait_for_parts(PartState::Built, 1);
    assert_eq!(farm.queued().len(), 1, "{}", farm.log());
    farm.assert_nothing_lost_or_doubled();
}
