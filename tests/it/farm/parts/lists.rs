//! Order lists as people make them.

use std::{
    fs,
    io::{Cursor, Write},
};

use ledger::PartState;
use zip::{ZipWriter, write::SimpleFileOptions};

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

fn packed(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        archive.start_file(*name, SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn an_archive_is_the_order_that_was_packed_and_one_that_cannot_be_unpacked_is_refused() {
    let farm = farm(4.0);
    let (a, b) = (stl(&block(10.0, 10.0, 10.0)), stl(&block(12.0, 10.0, 10.0)));
    let order = packed(&[
        ("Auftrag/liste.csv", b"Datei;Anzahl\na.stl;4\n"),
        ("Auftrag/a.stl", &a),
        ("Auftrag/a.mtl", b"newmtl red\n"),
        ("__MACOSX/Auftrag/._a.stl", b"x"),
    ]);
    farm.drop_bytes("K-7.zip", &order);
    farm.drop_bytes("K-8.zip", &order[..order.len() / 2]);
    farm.drop_bytes("K-9.zip", &packed(&[("a.stl", &a), ("../../b.stl", &b)]));
    assert_eq!(copies(&farm, 1), [("a.stl".to_owned(), 4)]);
    let orders: Vec<_> = farm.parts(PartState::Waiting).into_iter().map(|part| part.terms.order_name).collect();
    assert_eq!(orders, ["K-7"]);
    let refused = |name: &str, why: &str| {
        let reason = farm.folder("error").join(format!("{name}.reason.txt"));
        wait_until(name, 15.0, || reason.exists());
        let text = fs::read_to_string(reason).unwrap();
        assert!(text.contains(why), "{text}");
        wait_until(name, 15.0, || farm.folder("error").join(name).exists());
    };
    refused("K-8.zip", "truncated");
    refused("K-9.zip", "a file outside of it");
    assert!(!farm.folder("inbox").join("K-7.zip").exists());
    let colours = farm.folder("archive").join("material-libraries/K-7/a.mtl");
    wait_until("colours are put aside", 15.0, || colours.exists());
    assert!(!farm.folder("error").join("K-7").exists());
}
