//! Several servers as one farm: the real binary as several nodes, each with folders and a machine of its own, on one private PostgreSQL
//! server.

use std::fs;

use ledger::PartState;
use ledger_fixtures::postgres_cluster::PostgresCluster;
use rustix::process::Signal;

use super::test_node::{TestNode, new_database};
use crate::support::{QUICK, block, signal, wait_until_or};

#[test]
fn three_nodes_are_one_farm_and_a_part_goes_from_one_to_another() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let mut nodes = [1, 2, 3].map(|number| TestNode::started(number, &url));
    for node in &nodes {
        node.farm.drop_part(&format!("of-{}_x2.stl", node.name), &block(20.0, 20.0, 10.0));
    }
    nodes[0].farm.wait_for_parts(PartState::Waiting, 3);
    for node in &nodes {
        let told = node.command(&["check"]).output().unwrap();
        let told = String::from_utf8_lossy(&told.stdout).into_owned();
        assert!(!told.contains("cancel the parts") && !told.contains("no file in machines"), "{}: {told}", node.name);
    }
    let told = nodes[1].farm.nestd_ok(&["nodes"]);
    for number in 1..=3 {
        let named = format!("NODE: print{number}  STATE: runs");
        let of_node = told.split("NODE: ").find(|node| format!("NODE: {node}").starts_with(&named)).unwrap_or_default();
        assert!(of_node.contains(&format!("MACHINES: machine-{number}")), "{told}");
    }
    // A command for a machine of another node.
    nodes[0].farm.flush_machine("machine-3");
    nodes[2].farm.wait_for_queued(1);
    assert!(nodes[0].farm.queued().is_empty() && nodes[1].farm.queued().is_empty());
    // The original of a part that is moved to another node comes along.
    nodes[2].farm.nestd_ok(&["move", "of-print1_x2.stl", "--to", "machine-2"]);
    nodes[0].farm.wait_for_parts(PartState::Waiting, 2);
    nodes[2].farm.flush_machine("machine-2");
    nodes[1].farm.wait_for_queued(1);
    nodes[0].farm.wait_for_parts(PartState::Built, 3);
    let (second, third) = (nodes[1].farm.queued(), nodes[2].farm.queued());
    crate::support::farm_files::assert_each_copy_once(&[second, third].concat(), 6);
    // It is printed again where it was printed, whoever says so.
    let built = nodes[0].farm.parts(PartState::Built);
    let part = built.iter().find(|part| part.name == "of-print1_x2.stl").unwrap().id;
    let name = nodes[1].farm.queued()[0].file_name().unwrap().to_string_lossy().into_owned();
    let build: u32 = name.trim_end_matches(".build.3mf").rsplit('_').next().unwrap().parse().unwrap();
    let bad = ["outcome", &build.to_string(), "complete", "--bad", &format!("{part}=2"), "--anyway"];
    let told = nodes[0].farm.nestd_ok(&bad);
    assert!(told.contains("Noted"), "{told}");
    nodes[0].farm.wait_for_parts(PartState::Waiting, 1);
    for node in &mut nodes {
        let told = node.command(&["check", "--deep"]).output().unwrap();
        let told = String::from_utf8_lossy(&told.stdout).into_owned();
        assert!(told.contains("I1 to I5 hold"), "{}: {told}", node.name);
        node.farm.stop();
    }
    let told = nodes[0].farm.nestd_ok(&["nodes"]);
    assert_eq!(told.matches("stopped").count(), 3, "{told}");
}

#[test]
fn a_machine_has_one_node_and_goes_to_another_by_a_persons_word() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let (mut first, second) = (TestNode::started(1, &url), TestNode::new(2, &url));
    second.configure_machine_of(&first);
    let mut second = second;
    second.start();
    second.says("the node print1 serves it");
    first.farm.drop_part("a_x2.stl", &block(20.0, 20.0, 10.0));
    first.farm.wait_for_parts(PartState::Waiting, 1);
    let refused = second.farm.nestd(&["adopt", "machine-1"]);
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && told.contains("is served by the node print1"), "{told}");
    // The server dies, with the file of a waiting part on it; its second copy is lost, too.
    second.wait_for_copies(1);
    first.farm.kill();
    fs::remove_dir_all(second.farm.root().join("state/copies")).unwrap();
    fs::create_dir(second.farm.root().join("state/copies")).unwrap();
    let told = second.farm.nestd_ok(&["pause", "machine-1"]);
    assert!(told.contains("The node print1, which serves the machine, does not run"), "{told}");
    let told = second.farm.nestd_ok(&["status"]);
    assert!(told.contains("served by print1") && told.contains("does not answer"), "{told}");
    first.farm.drop_part("b.stl", &block(20.0, 20.0, 12.0));
    second.adopt("machine-1");
    second.farm.wait_for_parts(PartState::Waiting, 1);
    second.says("must be dropped again: part 1 (a_x2.stl)");
    first.farm.drop_part("a again.stl", &block(20.0, 20.0, 10.0));
    second.says("part 1 goes on with it");
    second.farm.wait_for_parts(PartState::Waiting, 2);
    // The pause that was noted is in force.
    second.farm.nestd_ok(&["resume", "machine-1"]);
    second.farm.flush_machine("machine-1");
    first.farm.wait_for_queued(1);
    second.farm.wait_for_parts(PartState::Built, 2);
    // The dead server is repaired: it has no machine any more.
    first.start();
    first.says("the node print2 serves it");
    first.farm.drop_part("c.stl", &block(20.0, 20.0, 14.0));
    let parts = second.farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!(parts[0].full_name(), "c.stl");
    second.farm.stop();
    first.farm.stop();
    crate::support::farm_files::assert_each_copy_once(&first.farm.queued(), 3);
}

#[test]
fn the_parts_of_a_server_that_is_lost_with_its_disk_go_on_from_their_second_copies() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let (mut lost, mut heir) = (TestNode::started(1, &url), TestNode::new(2, &url));
    heir.configure_machine_of(&lost);
    heir.start();
    for number in 0..3 {
        lost.farm.drop_part(&format!("part {number}_x2.stl"), &block(20.0, 20.0, 10.0 + f64::from(number)));
    }
    heir.farm.wait_for_parts(PartState::Waiting, 3);
    heir.wait_for_copies(3);
    lost.farm.kill();
    fs::remove_dir_all(lost.farm.root().join("state")).unwrap();
    heir.adopt("machine-1");
    heir.farm.wait_for_parts(PartState::Waiting, 3);
    let flushed = || {
        heir.farm.nestd(&["flush", "machine-1"]);
        !lost.farm.queued().is_empty()
    };
    wait_until_or("the heir prints them", 60.0, || heir.farm.log(), flushed);
    heir.farm.wait_for_parts(PartState::Built, 3);
    assert!(!heir.farm.log().contains("must be dropped again"), "{}", heir.farm.log());
    crate::support::farm_files::assert_each_copy_once(&lost.farm.queued(), 6);
    heir.farm.stop();
}

#[test]
fn a_node_that_slept_while_its_machine_was_adopted_does_nothing_more() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let (mut sleeper, mut heir) = (TestNode::started(1, &url), TestNode::new(2, &url));
    sleeper.farm.drop_part("a_x3.stl", &block(20.0, 20.0, 10.0));
    sleeper.farm.wait_for_parts(PartState::Waiting, 1);
    heir.configure_machine_of(&sleeper);
    heir.start();
    signal(sleeper.farm.pid(), Signal::STOP);
    heir.adopt("machine-1");
    heir.farm.wait_for_parts(PartState::Waiting, 1);
    signal(sleeper.farm.pid(), Signal::CONT);
    sleeper.says("Another nestd is this node now");
    // Started again, it has no machine, and gives the file of the part that waits.
    sleeper.farm.stop();
    sleeper.start();
    sleeper.says("the node print2 serves it");
    wait_until_or(
        "the heir prints it",
        60.0,
        || heir.farm.log(),
        || {
            heir.farm.nestd(&["flush", "machine-1"]);
            !sleeper.farm.queued().is_empty()
        },
    );
    heir.farm.wait_for_parts(PartState::Built, 1);
    crate::support::farm_files::assert_each_copy_once(&sleeper.farm.queued(), 3);
    heir.farm.stop();
    sleeper.farm.stop();
}

#[test]
fn a_machine_that_is_taken_out_of_one_configuration_goes_to_another_with_what_waits() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let (mut from, mut to) = (TestNode::started(1, &url), TestNode::new(2, &url));
    from.farm.drop_part("a_x2.stl", &block(20.0, 20.0, 10.0));
    from.farm.wait_for_parts(PartState::Waiting, 1);
    to.configure_machine_of(&from);
    to.start();
    // A farm has a machine at least.
    from.farm.write_profile("machine-9", QUICK);
    fs::remove_file(from.farm.root().join("config/profiles/machine-1.toml")).unwrap();
    from.farm.reload();
    from.says("The configuration was read again");
    to.says("Resolved: machine-1: Another node of the farm serves the machine");
    wait_until_or(
        "its part is taken along",
        60.0,
        || to.farm.log(),
        || {
            to.farm.nestd(&["flush", "machine-1"]);
            !from.farm.queued().is_empty()
        },
    );
    to.farm.wait_for_parts(PartState::Built, 1);
    crate::support::farm_files::assert_each_copy_once(&from.farm.queued(), 2);
    from.farm.stop();
    to.farm.stop();
}
