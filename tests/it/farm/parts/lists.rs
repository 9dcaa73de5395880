//! Order lists as people make them.

use std::fs;

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, stl, wait_until};

/// A farm with a given `incomplete_secs`.
fn farm(incomplete_secs: f64) -> TestFarm {
    TestFarm::running(&format!("{QUICK}incomplete_secs = {incomplete_secs}\n[trigger]\nmax_wait_secs = \"24h\"\n"))
}

/// Names and copies of the waiting parts, sorted.
fn copies(farm: &TestFarm, count: usize) -> Vec<(String, u32)> {
    let mut parts: Vec<_> =
        farm.wait_for_parts(PartState::Waiting, count).into_iter().map(|part| (part.name, part.owed.copies)).collect();
    parts.sort();
    parts
}

#[test]
fn a_part_that_its_list_does_not_name_waits_is_reported_and_is_refused_with_a_remedy_that_works() {
    let farm = farm(4.0);
    farm.drop_bytes("order-8/order.csv", b"file;copies\na.stl;2\nlost.stl;1\n");
    farm.drop_bytes("order-8/a.stl", &stl(&block(10.0, 10.0, 10.0)));
    farm.drop_bytes("order-8/new.stl", &stl(&block(12.0, 10.0, 10.0)));
    let status = farm.folder("inbox").join("STATUS.txt");
    let is_reported = |text: &str| {
        ["order-8/new.stl stands in none of the 2 rows of order.csv", "order.csv names lost.stl, which is not there"]
            .iter()
            .all(|expected| text.contains(expected))
    };
    wait_until("STATUS.txt tells it", 10.0, || fs::read_to_string(&status).is_ok_and(|text| is_reported(&text)));
    assert_eq!(copies(&farm, 1), [("a.stl".to_owned(), 2)]);
    let reason = farm.folder("error").join("order-8/new.stl.reason.txt");
    wait_until("it is refused", 15.0, || reason.exists());
    let reason = fs::read_to_string(reason).unwrap();
    assert!(
        reason.contains("stands in none of the 2 rows") && reason.contains("a list that has a row for it"),
        "{reason}"
    );
    let list = farm.folder("error").join("order-8/order.csv.reason.txt");
    wait_until("the list is refused for its other row", 15.0, || list.exists());
    assert!(fs::read_to_string(list).unwrap().contains("lost.stl"));
    // The remedy.
    farm.drop_bytes("order-9/new.stl", &stl(&block(12.0, 10.0, 10.0)));
    farm.drop_bytes("order-9/order.csv", b"new.stl;5\n");
    assert_eq!(copies(&farm, 2), [("a.stl".to_owned(), 2), ("new.stl".to_owned(), 5)]);
}
