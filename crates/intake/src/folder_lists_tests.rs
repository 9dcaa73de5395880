//! Tests of lists under other names than `order.csv`, of several lists in one folder, and of spreadsheets.

use super::{
    test_inbox::{TestInbox, files},
    *,
};

const LIST: &str = "file,copies\na.stl,30\n";
const HELD: OrderListRules = OrderListRules { incomplete_secs: 1000.0, unlisted: UnlistedPolicy::Refuse };
const OVER: OrderListRules = OrderListRules { incomplete_secs: 50.0, unlisted: UnlistedPolicy::Refuse };

/// Names and copies (or the error) of all parts that may be taken.
fn taken(farm: &TestInbox, rules: OrderListRules) -> Vec<(String, Result<Option<u32>, String>)> {
    let mut said = Vec::new();
    for judged in farm.judged(rules) {
        if let TakeDecision::Take(ready @ SettledEntry::Part { .. }) = judged {
            let claim = claim_part(&farm.inbox, &ready).unwrap();
            let copies = claim.read_part_spec().map(|spec| spec.ticket.copies).map_err(|why| why.to_string());
            said.push((claim.display_name(), copies));
            release_claim(&claim, "").unwrap();
        }
    }
    said
}

fn waits(farm: &TestInbox, rules: OrderListRules) -> Vec<String> {
    let why = |judged| if let TakeDecision::Wait(why) = judged { Some(why) } else { None };
    farm.judged(rules).into_iter().filter_map(why).collect()
}

/// Finishes lists and refuses what is to be refused, and returns the files in the error folder.
fn ended(farm: &TestInbox, rules: OrderListRules) -> Vec<String> {
    let mut lists = OrderListTracker::default();
    lists.observe_scan(&scan_inbox(&farm.inbox, ScanLimits::default()).unwrap().entries);
    for judged in farm.judged(rules) {
        match judged {
            TakeDecision::Take(SettledEntry::Refuse { seen, reason }) => {
                refuse_entry(&farm.inbox, &seen, &farm.error, &reason).unwrap();
            }
            TakeDecision::Take(list @ SettledEntry::List { .. }) => {
                let wait = rules.incomplete_secs;
                finish_order_list(&farm.inbox, &mut lists, &list, wait, &farm.archive, &farm.error).unwrap();
            }
            _ => {}
        }
    }
    files(&farm.error)
}

#[test]
fn the_only_list_of_a_folder_counts_whatever_its_name() {
    for name in
        ["order (1).csv", "Bestellung.csv", "BOM.TSV", "order.txt", "Order-7.TXT", "ORDER.CSV", "Stückliste.txt"]
    {
        for folder in ["", "order-9/"] {
            let farm = TestInbox::new();
            farm.drop_file(&format!("{folder}a.stl"), "solid");
            farm.drop_file(&format!("{folder}{name}"), LIST);
            assert_eq!(taken(&farm, HELD), [("a.stl".to_owned(), Ok(Some(30)))], "{folder}{name}");
            assert!(ended(&farm, HELD).is_empty(), "{folder}{name}");
            assert_eq!(files(&farm.archive), [format!("order-lists/{folder}{name}")]);
            assert!(files(&farm.inbox.join(".claimed/.lists")).is_empty(), "{folder}{name}");
        }
    }
}

#[test]
fn a_list_is_called_by_its_name() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("new.stl", "solid");
    farm.drop_file("Bestellung.csv", "file,copies\na.stl,none\n");
    assert_eq!(waits(&farm, HELD), ["new.stl stands in none of the 1 rows of Bestellung.csv"]);
    let taken = taken(&farm, HELD);
    assert!(taken[0].1.as_ref().is_err_and(|why| why.contains("Bestellung.csv")), "{taken:?}");
}

#[test]
fn a_text_that_is_no_list_of_files_beside_it_is_refused_alone() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("notes.txt", "please print these soon");
    farm.drop_file("other.txt", "file,copies\nb.stl,3\n");
    let names: Vec<String> = taken(&farm, HELD).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a.stl", "notes.txt", "other.txt"]);
}

#[test]
fn order_csv_counts_among_several_lists_after_a_wait() {
    let farm = TestInbox::new();
    farm.drop_file("k/a.stl", "solid");
    farm.drop_file("k/b.stl", "solid");
    farm.drop_file("k/order.csv", LIST);
    farm.drop_file("k/order2.csv", "file,copies\na.stl,2\nb.stl,5\n");
    let lists = "order2.csv and order.csv: put all rows into one list";
    let part = |name: &str| format!("k/{name} stands beside {lists}");
    assert_eq!(waits(&farm, HELD), [part("a.stl"), part("b.stl"), format!("k/{lists}")]);
    assert_eq!((taken(&farm, HELD), ended(&farm, HELD)), (Vec::new(), Vec::new()));
    let taken = taken(&farm, OVER);
    assert_eq!(taken[0], ("a.stl".to_owned(), Ok(Some(30))));
    assert!(taken[1].1.as_ref().is_err_and(|why| why.contains("none of the 1 rows of order.csv")), "{taken:?}");
    assert_eq!(ended(&farm, OVER), ["k/order2.csv", "k/order2.csv.reason.txt"]);
    assert_eq!(files(&farm.archive), ["order-lists/k/order.csv"]);
}

#[test]
fn of_two_lists_under_other_names_none_counts_until_one_is_left() {
    for unlisted in [UnlistedPolicy::Refuse, UnlistedPolicy::Warn] {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "solid");
        farm.drop_file("said.stl", "solid");
        farm.drop_file("said.stl.toml", "copies = 4");
        farm.drop_file("BOM.csv", LIST);
        farm.drop_file("order (1).csv", LIST);
        let why = "BOM.csv and order (1).csv: put all rows into one list";
        assert!(waits(&farm, HELD).contains(&format!("a.stl stands beside {why}")));
        assert_eq!(taken(&farm, HELD), [("said.stl".to_owned(), Ok(Some(4)))]);
        // A list stays as long as a part may belong to it, also where it is older than the part.
        assert!(ended(&farm, OVER).is_empty());
        let late = taken(&farm, OrderListRules { unlisted, ..OVER });
        assert_eq!((late.len(), late[0].1.is_ok()), (1, unlisted == UnlistedPolicy::Warn), "{late:?}");
        assert_eq!(ended(&farm, OVER).len(), 4);
        assert!(farm.dropped().is_empty());
    }
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    let other = farm.drop_file("BOM.csv", "file,copies\na.stl,2\n");
    farm.drop_file("order (1).csv", LIST);
    assert_eq!(taken(&farm, HELD), []);
    std::fs::remove_file(other).unwrap();
    assert_eq!(taken(&farm, HELD), [("a.stl".to_owned(), Ok(Some(30)))]);
}

#[test]
fn a_spreadsheet_holds_the_parts_beside_it() {
    for name in ["order.xlsb", "Bestellung.XLS", "BOM.ods", "list.numbers"] {
        let farm = TestInbox::new();
        farm.drop_file("z.stl", "solid");
        farm.drop_file(name, "PK");
        let waits = waits(&farm, HELD);
        assert!(waits[1].starts_with(&format!("z.stl stands beside {name}, a spreadsheet")), "{waits:?}");
        assert!(waits[1].ends_with("save it as XLSX or CSV"), "{waits:?}");
        assert_eq!(taken(&farm, HELD), []);
        let late = taken(&farm, OVER);
        assert!(late.len() == 1 && late[0].1.is_err(), "{late:?}");
        assert_eq!(ended(&farm, OVER), [name.to_owned(), format!("{name}.reason.txt")]);
    }
}

#[test]
fn what_is_called_a_list_or_a_ticket_and_cannot_be_read_holds_the_parts_beside_it() {
    for name in [
        "order.docx",
        "Bestellung 4711.pdf",
        "Purchase Order.rtf",
        "commande.odt",
        "注文書.pdf",
        "order.tab",
        "order.csv.gz",
        "order.csv.lnk",
        "order.html",
        "Bestellung.msg",
        "ticket.toml",
        "quantities.json",
        "quantities.txt",
        "Stückliste.txt",
        "ticket.txt",
    ] {
        let farm = TestInbox::new();
        farm.drop_file("z.stl", "solid");
        farm.drop_file(name, "copies = 7");
        let waits = waits(&farm, HELD);
        assert!(waits.iter().any(|why| why.starts_with(&format!("z.stl stands beside {name}, "))), "{name}: {waits:?}");
        assert_eq!(taken(&farm, HELD), [], "{name}");
        let late = taken(&farm, OVER);
        assert!(late.len() == 1 && late[0].1.is_err(), "{name}: {late:?}");
    }
    // What is called otherwise says nothing of copies.
    for name in ["drawing.pdf", "datasheet.docx", "border.pdf", "machine.toml"] {
        let farm = TestInbox::new();
        farm.drop_file("z.stl", "solid");
        farm.drop_file(name, "copies = 7");
        assert!(taken(&farm, HELD).iter().any(|(part, said)| part == "z.stl" && *said == Ok(None)), "{name}");
    }
}

#[test]
fn a_spreadsheet_beside_a_list_is_refused_and_the_list_counts() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("order.csv", LIST);
    farm.drop_file("order.xlsx", "PK");
    assert_eq!(taken(&farm, HELD), [("a.stl".to_owned(), Ok(Some(30)))]);
    assert_eq!(ended(&farm, HELD), ["order.xlsx", "order.xlsx.reason.txt"]);
}

#[test]
fn a_workbook_alone_is_the_list_and_two_of_them_hold_the_parts() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("Bestellung.XLSX", "PK\u{3}\u{4} cut off");
    let why = "a.stl stands beside Bestellung.XLSX, which is not understood: as a package it is damaged";
    assert!(waits(&farm, HELD).iter().any(|wait| wait.starts_with(why)), "{:?}", waits(&farm, HELD));
    farm.drop_file("b.xlsm", "PK");
    assert!(
        waits(&farm, HELD).iter().any(|wait| wait.contains("put all rows into one list")),
        "{:?}",
        waits(&farm, HELD)
    );
    assert_eq!(taken(&farm, HELD), []);
}

#[test]
fn a_part_below_a_folder_with_a_list_that_cannot_be_read_is_asked_about() {
    for name in ["Bestellung.ods", "Bestellung.xlsx", "order.csv"] {
        let farm = TestInbox::new();
        farm.drop_file(&format!("order-9/{name}"), "PK");
        farm.drop_file("order-9/stl/a.stl", "solid");
        let spec = farm.claim().read_part_spec().unwrap();
        assert!(spec.warnings.iter().any(|warning| build_file::is_copies_question(warning)), "{name}: {spec:?}");
    }
}

#[test]
fn a_claim_of_an_earlier_nestd_keeps_a_table_as_its_part() {
    let farm = TestInbox::new();
    let path = farm.inbox.join(".claimed/20260101T000000000Z-0001-00000000/Bestellung.csv");
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, LIST).unwrap();
    let (claims, warnings) = recover_claims(&farm.inbox, "").unwrap();
    assert_eq!((claims.len(), warnings.len()), (1, 0));
    give_back_claim(&claims[0]).unwrap();
    assert_eq!(farm.dropped(), ["Bestellung.csv"]);
}

#[test]
fn a_table_called_after_a_part_whose_rows_name_no_file_holds_that_part_alone() {
    for name in ["x.stl.csv.txt", "X.STL.csv", "x.stl.tsv"] {
        let farm = TestInbox::new();
        farm.drop_file("k/x.stl", "solid");
        farm.drop_file("k/y.stl", "solid");
        farm.drop_file(&format!("k/{name}"), "copies,7\n");
        let why = format!("k/x.stl waits, because {name} is not read: a ticket is named like the whole part file");
        assert!(waits(&farm, HELD)[0].starts_with(&why), "{:?}", waits(&farm, HELD));
        assert_eq!(taken(&farm, HELD), [("y.stl".to_owned(), Ok(None))], "{name}");
        assert!(ended(&farm, OVER).iter().any(|refused| refused.ends_with("x.stl.reason.txt")), "{name}");
    }
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("a.stl.csv", LIST);
    assert_eq!(taken(&farm, HELD), [("a.stl".to_owned(), Ok(Some(30)))], "it names its part, so it is a list");
}

#[test]
fn a_hidden_ticket_holds_its_part_and_nothing_else() {
    for ticket in [".x.stl.toml", ".x.toml", ".x.json", ".X.toml.txt"] {
        let farm = TestInbox::new();
        for name in ["x.stl", "y.stl", "._y.stl.toml", "._y.toml", ".z.stl.toml", ".z.toml", ticket] {
            farm.drop_file(name, "copies = 7");
        }
        let held = waits(&farm, HELD);
        let why = format!("x.stl waits, because {ticket} is hidden");
        assert!(held.len() == 1 && held[0].starts_with(&why), "{held:?}");
        assert_eq!(taken(&farm, HELD), [("y.stl".to_owned(), Ok(None))]);
        assert_eq!(ended(&farm, OVER), ["x.stl", "x.stl.reason.txt"]);
    }
}

#[test]
fn a_hidden_list_holds_the_parts_beside_it_and_stays() {
    for list in [".order.csv", ".Order.CSV.txt", ".order.txt", ".bom.tsv", ".list.xlsx"] {
        let farm = TestInbox::new();
        for name in ["k/a.stl", "b.stl"] {
            farm.drop_file(name, "solid");
        }
        farm.drop_file(&format!("k/{list}"), LIST);
        farm.drop_file(&format!("empty/{list}"), LIST);
        let why =
            format!("k/a.stl stands beside {list}, which is hidden, so nestd does not read it: take away the dot");
        let held = waits(&farm, HELD);
        assert!(held.len() == 1 && held[0].starts_with(&why), "{held:?}");
        assert_eq!(taken(&farm, HELD), [("b.stl".to_owned(), Ok(None))]);
        let told = taken(&farm, OVER);
        assert!(told.len() == 1 && told[0].1.as_ref().is_err_and(|why| why.contains("is hidden")), "{told:?}");
        assert!(ended(&farm, OVER).is_empty() && farm.inbox.join(format!("k/{list}")).exists(), "{list}");
    }
}

#[test]
fn what_programs_hide_or_leave_beside_a_part_says_nothing_of_it() {
    let left = [
        "._order.csv",
        ".~lock.order.csv#",
        "~$list.xlsx",
        "._a.stl",
        "._a.toml",
        "a.stl.toml.bak",
        "a.stl.toml~",
        ".a.stl.toml.swp",
        ".DS_Store",
    ];
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    for name in left {
        farm.drop_file(name, "copies = 7");
    }
    assert!(waits(&farm, HELD).is_empty(), "{:?}", waits(&farm, HELD));
    assert_eq!(taken(&farm, HELD), [("a.stl".to_owned(), Ok(None))]);
    // Beside a ticket or a list that counts, a hidden one is what a program has left.
    let farm = TestInbox::new();
    for name in ["a.stl", "k/a.stl", ".a.toml", "k/.order.csv"] {
        farm.drop_file(name, "copies = 7");
    }
    farm.drop_file("a.stl.toml", "copies = 3");
    farm.drop_file("k/order.csv", LIST);
    assert!(waits(&farm, HELD).is_empty(), "{:?}", waits(&farm, HELD));
    assert_eq!(taken(&farm, HELD), [("a.stl".to_owned(), Ok(Some(3))), ("a.stl".to_owned(), Ok(Some(30)))]);
}
