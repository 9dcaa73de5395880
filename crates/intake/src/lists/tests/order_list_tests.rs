//! Tests of order lists as people write them, byte for byte.

use nester::OrientationRule;

use super::*;
use crate::names::due_date::parse_due;

fn list(text: &str) -> OrderList {
    OrderList::parse_list(text.as_bytes())
}

fn row<'a>(list: &'a OrderList, name: &str) -> &'a OrderListRow {
    list.row_for_file(OsStr::new(name)).unwrap().unwrap_or_else(|| panic!("no row for {name}"))
}

#[test]
fn each_column_is_read() {
    let list = list("file,copies,due,priority,orientation\na.stl,10,2026-11-25,80,fixed\nb.stl,,,,\n");
    let ticket = row(&list, "a.stl").ticket.clone().unwrap();
    assert_eq!((ticket.copies, ticket.priority), (Some(10), Some(80)));
    assert_eq!(ticket.orientation, Some(OrientationRule::Fixed));
    assert_eq!(ticket.due, Some(parse_due("2026-11-25").unwrap()));
    assert_eq!(row(&list, "a.stl").text, "file,copies,due,priority,orientation\na.stl,10,2026-11-25,80,fixed");
    assert_eq!(row(&list, "b.stl").ticket, Ok(Ticket::default()));
    assert_eq!(list.row_for_file(OsStr::new("c.stl")), Ok(None));
}

#[test]
fn lists_of_spreadsheets_are_read() {
    for text in [
        "\u{feff}File;Copies\r\n\"gr\u{f6}\u{df}e; 2.stl\";3\r\n;\r\n",
        "copies\tfile\n3\tgr\u{f6}\u{df}e; 2.stl\n",
        "file , copies\n gr\u{f6}\u{df}e; 2.stl , 3",
    ] {
        assert_eq!(row(&list(text), "größe; 2.stl").ticket.clone().unwrap().copies, Some(3), "{text:?}");
    }
    let latin1 = OrderList::parse_list(b"file,copies\ngr\xf6\xdfe.stl,3\n");
    assert_eq!(row(&latin1, "größe.stl").ticket.clone().unwrap().copies, Some(3));
}

#[test]
fn quantity_is_another_word_for_copies() {
    for text in ["file,quantity\na.stl,3\n", "Qty;File\n3;a.stl\n", "file\tQUANTITY\na.stl\t3\n"] {
        assert_eq!(row(&list(text), "a.stl").ticket.clone().unwrap().copies, Some(3), "{text:?}");
    }
    let both = list("file,copies,qty\na.stl,3,4\n");
    assert_eq!(both.row_for_file(OsStr::new("a.stl")).unwrap_err(), "it has two columns for copies");
}

#[test]
fn letters_may_differ_in_case_where_no_row_fits_exactly() {
    let list = list("file,copies\nPart.STL,3\na.stl,1\nA.stl,2\n");
    assert_eq!(row(&list, "part.stl").ticket.clone().unwrap().copies, Some(3));
    assert_eq!(row(&list, "A.stl").ticket.clone().unwrap().copies, Some(2));
}

#[test]
fn names_that_are_no_text_are_found_by_what_status_shows() {
    use std::os::unix::ffi::OsStrExt;
    let list = list("file,copies\na\\xff.stl,3\n");
    assert!(list.row_for_file(OsStr::from_bytes(b"a\xff.stl")).unwrap().is_some());
}

#[test]
fn a_broken_row_speaks_for_its_own_file_only() {
    let list = list(
        "file,copies,priority\na.stl,ten,\nb.stl,0,\nc.stl,1,101\nd.stl,1,1,1\n../e.stl,1,\nf.stl,2,\nf.stl,3,\ng.stl,4\n",
    );
    for (name, said) in [
        ("a.stl", "\"ten\" is no whole number"),
        ("b.stl", "1 to 10000"),
        ("c.stl", "0 to 100"),
        ("d.stl", "4 cells"),
        ("../e.stl", "a path"),
        ("f.stl", "2 rows"),
    ] {
        let why = list.row_for_file(OsStr::new(name)).unwrap_err();
        assert!(why.contains(said), "{name}: {why}");
    }
    assert_eq!(row(&list, "g.stl").ticket.clone().unwrap().copies, Some(4));
}

#[test]
fn a_list_that_is_not_understood_says_so_of_every_file() {
    for text in ["a.stl", "a.stl,b.stl,10\n", "a.stl,10\nb.stl\n", "file,file\na.stl,10\n", "price,sum\na.stl,10\n"] {
        let list = list(text);
        assert!(list.rows().is_err(), "{text}");
        assert!(list.row_for_file(OsStr::new("a.stl")).is_err(), "{text}");
        assert!(list.row_for_file(OsStr::new("b.stl")).is_err(), "{text}");
    }
    assert!(list("").rows().is_err());
}

fn copies_of(bytes: &[u8], files: &[&str], name: &str) -> Option<u32> {
    let files: Vec<&OsStr> = files.iter().map(OsStr::new).collect();
    let list = OrderList::parse_for_files(bytes, &files);
    let meant = list.match_files(files.iter().copied());
    let meaning = meant.files.get(OsStr::new(name)).unwrap_or_else(|| panic!("{name} is not in {list:?}"));
    list.matched_row(meaning, OsStr::new(name)).unwrap().ticket.clone().unwrap().copies
}

#[test]
fn excels_unicode_text_is_read() {
    let text = "Datei\tStückzahl\tFällig\tPreis\r\nGröße.stl\t12\t25.11.2026\t3,50\r\n";
    let bytes: Vec<u8> = [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert_eq!(copies_of(&bytes, &["Größe.stl"], "Größe.stl"), Some(12));
    let list = OrderList::parse_list(&bytes);
    assert_eq!(row(&list, "größe.stl").ticket.clone().unwrap().due, Some(parse_due("2026-11-25").unwrap()));
    assert_eq!(list.warnings(), ["The column \"Preis\" of its order list is unknown to nestd and was ignored."]);
}

#[test]
fn the_files_beside_it_tell_the_code_page() {
    // "Größe.stl;7" after a header, as DOS (850), Windows (1252), a Mac, Central Europe's DOS and Windows write it.
    for name in [&b"Gr\x94\xe1e"[..], b"Gr\xf6\xdfe", b"Gr\x9a\xa7e"] {
        let bytes = [b"datei;menge\r\n", name, b".stl;7\r\n"].concat();
        assert_eq!(copies_of(&bytes, &["Größe.stl", "b.stl"], "Größe.stl"), Some(7), "{name:?}");
        // A network share of a Mac decomposes the letters of the name.
        assert_eq!(copies_of(&bytes, &["Gro\u{308}ße.stl"], "Gro\u{308}ße.stl"), Some(7), "{name:?}");
    }
    let polish = b"plik;sztuk\r\nko\xb3o.stl;7\r\n";
    assert_eq!(copies_of(polish, &["koło.stl"], "koło.stl"), Some(7));
    let japanese = b"\x83t\x83@\x83C\x83\x8b,\x90\x94\x97\xca\r\n\x95\x94\x95i.stl,7\r\n";
    assert_eq!(copies_of(japanese, &["部品.stl"], "部品.stl"), Some(7));
    let header_only = b"Datei;St\x81ck\r\na.stl;7\r\n";
    assert_eq!(copies_of(header_only, &["a.stl"], "a.stl"), Some(7));
}

#[test]
fn rows_name_files_as_people_do() {
    let list = b"Name;Qty;\r\n.\\bracket.stl;2;\r\nlid;3;\r\nC:\\jobs\\7\\Ring.STL;4;\r\nhook.stl;5;\r\n";
    let files = ["bracket.stl", "lid.3mf", "ring.stl", "hook (2).stl"];
    let copies: Vec<_> = files.iter().map(|file| copies_of(list, &files, file)).collect();
    assert_eq!(copies, [Some(2), Some(3), Some(4), Some(5)]);
}

#[test]
fn titles_delimiters_and_missing_headers_are_understood() {
    for text in [
        "sep=;\nfile;copies\na.stl;3\n",
        "Order 1042;;\n\nfile;copies;due\na.stl;3;\n",
        "a.stl;3\nb.stl;4\n",
        "3,a.stl\n4,b.stl\n",
        "\"a.stl\"\t\"3\"\n",
        "file|copies\na.stl|3",
        "\tfile\tcopies\n\ta.stl\t3\n",
    ] {
        assert_eq!(row(&list(text), "a.stl").ticket.clone().unwrap().copies, Some(3), "{text:?}");
    }
}

#[test]
fn every_row_is_a_list_of_its_own() {
    for text in ["\tfile\tcopies\n\ta.stl\t3\n\tb.stl\t4\n", "a.stl;3\nb.stl;4\n", "x\nfile,copies\n\"a,\n.stl\",3\n"] {
        for row in list(text).rows().unwrap() {
            let alone = list(&row.text);
            assert_eq!(alone.rows().unwrap(), std::slice::from_ref(row), "{text:?}");
        }
    }
}

#[test]
fn further_columns_are_read_with_what_is_for_people() {
    let list = list(
        "Fichier;Quantité;Commande;Unité;Clearance (mm);Remarque;Client;Matière\na.stl;2;K-7;pouces;2,5;urgent;Brandt;PA12\n",
    );
    let ticket = row(&list, "a.stl").ticket.clone().unwrap();
    assert_eq!((ticket.copies, ticket.order.as_deref(), ticket.clearance_mm), (Some(2), Some("K-7"), Some(2.5)));
    assert_eq!(ticket.unit, Some(build_file::LengthUnit::Inch));
    assert_eq!(ticket.note.as_deref(), Some("urgent"));
    assert_eq!((ticket.customer.as_deref(), ticket.material.as_deref()), (Some("Brandt"), Some("PA12")));
}
