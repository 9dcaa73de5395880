//! Machines on folders that several nodes reach go from one node to another and back, while files that were just taken lie in
//! `.claimed`: each part is printed once, and none is given up.

use std::{
    fs,
    time::{Duration, Instant},
};

use ledger::PartState;
use ledger_fixtures::postgres_cluster::PostgresCluster;

use super::test_node::{TestNode, new_database};
use crate::support::{QUICK, TestFarm, block, farm_files::assert_each_copy_once, wait_until_or};

/// Files that are dropped at once, so that some of them are claimed at any moment of the seconds after.
const FILES: u32 = 40;
const MACHINE: &str = "machine-1";

/// Drops files of sizes of their own into the hot folder of the machine, and waits until some of them lie in `.claimed`.
fn drop_until_claimed(owner: &TestNode, first: u32) {
    for number in first..first + FILES {
        owner.farm.drop_part(&format!("part {number}.stl"), &block(12.0, 10.0, 5.0 + f64::from(number) * 0.05));
    }
    let claimed = owner.farm.folder("inbox").join(".claimed");
    let is_claim = |name: &str| !name.starts_with('.');
    let claims = || {
        let entries = fs::read_dir(&claimed).into_iter().flatten().flatten();
        entries.filter(|entry| is_claim(&entry.file_name().to_string_lossy())).count()
    };
    let deadline = Instant::now() + Duration::from_secs(30);
    while claims() < 3 {
        assert!(Instant::now() < deadline, "no file is claimed\n{}", owner.farm.log());
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Has all parts printed by the node that serves the machine, whose folders are those of `folders`.
fn print_all(serving: &TestNode, folders: &TestNode, parts: usize) {
    let logs = || format!("{}\n-- {} --\n{}", serving.farm.log(), folders.name, folders.farm.log());
    let known = |state| serving.farm.parts(state).len();
    wait_until_or(&format!("{parts} parts are printed"), 120.0, logs, || {
        let refused = serving.farm.parts(PartState::Refused);
        assert!(refused.is_empty(), "refused: {:?}\n{}", refused[0].refused, logs());
        serving.farm.nestd(&["flush", MACHINE]);
        known(PartState::Built) == parts
    });
    assert_each_copy_once(&folders.farm.queued(), parts);
}

/// Two nodes, both of which could serve the machine of the first.
fn two_nodes(server: &PostgresCluster) -> [TestNode; 2] {
    let url = new_database(server);
    let (first, mut second) = (TestNode::started(1, &url), TestNode::new(2, &url));
    second.configure_machine_of(&first);
    second.start();
    [first, second]
}

/// The machine is adopted from a node that ends while files are claimed, and comes back from the heir, which ends in the same way.
fn adopt_to_and_fro(end: fn(&mut TestFarm)) {
    let server = PostgresCluster::start();
    let [mut first, mut second] = two_nodes(&server);
    drop_until_claimed(&first, 0);
    end(&mut first.farm);
    second.adopt(MACHINE);
    second.farm.wait_for_parts(PartState::Waiting, FILES as usize);
    first.start();
    first.says("the node print2 serves it");
    drop_until_claimed(&first, FILES);
    end(&mut second.farm);
    first.adopt(MACHINE);
    // It has the files that only its own disk holds.
    second.start();
    print_all(&first, &first, 2 * FILES as usize);
    for node in [&mut first, &mut second] {
        let told = node.command(&["check", "--deep"]).output().unwrap();
        let told = String::from_utf8_lossy(&told.stdout).into_owned();
        assert!(told.contains("I1 to I5 hold"), "{}: {told}", node.name);
        node.farm.stop();
    }
}

#[test]
fn no_part_is_lost_when_a_machine_is_adopted_and_comes_back_while_files_are_claimed() {
    adopt_to_and_fro(TestFarm::kill);
}

#[test]
fn no_part_is_lost_when_a_machine_goes_from_a_stopped_node_to_another_and_back() {
    adopt_to_and_fro(TestFarm::stop);
}

#[test]
fn no_part_is_lost_when_a_machine_is_taken_out_of_one_configuration_and_back_while_files_are_claimed() {
    let server = PostgresCluster::start();
    let [mut first, mut second] = two_nodes(&server);
    // A farm has a machine at least.
    first.farm.write_profile("machine-9", QUICK);
    let file = |node: &TestNode| node.farm.root().join(format!("config/profiles/{MACHINE}.toml"));
    let text = fs::read_to_string(file(&second)).unwrap();
    let mut dropped = 0;
    for (from, to) in [(&first, &second), (&second, &first)] {
        fs::write(file(to), &text).unwrap();
        fs::remove_file(file(from)).unwrap();
        drop_until_claimed(&first, dropped);
        dropped += FILES;
        from.farm.reload();
        to.farm.reload();
        // Where the other one has let it go before, no alert tells of it.
        let serving = || to.farm.query_ledger(async |ledger| ledger.node_of_machine(MACHINE).await.unwrap());
        let has_it = || serving().as_ref() == Some(&to.name);
        wait_until_or("the other node serves it", 60.0, || to.farm.log(), has_it);
    }
    print_all(&first, &first, dropped as usize);
    for node in [&mut first, &mut second] {
        node.farm.stop();
    }
}

#[test]
fn what_another_node_has_is_not_missed_by_the_check_of_a_node() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let (mut first, mut second) = (TestNode::started(1, &url), TestNode::started(2, &url));
    first.farm.drop_part("printed.stl", &block(20.0, 20.0, 10.0));
    first.farm.wait_for_parts(PartState::Waiting, 1);
    first.farm.flush_machine(MACHINE);
    first.farm.wait_for_parts(PartState::Built, 1);
    first.farm.drop_part("waits.stl", &block(20.0, 20.0, 12.0));
    first.farm.wait_for_parts(PartState::Waiting, 1);
    let check = |node: &TestNode| {
        let told = node.command(&["check", "--deep"]).output().unwrap();
        String::from_utf8_lossy(&told.stdout).into_owned()
    };
    // The machine of the other node is configured here, too, on folders of this server, and the hot folder of another one lies there.
    second.farm.write_profile(MACHINE, QUICK);
    fs::create_dir_all(second.farm.root().join("inbox").join(MACHINE)).unwrap();
    let told = check(&second);
    assert!(told.contains("the node print1 serves it") && told.contains("I1 to I5 hold"), "{told}");
    assert!(!told.contains("cancel") && !told.contains("machine-1 in"), "{told}");
    first.farm.kill();
    wait_until_or("the check tells who does not run", 30.0, String::new, || {
        check(&second).contains("whose node print1 does not run")
    });
    second.farm.reload();
    second.adopt(MACHINE);
    first.start();
    second.farm.wait_for_parts(PartState::Waiting, 1);
    wait_until_or(
        "its file is fetched",
        60.0,
        || second.farm.log(),
        || second.farm.parts(PartState::Waiting)[0].owed.fetch_at.is_none(),
    );
    for node in [&mut first, &mut second] {
        let told = check(node);
        assert!(told.contains("I1 to I5 hold") && !told.contains("is not in"), "{}: {told}", node.name);
        node.farm.stop();
    }
}
