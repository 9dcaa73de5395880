//! From any node the whole farm: each shows, plans and takes orders for the machines of all, and says which node does not run.

use std::fs;

use ledger::{EventKind, PartState};
use ledger_fixtures::postgres_cluster::PostgresCluster;
use serde_json::{Value, json};

use super::test_node::{TestNode, new_database};
use crate::support::{block, farm_files::assert_each_copy_once, stl, wait_until_or};

/// Status and body of an answer.
fn ask(node: &TestNode, method: &str, path: &str, key: &str, body: &[u8]) -> (u16, Value) {
    let agent = ureq::Agent::config_builder().http_status_as_error(false).build().new_agent();
    let request = ureq::http::Request::builder().method(method).uri(format!("{}{path}", node.address));
    let request = request.header("content-type", "application/json").header("idempotency-key", key);
    let mut answer = agent.run(request.body(body).unwrap()).unwrap();
    let status = answer.status().as_u16();
    let text = answer.body_mut().read_to_string().unwrap();
    (status, serde_json::from_str(&text).unwrap_or(Value::String(text)))
}

/// What a node says of a machine; null = it knows none of this name.
fn machine_at(node: &TestNode, machine: &str) -> Value {
    let (_, farm) = ask(node, "GET", "/api/v1/farm", "", b"");
    let machines = farm["machines"].as_array().cloned().unwrap_or_default();
    machines.into_iter().find(|row| row["machine"] == machine).unwrap_or_default()
}

fn wait_for(node: &TestNode, what: &str, is_so: impl Fn() -> bool) {
    wait_until_or(what, 60.0, || format!("{}\n{}", machine_at(node, "machine-2"), node.farm.log()), is_so);
}

#[test]
fn any_node_shows_plans_and_takes_orders_for_the_machines_of_all() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let nodes = [1, 2].map(|number| TestNode::started(number, &url));
    for (node, other) in [(&nodes[0], "machine-2"), (&nodes[1], "machine-1")] {
        wait_for(node, "it knows the machine of the other", || machine_at(node, other)["volume_mm"].is_array());
        let (_, page) = ask(node, "GET", "/", "", b"");
        assert!(page.as_str().unwrap().contains(&format!("/machines/{other}")), "{page}");
        assert!(node.farm.nestd_ok(&["plan", other]).contains(other));
        let told = node.farm.nestd_ok(&["status"]);
        assert!(told.contains(other), "{told}");
    }
    // What is said of its folders is true on its server.
    let queue = machine_at(&nodes[0], "machine-2")["printers"][0]["queue"].clone();
    assert_eq!(queue, nodes[1].farm.folder("queue").to_str().unwrap());
    // Files that were put on one node are ordered on the other, for a machine of either.
    let (first, second) = (stl(&block(20.0, 15.0, 10.0)), stl(&block(21.0, 15.0, 10.0)));
    let put = |node: &TestNode, bytes: &[u8]| {
        let hash = blake3::hash(bytes).to_hex().to_string();
        let (status, told) = ask(node, "PUT", &format!("/api/v1/content/{hash}"), "", bytes);
        assert_eq!(status, 201, "{told}");
        hash
    };
    let (here, there) = (put(&nodes[0], &first), put(&nodes[1], &second));
    let order = |machine: &str, name: &str| {
        let lines = [("a.stl", &here, 2), ("b.stl", &there, 3)];
        let lines = lines.map(|(file, hash, copies)| json!({ "name": file, "content": hash, "copies": copies }));
        json!({ "machine": machine, "order": name, "lines": lines }).to_string()
    };
    for (at, machine, name) in [(0, "machine-2", "K-2"), (1, "machine-1", "K-1")] {
        let asked = order(machine, name);
        let (status, told) = ask(&nodes[at], "POST", "/api/v1/orders", name, asked.as_bytes());
        assert_eq!(status, 202, "{told}");
        // The same order once more, at the other node.
        assert_eq!(ask(&nodes[1 - at], "POST", "/api/v1/orders", name, asked.as_bytes()), (202, told));
    }
    nodes[0].farm.wait_for_parts(PartState::Waiting, 4);
    for machine in ["machine-1", "machine-2"] {
        assert_eq!(ask(&nodes[0], "POST", &format!("/api/v1/machines/{machine}/flush"), "", b"").0, 200);
    }
    let queued: Vec<_> = nodes.iter().flat_map(|node| node.farm.wait_for_queued(1)).collect();
    assert_each_copy_once(&queued, 10);
    // The build file is had from any node.
    let (_, builds) = ask(&nodes[0], "GET", "/api/v1/builds?machine=machine-2", "", b"");
    let number = &builds[0]["build"];
    let (status, file) = ask(&nodes[0], "GET", &format!("/builds/{number}/search.json"), "", b"");
    assert!(status == 200 && file["height_mm"].is_number(), "{builds}\n{file}");
}

#[test]
fn a_node_that_does_not_run_is_told_by_the_others_until_it_runs_again() {
    let server = PostgresCluster::start();
    let url = new_database(&server);
    let mut nodes = [1, 2].map(|number| TestNode::started(number, &url));
    wait_for(&nodes[0], "it knows the other", || machine_at(&nodes[0], "machine-2")["available"] == true);
    nodes[1].farm.drop_part("a.stl", &block(20.0, 15.0, 10.0));
    wait_for(&nodes[0], "its build is foretold", || machine_at(&nodes[0], "machine-2")["fires_at"].is_string());
    let needs = |node: &TestNode| ask(node, "GET", "/api/v1/farm", "", b"").1["needs_a_person"].to_string();
    // What one node asks people to see to, all show.
    fs::write(nodes[1].farm.folder("inbox").join("broken.stl"), "solid nothing\nendsolid\n").unwrap();
    wait_for(&nodes[0], "the other's refusal is shown", || needs(&nodes[0]).contains("Refused files lie"));
    assert!(nodes[0].farm.nestd_ok(&["status"]).contains("machine-2: Refused files lie"));
    let (_, page) = ask(&nodes[0], "GET", "/", "", b"");
    assert!(page.as_str().unwrap().contains("Refused files lie"), "{page}");
    nodes[1].farm.kill();
    let why = "its node print2 does not run";
    wait_for(&nodes[0], "it is told", || machine_at(&nodes[0], "machine-2")["trouble"] == why);
    wait_for(&nodes[0], "a person is asked", || needs(&nodes[0]).contains("node-gone"));
    assert_eq!(machine_at(&nodes[0], "machine-2")["state"], "unavailable");
    assert!(machine_at(&nodes[0], "machine-2")["fires_at"].is_null(), "nobody knows when its build fires");
    let told = nodes[0].farm.nestd_ok(&["status"]);
    assert!(told.contains("A node of the farm does not run") && told.contains("print2 on"), "{told}");
    let kinds = [EventKind::Unavailable];
    let told = nodes[0].farm.query_ledger(async |ledger| ledger.count_events_after(0, &kinds).await.unwrap());
    assert_eq!(told, 1, "it is an event once");
    let status = || fs::read_to_string(nodes[1].farm.folder("inbox").join("STATUS.txt")).unwrap();
    wait_for(&nodes[0], "its hot folder says so", || status().contains("machine-2: its node print2 on "));
    nodes[1].start();
    wait_for(&nodes[0], "it is over", || {
        machine_at(&nodes[0], "machine-2")["available"] == true && !needs(&nodes[0]).contains("node-gone")
    });
    let status = || fs::read_to_string(nodes[1].farm.folder("inbox").join("STATUS.txt")).unwrap();
    wait_for(&nodes[0], "its hot folder promises builds again", || !status().contains("does not run"));
}
