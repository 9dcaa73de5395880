//! Several printers behind one hot folder, with the real daemon: which one gets a build, and that builds move between them
//! exactly once, whoever is killed and whenever a printer takes its file.

use std::{
    fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use ledger::{BuildState, OperatorWord, PartState, SeenFiles};
use rand::{RngExt, SeedableRng, rngs::StdRng};

use crate::support::{
    QUICK, TestFarm, block,
    farm_files::{assert_each_copy_once, list_build_files},
    wait_until_or,
};

const PRINTERS: &str = "[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\n";
/// Least number of kills of the daemon while builds move.
const KILLS: usize = 24;
/// Least number of builds that move. A slow machine needs more kills until so many have moved.
const MOVES: usize = 5;

fn queue(farm: &TestFarm, printer: &str) -> PathBuf {
    farm.root().join("queue").join(printer)
}

fn visible(farm: &TestFarm) -> [usize; 2] {
    ["left", "right"].map(|printer| list_build_files(&queue(farm, printer)).len())
}

fn build_part(farm: &TestFarm, name: &str) {
    let built = farm.parts(PartState::Built).len();
    farm.drop_part(name, &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, built + 1);
}

#[test]
fn builds_go_to_the_printer_that_is_free_and_from_one_that_is_down() {
    let mut farm = TestFarm::running(&format!("{QUICK}{PRINTERS}"));
    build_part(&farm, "a.stl");
    build_part(&farm, "b.stl");
    assert_eq!(visible(&farm), [1, 1]);
    let told = farm.nestd_ok(&["printer", "left", "down", "--reason", "the laser"]);
    assert!(told.contains("What it has not taken goes to right."), "{told}");
    let log = || farm.log();
    wait_until_or("its build is moved", 30.0, log, || visible(&farm) == [0, 2]);
    let table = farm.nestd_ok(&["printer"]);
    assert!(table.contains("left") && table.contains("the laser"), "{table}");
    let json = || serde_json::from_str::<serde_json::Value>(&farm.nestd_ok(&["printer", "--json"])).unwrap();
    assert_eq!(json()[0]["down"]["reason"], "the laser");
    wait_until_or("it is recorded where the build is", 20.0, || json().to_string(), || json()[1]["builds"] == 2);
    assert!(farm.nestd_ok(&["status"]).contains("the laser"));
    let metrics = farm.nestd_ok(&["metrics"]);
    assert!(metrics.contains("nestd_printer_up{machine=\"test\",printer=\"left\"} 0"), "{metrics}");
    let history = || farm.nestd_ok(&["history", "--format", "json"]);
    wait_until_or("the history names the printer", 20.0, history, || history().matches("\"right\"").count() == 2);
    let checked = farm.nestd_ok(&["check", "--deep"]);
    assert!(checked.contains("queue of test, printer right"), "{checked}");
    assert!(farm.nestd_ok(&["printer", "left", "up"]).contains("takes builds again"));
    build_part(&farm, "c.stl");
    assert_eq!(visible(&farm), [1, 2]);
    assert_eq!(farm.nestd(&["printer", "middle", "down"]).status.code(), Some(2));
    farm.stop();
    assert_eq!(farm.broken_invariants(&InvariantExpectations { at_rest: true, ..Default::default() }), [""; 0]);
}

#[test]
fn a_build_that_waits_for_a_yes_is_published_once_somebody_says_so() {
    let mut farm = TestFarm::running(&format!("{QUICK}approve = \"always\"\n"));
    farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    let verified = || farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap());
    wait_until_or("the build is proved", 60.0, || farm.log(), || verified().len() == 1);
    let id = verified()[0].id.to_string();
    let preview = farm.nestd_ok(&["release", &id, "--preview"]);
    assert!(preview.contains("1 copy, 10.0 of 120 mm high") && preview.contains("No part in it"), "{preview}");
    let status = || farm.nestd_ok(&["status"]);
    wait_until_or("somebody is asked", 20.0, status, || status().contains("waits for a yes before it is published"));
    assert!(farm.queued().is_empty());
    assert!(farm.nestd_ok(&["release", &id]).contains("goes to the queue"));
    farm.wait_for_queued(1);
    farm.stop();
}

/// A printer takes its file at any moment, printers go down and come up, and the daemon is killed again and again.
#[test]
fn builds_that_move_under_kills_are_printed_exactly_once() {
    let mut farm = TestFarm::running(&format!("{QUICK}{PRINTERS}"));
    let mut random = StdRng::seed_from_u64(18);
    let taken = farm.root().join("taken");
    fs::create_dir_all(&taken).unwrap();
    let mut parts = 0;
    let moved = |farm: &TestFarm| farm.log().matches("Moved build").count();
    let mut kill = 0;
    while kill < KILLS || moved(&farm) < MOVES {
        assert!(kill < 10 * KILLS, "only {} builds were moved: {}", moved(&farm), farm.log());
        if kill % 4 == 0 {
            for _ in 0..2 {
                build_part(&farm, &format!("{parts}.stl"));
                parts += 1;
            }
        }
        let (down, up) = if random.random_bool(0.5) { ("left", "right") } else { ("right", "left") };
        farm.nestd_ok(&["printer", up, "up"]);
        farm.nestd_ok(&["printer", down, "down"]);
        // Mostly while the files move, which takes some hundredths of a second from the next tick on.
        let until = Instant::now() + Duration::from_millis(random.random_range(0..900));
        while Instant::now() < until {
            if random.random_bool(0.01) {
                take_one(&farm, &taken, if random.random_bool(0.5) { up } else { down });
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        farm.kill();
        farm.start();
        kill += 1;
    }
    farm.nestd_ok(&["printer", "left", "up"]);
    farm.nestd_ok(&["printer", "right", "up"]);
    let moving = || {
        farm.query_ledger(async |ledger| ledger.builds_to_take_back("test").await.unwrap())
            .into_iter()
            .filter(|build| build.place.move_to.is_some())
            .count()
    };
    wait_until_or("nothing moves any more", 60.0, || farm.log(), || moving() == 0);
    farm.stop();
    let all =
        [list_build_files(&queue(&farm, "left")), list_build_files(&queue(&farm, "right")), list_build_files(&taken)];
    let all = all.concat();
    assert_each_copy_once(&all, parts);
    assert_eq!(all.len(), parts, "{all:?}");
    let expectations = InvariantExpectations { at_rest: true, taken: list_build_files(&taken), ..Default::default() };
    assert_eq!(farm.broken_invariants(&expectations), [""; 0]);
}

/// Builds are taken back out of the queue again and again, by people and by nestd, while the printer takes files and the daemon is
/// killed. `NESTD_WITHDRAWALS=1000` makes it longer.
#[test]
fn builds_that_are_taken_back_under_kills_are_printed_exactly_once() {
    let wanted = std::env::var("NESTD_WITHDRAWALS").ok().and_then(|number| number.parse().ok()).unwrap_or(12);
    let mut farm =
        TestFarm::running(&format!("{QUICK}withdraw = \"urgent\"\n[trigger]\ncopies = 1\ngather_secs = 0\n"));
    let mut random = StdRng::seed_from_u64(29);
    let taken = farm.root().join("taken");
    fs::create_dir_all(&taken).unwrap();
    let mut parts = 0;
    let log_text = |farm: &TestFarm| farm.log();
    while farm.log().matches("is out of the queue. ").count() < wanted {
        let is_empty = list_build_files(&queue(&farm, "test")).is_empty();
        if random.random_bool(0.2) || is_empty && farm.parts(PartState::Built).len() == parts {
            let urgent = random.random_bool(0.3).then_some("priority = 100\n");
            for _ in 0..random.random_range(1..4) {
                let name = format!("{parts}.stl");
                urgent
                    .iter()
                    .for_each(|ticket| fs::write(farm.folder("inbox").join(format!("{name}.toml")), ticket).unwrap());
                farm.drop_part(&name, &block(20.0, 20.0, 10.0));
                parts += 1;
            }
        }
        let is_queued = || {
            farm.query_ledger(async |ledger| ledger.resume_machine("test", "a@test").await.unwrap());
            !list_build_files(&queue(&farm, "test")).is_empty()
        };
        wait_until_or("a build is in the queue", 180.0, || log_text(&farm), is_queued);
        for build in farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()) {
            if random.random_bool(0.8) {
                // Its printer may have taken it.
                let word = OperatorWord::Withdraw(build.id, String::new());
                drop(
                    farm.query_ledger(async |ledger| ledger.carry_out(&word, "a@test", &SeenFiles::new(), false).await),
                );
            }
        }
        let until = Instant::now() + Duration::from_millis(random.random_range(0..1200));
        // Each withdrawal by a person pauses the machine.
        farm.query_ledger(async |ledger| ledger.resume_machine("test", "a@test").await.unwrap());
        while Instant::now() < until {
            if random.random_bool(0.002) {
                take_one(&farm, &taken, "test");
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        if random.random_bool(0.5) {
            farm.kill();
            farm.start();
        }
    }
    let all_is_built = || {
        farm.query_ledger(async |ledger| ledger.resume_machine("test", "a@test").await.unwrap());
        farm.parts(PartState::Built).len() == parts
    };
    wait_until_or("all is built", 90.0, || log_text(&farm), all_is_built);
    let withdrawing = || farm.query_ledger(async |ledger| ledger.builds_to_take_back("test").await.unwrap()).len();
    wait_until_or("nothing is taken back any more", 60.0, || log_text(&farm), || withdrawing() == 0);
    wait_until_or("all is built", 90.0, || log_text(&farm), all_is_built);
    farm.stop();
    let all = [list_build_files(&queue(&farm, "test")), list_build_files(&taken)].concat();
    assert_each_copy_once(&all, parts);
    let expectations = InvariantExpectations { at_rest: true, taken: list_build_files(&taken), ..Default::default() };
    assert_eq!(farm.broken_invariants(&expectations), [""; 0]);
}

/// A printer takes the first of its files by renaming it away, as it does when it begins to print.
fn take_one(farm: &TestFarm, taken: &std::path::Path, printer: &str) {
    if let Some(file) = list_build_files(&queue(farm, printer)).first() {
        // nestd may take it back in this moment.
        drop(fs::rename(file, taken.join(file.file_name().unwrap())));
    }
}
