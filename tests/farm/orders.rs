//! Orders by hand.

use std::time::Duration;

use nestd::ledger::PartState;

use super::support::{QUICK, TestFarm, block};

#[test]
fn a_paused_profile_fires_nothing_until_it_is_resumed() {
    let farm = TestFarm::running(&format!("{QUICK}[trigger]\ncopies = 1\n"));
    farm.nestd_ok(&["pause", "test"]);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!(farm.nestd(&["flush", "test"]).status.code(), Some(1));
    std::thread::sleep(Duration::from_secs(2));
    assert!(farm.queued().is_empty());
    farm.nestd_ok(&["resume", "test"]);
    farm.wait_for_queued(1);
}

#[test]
fn a_cancelled_part_is_in_no_build() {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.drop_part("b.stl", &block(12.0, 10.0, 10.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    let a = parts.iter().find(|p| p.name == "a.stl").unwrap();
    farm.nestd_ok(&["cancel", &a.id.to_string()]);
    farm.flush();
    let built = farm.wait_for_parts(PartState::Built, 1);
    assert_eq!(built[0].name, "b.stl");
    assert_eq!(farm.parts(PartState::Rejected)[0].name, "a.stl");
    let copy = farm.folder("error").join(format!("part-{}", a.id)).join("a.stl");
    assert!(copy.exists(), "the original of a cancelled part is given back");
}

#[test]
fn an_order_to_a_farm_without_a_daemon_is_kept_and_said_so() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let told = farm.nestd_ok(&["flush", "test"]);
    assert!(told.contains("daemon"), "{told}");
    farm.start();
    farm.wait_for_queued(1);
}

#[test]
fn wrong_use_ends_with_2() {
    let farm = TestFarm::running(QUICK);
    assert_eq!(farm.nestd(&["flush", "nowhere"]).status.code(), Some(2));
    assert_eq!(farm.nestd(&["history", "--since", "yesterdayish"]).status.code(), Some(2));
    assert_eq!(farm.nestd(&["nonsense"]).status.code(), Some(2));
}

#[test]
fn an_outcome_is_told_of_a_published_build() {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    let id = farm.ask(async |ledger| ledger.history(&Default::default()).await.unwrap()[0].build);
    farm.nestd_ok(&["outcome", &id.to_string(), "complete", "--note", "fine"]);
    assert!(farm.nestd_ok(&["show", &format!("b{id}")]).contains("complete"));
}
