//! Tests of what stands above a table, of priorities and of further columns.

use std::ffi::OsStr;

use super::OrderList;
use crate::{DueDate, Ticket};

fn ticket(list: &OrderList, name: &str) -> Ticket {
    let row = list.row_for_file(OsStr::new(name)).unwrap().unwrap();
    let alone = OrderList::parse_single_row(&row.text).unwrap();
    assert_eq!(alone.ticket, row.ticket, "the row speaks for itself: {}", row.text);
    row.ticket.clone().unwrap()
}

#[test]
fn what_stands_above_the_table_is_said_of_each_row() {
    let day = Some(DueDate::Day(jiff::civil::date(2026, 12, 11)));
    for above in [
        "Auftragsnummer: 4711;;\nKunde: Meier GmbH;;\nLiefertermin: 11.12.2026;;\n;;\n",
        "Bestellung Meier;;\nAuftragsnummer;4711;\nKunde:;Meier GmbH;\nLiefertermin:;11.12.2026;\n",
    ] {
        let list = OrderList::parse_list(format!("{above}Pos.;Datei;Stück\n1;a.stl;2\n2;b.stl;3\n").as_bytes());
        for (name, copies) in [("a.stl", 2), ("b.stl", 3)] {
            let said = ticket(&list, name);
            assert_eq!((said.copies, said.due), (Some(copies), day), "{above}");
            assert_eq!(
                (said.order.as_deref(), said.customer.as_deref()),
                (Some("4711"), Some("Meier GmbH")),
                "{above}"
            );
        }
        assert!(list.warnings().iter().all(|one| !one.contains("above")), "{:?}", list.warnings());
    }
    // A row has the last word.
    let list = OrderList::parse_list(b"Kunde: Meier;;\nfile;copies;customer\na.stl;2;Brandt\nb.stl;1;\n");
    assert_eq!(ticket(&list, "a.stl").customer.as_deref(), Some("Brandt"));
    assert_eq!(ticket(&list, "b.stl").customer.as_deref(), Some("Meier"));
}

#[test]
fn a_known_word_above_the_table_that_cannot_be_read_is_told() {
    for line in ["Liefertermin: bald", "Kunde: Meier;Brandt", "Due date: 1.2.2026;3.4.2026"] {
        let list = OrderList::parse_list(format!("{line}\nfile;copies;note\na.stl;2;\n").as_bytes());
        assert_eq!(ticket(&list, "a.stl"), Ticket { copies: Some(2), ..Ticket::default() }, "{line}");
        let word = line.split(' ').next_back().unwrap().split(';').next().unwrap();
        assert!(
            list.warnings().iter().any(|one| one.contains("above the table") && one.contains(word)),
            "{line}: {:?}",
            list.warnings()
        );
    }
}

#[test]
fn priorities_that_are_all_small_are_told() {
    let warns = |priorities: [&str; 2]| {
        let list = format!("file;copies;Priorität\na.stl;1;{}\nb.stl;1;{}\n", priorities[0], priorities[1]);
        OrderList::parse_list(list.as_bytes()).warnings().iter().any(|one| one.contains("priority"))
    };
    assert!(warns(["1", "5"]) && warns(["", "2"]));
    assert!(!warns(["1", "60"]) && !warns(["", ""]) && !warns(["90", "10"]));
}

#[test]
fn several_numbers_of_pieces_are_not_guessed() {
    for header in ["file;Menge bestellt;Menge geliefert;Restmenge", "file;qty;remaining;x", "file;Menge;Rückstand;x"] {
        let list = OrderList::parse_list(format!("{header}\na.stl;10;6;4\n").as_bytes());
        let why = list.row_for_file(OsStr::new("a.stl")).unwrap_err();
        assert!(why.contains("two columns for copies"), "{header}: {why}");
    }
}

#[test]
fn a_day_to_ship_by_is_the_due_date_and_a_line_item_the_file() {
    let list = OrderList::parse_list(b"Name,Lineitem quantity,Lineitem name,Ship By\n#1001,3,bracket.stl,2026-12-11\n");
    let said = ticket(&list, "bracket.stl");
    assert_eq!((said.copies, said.due), (Some(3), Some(DueDate::Day(jiff::civil::date(2026, 12, 11)))));
}

#[test]
fn the_column_in_which_the_files_stand_is_theirs() {
    for (text, count) in [
        ("Item,Description,Part Number,Qty\n1,Bracket left,bracket,3\n2,Lid,lid,2\n", 2),
        ("Name;Bezeichnung;Menge\nPos 1;BRACKET;3\nPos 2;teile\\lid;2\n", 2),
    ] {
        let files = ["bracket.stl", "lid.stl"].map(OsStr::new);
        let list = OrderList::parse_for_files(text.as_bytes(), &files);
        let copies: Vec<Option<u32>> = files
            .iter()
            .filter_map(|file| list.row_for_file(file).unwrap())
            .map(|row| OrderList::parse_single_row(&row.text).unwrap().ticket.unwrap().copies)
            .collect();
        assert_eq!((copies.len(), &copies[..]), (count, &[Some(3), Some(2)][..]), "{text}");
    }
}
