//! Order lists in the formats that people use.

use std::fs;

use ledger::{
    BuildState, CommandKind, CommandState, OrderState, PartRow, PartState, PrintOutcome, RefusalCause, ToldOutcome,
};

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
    assert!(b.refused.reason.contains("order.csv") && b.refused.reason.contains("nestd cancel"), "{b:?}");
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
    // Restoring and repairing read the hash of each part.
    let rows = farm.parts(PartState::Refused);
    let is_settled = |row: &PartRow| row.refused.reason.contains("took its place") && row.file.content_hash.len() == 64;
    assert!(rows.iter().all(is_settled), "{rows:#?}");
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

/// Copies wanted of the lines of an order: name, folder where it was asked for, copies.
fn wanted(farm: &HandDrivenFarm, order: &str) -> Vec<(String, u32)> {
    let lines = farm.ask(async |ledger| ledger.order_lines(order).await.unwrap());
    let mut wanted: Vec<_> = lines.into_iter().map(|line| (line.name, line.copies.wanted)).collect();
    wanted.retain(|(_, copies)| *copies > 0);
    wanted.sort();
    wanted
}

fn names<const N: usize>(named: [(&str, u32); N]) -> Vec<(String, u32)> {
    named.map(|(name, copies)| (name.to_owned(), copies)).to_vec()
}

/// Drops a list beside a part of the order, and waits until the files that it names without reason are missed.
fn miss(farm: &mut HandDrivenFarm, order: &str, rows: &str) {
    farm.drop_bytes(&format!("{order}/order.csv"), format!("file;copies;order\n{rows}").as_bytes());
    farm.pass_until("the list is there", |farm| farm.folder("inbox").join(order).join("order.csv").exists());
    farm.pass_until("the list is out", |farm| !farm.folder("inbox").join(order).join("order.csv").exists());
}

#[test]
fn only_the_file_that_a_row_means_takes_its_place() {
    let mut farm = farm(4.0);
    miss(&mut farm, "kit", "b;4;\nM3;7;\nM3.5;6;\nx/c.stl;4;\ny/c.stl;5;\nTeil \u{e4}.stl;2;\ndraw.pdf;1;\n");
    let all = [("M3", 7), ("M3.5", 6), ("Teil \u{e4}.stl", 2), ("b", 4), ("c.stl", 4), ("c.stl", 5)];
    assert_eq!(wanted(&farm, "kit"), names(all));
    // Neither a document nor a file with a longer name.
    farm.drop_bytes("kit/b.pdf", b"%PDF-1.7\n");
    farm.drop_bytes("kit/b.stl.pdf", b"%PDF-1.7\n");
    farm.wait_for_parts(PartState::Refused, all.len() + 2);
    assert_eq!(wanted(&farm, "kit"), names(all));
    for (at, name) in ["b.stl", "M3.5.STL", "y/c.stl", "Teil a\u{308}.stl"].into_iter().enumerate() {
        farm.drop_part(&format!("kit/{name}"), &block(10.0, 12.0, 20.0 + at as f64));
    }
    let mut came: Vec<_> = farm
        .wait_for_parts(PartState::Waiting, 4)
        .iter()
        .map(|part| (part.terms.order_name.clone(), part.wanted_copies()))
        .collect();
    came.sort();
    assert_eq!(came, names([("kit", 2), ("kit", 4), ("kit", 6), ("kit/y", 5)]));
    farm.assert_ledger_agrees_with_folders();
}

#[test]
fn rows_of_several_orders_lists_and_folders_miss_their_own_files() {
    let mut farm = farm(4.0);
    miss(&mut farm, "all", "b.stl;4;K-1\nb.stl;5;K-2\n");
    assert_eq!((wanted(&farm, "K-1"), wanted(&farm, "K-2")), (names([("b.stl", 4)]), names([("b.stl", 5)])));
    let list = fs::read_to_string(farm.folder("error").join("all/order.csv.reason.txt")).unwrap();
    assert!(list.contains("together with a list"), "{list}");
    miss(&mut farm, "kit", "b.stl;4;\n");
    miss(&mut farm, "kit/sub", "b.stl;3;\n");
    assert_eq!((wanted(&farm, "kit"), wanted(&farm, "kit/sub")), (names([("b.stl", 4)]), names([("b.stl", 3)])));
    farm.drop_part("kit/sub/b.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!((wanted(&farm, "kit"), wanted(&farm, "kit/sub")), (names([("b.stl", 4)]), names([("b.stl", 3)])));
    // Rows of one list that name a file twice: nobody knows how many are wanted.
    miss(&mut farm, "twice", "b.stl;4;\nB.STL;1;\n");
    let twice = farm.parts(PartState::Refused).into_iter().rfind(|part| part.terms.order_name == "twice").unwrap();
    assert_eq!(twice.refused.refusal, Some(RefusalCause::Ticket));
}

#[test]
fn a_list_that_comes_again_misses_nothing_that_came_and_a_file_says_less_than_its_row() {
    let mut farm = farm(4.0);
    miss(&mut farm, "kit", "b;4;\nd_x5.stl;1;\ne.stl;3;\nf.stl;2;\n");
    farm.drop_part("kit/b.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("kit/d_x5.stl", &block(10.0, 12.0, 15.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    let asked = names([("b.stl", 4), ("d_x5.stl", 1), ("e.stl", 3), ("f.stl", 2)]);
    assert_eq!(wanted(&farm, "kit"), asked);
    print(&mut farm);
    miss(&mut farm, "kit", "b;4;\nd_x5.stl;1;\n");
    assert_eq!(wanted(&farm, "kit"), asked);
    // One row is given up, and one is cancelled and comes as another file.
    let line = |farm: &HandDrivenFarm, name: &str| {
        farm.parts(PartState::Refused).into_iter().rfind(|part| part.name == name).unwrap().id
    };
    let gone = line(&farm, "f.stl");
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(gone)).state, CommandState::Done);
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(gone)).state, CommandState::Refused);
    farm.drop_part("kit/e.stl", &block(10.0, 12.0, 16.0));
    let e = farm.wait_for_parts(PartState::Waiting, 1).remove(0);
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(e.id)).state, CommandState::Done);
    assert_eq!(wanted(&farm, "kit"), names([("b.stl", 4), ("d_x5.stl", 1)]));
    assert_eq!(order_state(&farm, "kit"), OrderState::Complete);
    farm.drop_part("kit/e.stl", &block(10.0, 12.0, 17.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!(wanted(&farm, "kit"), names([("b.stl", 4), ("d_x5.stl", 1), ("e.stl", 3)]));
    assert_eq!(farm.order_and_wait(CommandKind::Retry, Some(e.id)).state, CommandState::Done);
    farm.wait_for_parts(PartState::Waiting, 2);
    assert_eq!(wanted(&farm, "kit").len(), 4, "who takes the earlier one back wants it as well");
    farm.assert_ledger_agrees_with_folders();
}
