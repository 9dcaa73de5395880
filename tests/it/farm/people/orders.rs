//! Commands of an operator.

use std::time::Duration;

use farm::InvariantExpectations;
use ledger::PartState;
use serde_json::Value;

use crate::support::{QUICK, TestFarm, block, http::send_request, wait_until_or};

#[test]
fn an_order_to_a_farm_without_a_daemon_is_kept_and_said_so() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let answer = farm.nestd_ok(&["flush", "test"]);
    assert!(answer.contains("daemon"), "{answer}");
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
fn an_outcome_is_recorded_for_a_published_build() {
    let farm = TestFarm::running(QUICK);
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    let id = farm.query_ledger(async |ledger| ledger.read_history(&Default::default()).await.unwrap()[0].build);
    farm.nestd_ok(&["outcome", &id.to_string(), "complete", "--note", "fine"]);
    assert!(farm.nestd_ok(&["show", &format!("b{id}")]).contains("complete"));
}

#[test]
fn a_large_file_is_copied_beside_the_loop_when_its_part_is_cancelled() {
    let farm = TestFarm::running(QUICK);
    let large = crate::support::greedy::padded(200 << 20);
    farm.drop_bytes("a.3mf", &large);
    let part = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    let tasks = format!("/proc/{}/task", farm.pid());
    let copies = || {
        let names = std::fs::read_dir(&tasks).unwrap().flatten();
        names
            .filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok())
            .any(|name| name.starts_with("Copy("))
    };
    let mut cancel = farm.command(&["cancel", &part.id.to_string()]).spawn().unwrap();
    crate::support::wait_until_or("a thread of its own copies", 20.0, || farm.log(), copies_soon(&copies));
    cancel.wait().unwrap();
    farm.wait_for_parts(PartState::Refused, 1);
    let copy = farm.folder("error").join(format!("part-{}", part.id)).join("a.3mf");
    assert!(std::fs::read(copy).unwrap() == large, "the original is given back whole");
}

/// Polls often, because a copy may take only a tenth of a second.
fn copies_soon(copies: &impl Fn() -> bool) -> impl FnMut() -> bool {
    move || {
        let until = std::time::Instant::now() + Duration::from_secs(1);
        while std::time::Instant::now() < until {
            if copies() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        false
    }
}

#[test]
fn an_order_is_closed_as_it_is_by_command_and_by_program() {
    let mut farm = TestFarm::new(QUICK);
    let socket = farm.root().join("web.sock");
    let config = std::fs::read_to_string(farm.config()).unwrap();
    std::fs::write(farm.config(), format!("{config}[web]\nlisten = \"unix:{}\"\n", socket.display())).unwrap();
    farm.start();
    for order in ["kit", "other"] {
        std::fs::create_dir(farm.folder("inbox").join(order)).unwrap();
        farm.drop_part(&format!("{order}/a_x3.stl"), &block(20.0, 20.0, if order == "kit" { 20.0 } else { 30.0 }));
        farm.drop_bytes(&format!("{order}/torn.stl"), format!("solid {order}\nendsolid {order}\n").as_bytes());
    }
    farm.wait_for_parts(PartState::Refused, 2);
    farm.wait_for_parts(PartState::Waiting, 2);
    let told = farm.nestd_ok(&["close", "kit"]);
    assert!(told.contains("Order kit is closed with 0 of 4 copies."), "{told}");
    let answer = send_request(&socket, "POST /api/v1/orders/other/close", b"").unwrap();
    assert!(answer.body.contains("Order other is closed with 0 of 4 copies."), "{}", answer.body);
    // The daemon gives back what waited. Nothing of the orders asks for a person any more.
    let standings = || -> Vec<String> {
        let orders: Value = serde_json::from_str(&farm.nestd_ok(&["orders", "--all", "--json"])).unwrap();
        orders.as_array().unwrap().iter().map(|order| order["standing"].as_str().unwrap().to_owned()).collect()
    };
    wait_until_or("both are closed", 20.0, || farm.log(), || standings() == ["closed", "closed"]);
    assert!(farm.nestd_ok(&["orders"]).contains("No such orders."), "neither asks");
    let asks = || farm.nestd_ok(&["status"]).contains("Refused files");
    wait_until_or("nobody is asked for what was refused", 30.0, || farm.log(), || !asks());
    let again = farm.nestd(&["close", "kit"]);
    assert!(String::from_utf8_lossy(&again.stderr).contains("there is nothing to close"), "{again:?}");
    assert_eq!(farm.broken_invariants(&InvariantExpectations::default()), [""; 0]);
}
