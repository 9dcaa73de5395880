//! Order lists in the formats that people use.

use std::fs;

use ledger::{BuildState, CommandKind, CommandState, OrderState, PartState, PrintOutcome, RefusalCause, ToldOutcome};

use ledger_fixtures::ToldWords;

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

/// Builds all that waits and tells the print complete.
fn print(farm: &mut HandDrivenFarm) {
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(2.0);
    farm.queued().iter().for_each(|file| fs::remove_file(file).unwrap());
    farm.pass_secs(2.0);
    for build in farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()) {
        let told = ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm");
        farm.ask(async |ledger| ledger.record_outcome(build.id, &told).await.unwrap());
    }
}

fn order_state(farm: &HandDrivenFarm, name: &str) -> OrderState {
    farm.ask(async |ledger| ledger.find_order(name).await.unwrap().unwrap()).state
}

#[test]
fn an_order_is_not_complete_while_a_file_that_its_list_names_has_not_come() {
    let mut farm = farm(8.0);
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_bytes("kit/order.csv", b"file;copies;customer\na.stl;2;Brandt\nB;4;Brandt\nc.stl;x;\n");
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_until("the list is out", |farm| !farm.folder("inbox").join("kit/order.csv").exists());
    let list = fs::read_to_string(farm.folder("error").join("kit/order.csv.reason.txt")).unwrap();
    assert!(list.contains("B") && list.contains("Drop these files into kit"), "{list}");
    let mut missing = farm.parts(PartState::Refused);
    missing.sort_by(|one, other| one.name.cmp(&other.name));
    let [b, c] = &missing[..] else { panic!("{missing:#?}") };
    assert_eq!((b.name.as_str(), b.wanted_copies(), b.refused.refusal), ("B", 4, Some(RefusalCause::Missing)));
    assert!(b.refused.reason.contains("order.csv") && b.refused.reason.contains("nestd close kit"), "{b:?}");
    assert_eq!((c.name.as_str(), c.refused.refusal), ("c.stl", Some(RefusalCause::Ticket)));
    let retried = farm.order_and_wait(CommandKind::Retry, Some(b.id));
    assert_eq!(retried.state, CommandState::Refused, "there is no file: {retried:?}");
    print(&mut farm);
    assert_eq!(order_state(&farm, "kit"), OrderState::Short);
    farm.assert_ledger_agrees_with_folders();
    // The same list once more, now with other numbers: what it asks for takes the place of what was asked for.
    farm.drop_bytes("kit/order.csv", b"file;copies\nb.stl;5\nc.stl;1\n");
    farm.pass_until("the list was there", |farm| farm.folder("inbox").join("kit/order.csv").exists());
    farm.pass_until("the list is out again", |farm| !farm.folder("inbox").join("kit/order.csv").exists());
    let wanted = |farm: &HandDrivenFarm| {
        let lines = farm.ask(async |ledger| ledger.order_lines("kit").await.unwrap());
        lines.iter().map(|line| line.copies.wanted).sum::<u32>()
    };
    assert_eq!(wanted(&farm), 2 + 5 + 1);
    // They come after all, without a list.
    farm.drop_part("kit/b.stl", &block(10.0, 12.0, 15.0));
    farm.drop_part("kit/c.stl", &block(10.0, 12.0, 16.0));
    assert_eq!(copies(&mut farm, 2), [("b.stl".to_owned(), 5), ("c.stl".to_owned(), 1)]);
    assert!(farm.parts(PartState::Waiting).iter().all(|part| part.owed.question.is_empty()));
    print(&mut farm);
    assert_eq!((order_state(&farm, "kit"), wanted(&farm)), (OrderState::Complete, 8));
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn a_row_that_says_that_its_part_is_not_wanted_misses_nothing() {
    let mut farm = farm(4.0);
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_bytes("kit/order.csv", b"file;copies;status\na.stl;2;\nb.stl;4;cancelled\n");
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_until("the list is out", |farm| !farm.folder("inbox").join("kit/order.csv").exists());
    farm.pass_secs(2.0);
    assert!(farm.parts(PartState::Refused).is_empty());
    print(&mut farm);
    assert_eq!(order_state(&farm, "kit"), OrderState::Complete);
}

#[test]
fn a_drawing_beside_parts_is_no_part_and_a_part_of_another_program_is_one() {
    let mut farm = farm(4.0);
    for order in ["kit", "listed"] {
        farm.drop_part(&format!("{order}/a.stl"), &block(10.0, 12.0, 14.0));
        farm.drop_bytes(&format!("{order}/Zeichnung A.pdf"), b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n1 0 obj\n");
        farm.drop_bytes(&format!("{order}/photo.JPG"), b"\xff\xd8\xff\xe0\0\x10JFIF\0");
    }
    farm.drop_bytes("listed/order.csv", b"file;copies\na.stl;1\n");
    farm.drop_part("step/a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_bytes("step/lid.step", b"ISO-10303-21;\nHEADER;\n");
    farm.wait_for_parts(PartState::Waiting, 3);
    let refused = farm.wait_for_parts(PartState::Refused, 5);
    for part in &refused {
        let is_part = part.name == "lid.step";
        assert_eq!(part.wanted_copies(), u32::from(is_part), "{}: {}", part.name, part.refused.reason);
        let cause = if is_part { RefusalCause::Format } else { RefusalCause::Document };
        assert_eq!(part.refused.refusal, Some(cause), "{}: {}", part.name, part.refused.reason);
    }
    let lines = farm.ask(async |ledger| ledger.order_lines("kit").await.unwrap());
    assert_eq!(lines.iter().map(|line| line.copies.cancelled).sum::<u32>(), 0, "nobody cancelled anything");
    print(&mut farm);
    let states = ["kit", "listed", "step"].map(|order| order_state(&farm, order));
    assert_eq!(states, [OrderState::Complete, OrderState::Complete, OrderState::Short]);
    farm.assert_ledger_agrees_with_folders();
}
