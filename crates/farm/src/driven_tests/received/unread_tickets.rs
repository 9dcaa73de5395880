//! Tickets and order lists that cannot be read, or that say no: their parts are never taken without them.

use std::{
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
};

use ledger::{BuildState, CommandKind, CommandState, OrderState, PartRow, PartState, PrintOutcome, ToldOutcome};
use ledger_fixtures::ToldWords;

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, QUICK, block, stl},
};

/// A farm in which parts and lists that do not fit together wait for some seconds.
fn farm() -> HandDrivenFarm {
    HandDrivenFarm::open(&format!("{QUICK}incomplete_secs = 8\n[trigger]\nmax_wait_secs = \"24h\"\n"))
}

/// The parts that were taken.
fn taken(farm: &HandDrivenFarm) -> Vec<(String, PartState)> {
    let states = [PartState::Claimed, PartState::Waiting, PartState::Batched, PartState::Built, PartState::Refused];
    states.into_iter().flat_map(|state| farm.parts(state)).map(|part| (part.name, part.state)).collect()
}

fn reason_of(farm: &HandDrivenFarm, name: &str) -> PathBuf {
    farm.folder("error").join(format!("{name}.reason.txt"))
}

/// Puts something that is no file into the hot folder.
fn put_in_place(farm: &HandDrivenFarm, kind: &str, name: &str, content: &str) {
    let path = farm.folder("inbox").join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    match kind {
        "link" => {
            let template = farm.root().join(format!("template of {}", name.replace('/', "-")));
            fs::write(&template, content).unwrap();
            symlink(template, path).unwrap();
        }
        "pipe" => {
            let mode = rustix::fs::Mode::from_raw_mode(0o644);
            rustix::fs::mknodat(rustix::fs::CWD, &path, rustix::fs::FileType::Fifo, mode, 0).unwrap();
        }
        _ => fs::create_dir(path).unwrap(),
    }
}

#[test]
fn a_part_beside_a_ticket_or_list_that_is_no_file_is_refused_with_it() {
    let mut farm = farm();
    let mut refused = Vec::new();
    for kind in ["link", "pipe", "folder"] {
        for (at, name) in ["a.stl.toml", "a.json", "order.csv", "Liste.CSV"].into_iter().enumerate() {
            let (folder, list) = (format!("{kind}{at}"), "file;copies\na.stl;7\n");
            let content = if name.ends_with("toml") { "copies = 7\nunit = \"inch\"\n" } else { list };
            put_in_place(&farm, kind, &format!("{folder}/{name}"), content);
            farm.drop_part(&format!("{folder}/a.stl"), &block(10.0, 12.0, 14.0));
            refused.extend([format!("{folder}/a.stl"), format!("{folder}/{name}")]);
        }
    }
    farm.pass_secs(4.0);
    assert!(farm.has_alert(AlertKind::Incomplete), "they wait");
    assert_eq!(taken(&farm), []);
    farm.pass_until("both are refused", |farm| refused.iter().all(|name| reason_of(farm, name).exists()));
    let text = fs::read_to_string(reason_of(&farm, "link0/a.stl")).unwrap();
    assert!(text.contains("a.stl.toml is a symbolic link, so nestd does not read it"), "{text}");
    // A part that a list was to name has a row, as every part that its list does not name.
    assert!(taken(&farm).iter().all(|(_, state)| *state == PartState::Refused));
    farm.pass_until("nothing waits", |farm| !farm.has_alert(AlertKind::Incomplete));
}

#[test]
fn a_template_that_is_copied_over_its_link_is_obeyed() {
    let mut farm = farm();
    put_in_place(&farm, "link", "a.stl.toml", "copies = 7\n");
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.pass_secs(3.0);
    assert_eq!(taken(&farm), []);
    farm.drop_bytes("a.stl.toml", b"copies = 7\n");
    assert_eq!(farm.wait_for_parts(PartState::Waiting, 1)[0].owed.copies, 7);
}

#[test]
fn a_text_of_another_kind_beside_a_part_holds_it_and_says_how_a_ticket_is_named() {
    let mut farm = farm();
    let texts = ["a.txt", "a.stl.txt", "a.ini", "a.stl.yaml", "a.yml", "a.xml", "a.TXT"];
    for (at, name) in texts.into_iter().enumerate() {
        farm.drop_part(&format!("{at}/a.stl"), &block(10.0, 12.0, 14.0 + at as f64));
        farm.drop_bytes(&format!("{at}/{name}"), b"copies = 7\n");
    }
    farm.pass_secs(4.0);
    assert_eq!(taken(&farm), []);
    let reasons: Vec<PathBuf> = (0..texts.len()).map(|at| reason_of(&farm, &format!("{at}/a.stl"))).collect();
    farm.pass_until("the parts are refused", |_| reasons.iter().all(|reason| reason.exists()));
    let text = fs::read_to_string(&reasons[0]).unwrap();
    assert!(text.contains("a ticket is named like the whole part file with .toml added"), "{text}");
}

#[test]
fn a_ticket_or_list_behind_which_an_editor_has_put_txt_is_read() {
    let mut farm = farm();
    for (at, name) in ["a.toml.txt", "a.stl.toml.txt", "a.stl.JSON.TXT", "Liste.csv.txt"].into_iter().enumerate() {
        let text = match at {
            2 => "{\"copies\": 7}",
            3 => "Datei;Menge\na.stl;7\n",
            _ => "copies = 7\n",
        };
        farm.drop_part(&format!("{at}/a.stl"), &block(10.0, 12.0, 14.0 + at as f64));
        farm.drop_bytes(&format!("{at}/{name}"), text.as_bytes());
    }
    let parts = farm.wait_for_parts(PartState::Waiting, 4);
    assert_eq!(parts.iter().map(|part| part.owed.copies).collect::<Vec<_>>(), [7; 4]);
}

#[test]
fn a_ticket_that_may_be_for_several_parts_holds_them() {
    let mut farm = farm();
    for name in ["a.stl", "A.STL", "a.toml"] {
        let bytes = if name == "a.toml" { b"copies = 7\n".to_vec() } else { stl(&block(10.0, 12.0, 14.0)) };
        farm.drop_bytes(&format!("kit/{name}"), &bytes);
    }
    farm.pass_secs(4.0);
    assert_eq!(taken(&farm), []);
    farm.pass_until("they are refused", |farm| {
        ["a.stl", "A.STL"].iter().all(|name| reason_of(farm, &format!("kit/{name}")).exists())
    });
}

#[test]
fn a_row_that_says_no_in_another_column_is_asked_about() {
    let mut farm = farm();
    let rows = [
        ("print?", "no"),
        ("status", "cancelled"),
        ("active", "FALSE"),
        ("Storniert", "ja"),
        ("gefertigt", "x"),
        ("drucken", "nein"),
        ("statut", "annulé"),
        ("imprimer", "non"),
        ("状態", "キャンセル"),
        ("印刷", "無"),
        ("Bemerkung", "nicht drucken"),
    ];
    for (at, (header, cell)) in rows.into_iter().enumerate() {
        farm.drop_part(&format!("{at}/a.stl"), &block(10.0, 12.0, 14.0));
        farm.drop_part(&format!("{at}/b.stl"), &block(10.0, 12.0, 15.0));
        let list = format!("file;copies;{header}\na.stl;2;{cell}\nb.stl;3;\n");
        farm.drop_bytes(&format!("{at}/order.csv"), list.as_bytes());
    }
    let parts = farm.wait_for_parts(PartState::Waiting, 2 * rows.len());
    for part in &parts {
        assert_eq!(
            !part.owed.question.is_empty(),
            part.name == "a.stl",
            "{}: {}",
            part.terms.order_name,
            part.owed.question
        );
    }
    assert!(farm.has_alert(AlertKind::Question));
    let asked = parts.iter().find(|part| part.terms.order_name == "1" && part.name == "a.stl").unwrap();
    assert!(asked.owed.question.contains("status = cancelled"), "{}", asked.owed.question);
    assert_eq!(farm.order_and_wait(CommandKind::Confirm, Some(asked.id)).state, CommandState::Done);
    assert_eq!(farm.ask(async |ledger| ledger.find_part(asked.id).await.unwrap().unwrap()).owed.question, "");
}

#[test]
fn a_part_that_was_refused_because_of_its_row_is_not_said_to_be_missing() {
    let mut farm = farm();
    farm.drop_bytes("kit/order.csv", b"file;copies\na.stl;0\nb.stl;2\n");
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("kit/b.stl", &block(10.0, 12.0, 15.0));
    let told = |farm: &HandDrivenFarm| farm.has_alert(AlertKind::Incomplete);
    let list = reason_of(&farm, "kit/order.csv");
    let mut was_told = false;
    farm.pass_until("the list lies beside the part", |farm| {
        was_told |= told(farm);
        list.exists()
    });
    assert!(reason_of(&farm, "kit/a.stl").exists());
    assert!(!was_told, "nothing is missing");
    let text = fs::read_to_string(list).unwrap();
    assert!(text.contains("a.stl") && text.contains("mend"), "{text}");
}

#[test]
fn a_late_ticket_or_list_is_not_said_to_lack_its_part_while_it_is_applied() {
    let mut farm = farm();
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("b.stl", &block(10.0, 12.0, 15.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.drop_bytes("a.stl.toml", b"copies = 9\n");
    farm.drop_bytes("order.csv", b"file;copies\nb.stl;4\n");
    let mut was_told = false;
    farm.pass_until("both are applied", |farm| {
        was_told |= farm.has_alert(AlertKind::Incomplete);
        !farm.folder("inbox").join("a.stl.toml").exists() && !farm.folder("inbox").join("order.csv").exists()
    });
    let mut copies: Vec<u32> = farm.parts(PartState::Waiting).iter().map(PartRow::wanted_copies).collect();
    copies.sort_unstable();
    assert_eq!((copies, was_told), (vec![4, 9], false));
}

#[test]
fn an_order_whose_refused_row_was_mended_and_printed_is_complete() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\nmax_wait_secs = \"24h\"\n"));
    farm.drop_bytes("kit/a.stl.toml", b"copies = \"many\"\n");
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 14.0));
    let refused = farm.wait_for_parts(PartState::Refused, 1).remove(0);
    farm.drop_bytes("kit/a.stl.toml", b"copies = 3\n");
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(2.0);
    let build = farm.ask(async |ledger| ledger.builds_in_state(BuildState::Published).await.unwrap()).remove(0).id;
    let told = ToldOutcome::new(PrintOutcome::Complete, "", "ann@farm");
    farm.ask(async |ledger| ledger.record_outcome(build, &told).await.unwrap());
    let order = farm.ask(async |ledger| ledger.find_order("kit").await.unwrap().unwrap());
    assert_eq!(order.state, OrderState::Complete);
    farm.assert_ledger_agrees_with_folders();
    // Where both are wanted, the refused one can still be asked for.
    let lines = farm.ask(async |ledger| ledger.order_lines("kit").await.unwrap());
    let line = lines.iter().find(|line| line.part == refused.id).unwrap();
    assert_eq!((line.copies.wanted, line.copies.refused, line.copies.cancelled), (0, 0, 1));
}

#[test]
fn an_unreadable_ticket_leaves_with_its_part_and_never_before() {
    let mut farm = farm();
    put_in_place(&farm, "link", "a.json", "{\"copies\": 7}");
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    let exists = |path: &Path| path.symlink_metadata().is_ok();
    farm.pass_until("the ticket is refused", |farm| {
        let (part, ticket) = (farm.folder("inbox").join("a.stl"), farm.folder("inbox").join("a.json"));
        assert!(exists(&ticket) || !exists(&part), "the part would be taken without it");
        !exists(&ticket)
    });
    assert!(exists(&farm.folder("error").join("a.stl")));
    assert_eq!(taken(&farm), []);
}
