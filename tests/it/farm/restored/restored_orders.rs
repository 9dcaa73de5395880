//! Orders that came over HTTP after the backup that is put back was made.

use std::{fs, time::Duration};

use ledger::PartState;
use serde_json::json;

use crate::{
    farm::parts::door::OpenFarm,
    support::{MACHINE, block, stl},
};

#[test]
fn a_restored_ledger_that_has_forgotten_an_order_does_not_print_it_twice() {
    let mut open = OpenFarm::start("");
    let backup = open.farm.root().join("ledger.backup");
    open.farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    let line = |open: &OpenFarm, name: &str, side: f64| {
        let hash = blake3::hash(&stl(&block(side, 15.0, 10.0))).to_hex().to_string();
        open.send(&format!("PUT /api/v1/content/{hash}"), &stl(&block(side, 15.0, 10.0)));
        json!([{ "name": name, "content": hash, "copies": 2 }])
    };
    let built = line(&open, "built.stl", 20.0);
    let first = open.order("k1", built.clone());
    open.farm.wait_for_parts(PartState::Waiting, 1);
    open.farm.flush();
    open.farm.wait_for_parts(PartState::Built, 1);
    let waiting = line(&open, "waiting.stl", 25.0);
    assert_eq!(open.order("k2", waiting.clone()).status, 202);
    open.farm.wait_for_parts(PartState::Waiting, 1);
    open.farm.stop();
    open.farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    open.restart();
    let again = open.order("k1", built);
    assert_eq!((again.status, again.header("idempotency-replayed")), (202, Some("true")), "its lines are parts");
    assert_eq!(again.body, first.body);
    assert_eq!(open.order("k2", waiting).status, 202);
    std::thread::sleep(Duration::from_secs(2));
    let numbers = [PartState::Claimed, PartState::Waiting, PartState::Built].map(|state| open.farm.parts(state).len());
    assert_eq!(numbers, [0, 1, 1], "{}", open.farm.log());
    assert!(open.farm.query_ledger(async |ledger| ledger.arriving_lines(MACHINE, 9).await.unwrap()).is_empty());
    open.farm.flush();
    open.farm.wait_for_parts(PartState::Built, 2);
    open.farm.assert_nothing_lost_or_doubled();
    assert!(open.farm.broken_invariants(&Default::default()).is_empty());
}

#[test]
fn an_order_that_was_answered_and_was_no_part_yet_at_a_kill_is_taken_in_by_a_restore() {
    let mut open = OpenFarm::start("");
    let backup = open.farm.root().join("ledger.backup");
    open.farm.nestd_ok(&["backup", backup.to_str().unwrap()]);
    let hash = open.put(&stl(&block(20.0, 15.0, 10.0)));
    // Nothing is taken from a hot folder that is away.
    let (inbox, away) = (open.farm.folder("inbox"), open.farm.root().join("away"));
    fs::rename(&inbox, &away).unwrap();
    let lines =
        json!([{ "name": "kept.stl", "content": hash, "copies": 2 }, { "name": "cancelled.stl", "content": hash }]);
    let taken = open.order("k1", lines.clone());
    assert_eq!(taken.status, 202, "{taken:?}");
    let cancelled = taken.json()["lines"][1]["line"].as_str().unwrap().to_owned();
    assert_eq!(open.send(&format!("DELETE /api/v1/orders/K-1/lines/{cancelled}"), b"").status, 200);
    open.farm.kill();
    fs::rename(&away, &inbox).unwrap();
    let told = open.farm.nestd_ok(&["restore", backup.to_str().unwrap()]);
    assert!(told.contains("kept.stl of order K-1") && !told.contains("cancelled.stl"), "{told}");
    open.restart();
    let again = open.order("k1", lines);
    assert_eq!((again.status, again.header("idempotency-replayed")), (202, Some("true")), "its key is known again");
    open.farm.wait_for_parts(PartState::Waiting, 1);
    open.farm.flush();
    let built = open.farm.wait_for_parts(PartState::Built, 1).remove(0);
    assert_eq!((built.name.as_str(), built.wanted_copies()), ("kept.stl", 2));
    open.farm.assert_nothing_lost_or_doubled();
    let told = open.farm.nestd_ok(&["check", "--deep"]);
    assert!(!told.contains("order K-1"), "{told}");
}
