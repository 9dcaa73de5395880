//! Order lists in the formats that people use.

use ledger::PartState;

use crate::driven_tests::{HandDrivenFarm, QUICK, block, stl};

/// A farm that waits this many seconds if an order list and its files do not match.
fn farm(incomplete_secs: f64) -> HandDrivenFarm {
    HandDrivenFarm::open(&format!("{QUICK}incomplete_secs = {incomplete_secs}\n[trigger]\nmax_wait_secs = \"24h\"\n"))
}

/// Names and copies of the waiting parts, sorted.
fn copies(farm: &mut HandDrivenFarm, count: usize) -> Vec<(String, u32)> {
    let mut parts: Vec<_> =
        farm.wait_for_parts(PartState::Waiting, count).into_iter().map(|part| (part.name, part.owed.copies)).collect();
    parts.sort();
    parts
}

#[test]
fn a_list_that_is_copied_last_counts_for_every_file_of_its_order() {
    let mut farm = farm(600.0);
    for (at, name) in ["order-7/a.stl", "order-7/b.stl", "order-7/Gro\u{308}ße.stl"].into_iter().enumerate() {
        farm.drop_bytes(name, &stl(&block(10.0 + at as f64, 10.0, 10.0)));
        farm.pass_secs(0.25);
    }
    // Excel's "Unicode Text" format, with file names as Windows writes them.
    let text = "Datei\tStückzahl\tPreis\r\n.\\a.stl\t2\t1,50\r\nB\t3\t\r\nGröße.stl\t4\t\r\n";
    let list: Vec<u8> = [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    farm.drop_bytes("order-7/order.csv", &list);
    let expected =
        [("Gro\u{308}ße.stl", 4), ("a.stl", 2), ("b.stl", 3)].map(|(name, copies)| (name.to_owned(), copies));
    assert_eq!(copies(&mut farm, 3), expected);
    let warnings = farm.parts(PartState::Waiting).remove(0).warnings;
    assert!(warnings.contains("Preis"), "{warnings}");
    let archived = farm.folder("archive").join("order-lists/order-7/order.csv");
    farm.pass_until("the list is archived", |_| archived.exists());
}
