//! Workbooks as order lists.

use std::{ffi::OsStr, io::Write};

use zip::{ZipWriter, write::SimpleFileOptions};

use crate::OrderList;

/// The bytes of a package of these entries.
fn package(entries: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Of a sheet its state, its rows, and the merged ranges.
type Sheet<'s> = (&'s str, &'s str, &'s [&'s str]);

/// A workbook: of each sheet its state, its rows, and the merged ranges.
fn workbook(sheets: &[Sheet<'_>]) -> Vec<u8> {
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
    let numbered = |line: &dyn Fn(usize, &Sheet<'_>) -> String| -> String {
        sheets.iter().enumerate().map(|(at, sheet)| line(at + 1, sheet)).collect()
    };
    let listed = numbered(&|at, (state, ..)| {
        format!(r#"<sheet name="Sheet{at}" sheetId="{at}" state="{state}" r:id="r{at}"/>"#)
    });
    let related = numbered(&|at, _| {
        format!(r#"<Relationship Id="r{at}" Type="{OFFICE}/worksheet" Target="worksheets/sheet{at}.xml"/>"#)
    });
    let styles = format!(
        r#"<styleSheet xmlns="{MAIN}"><cellXfs count="2"><xf numFmtId="0"/><xf numFmtId="14" applyNumberFormat="1"/></cellXfs></styleSheet>"#
    )
    .replace("<cellXfs count=\"2\">", "<fonts><font/><font><b/><strike/></font></fonts><cellXfs count=\"3\">")
    .replace("</cellXfs>", "<xf numFmtId=\"0\" fontId=\"1\"/></cellXfs>");
    let mut entries = vec![
        (
            "_rels/.rels".to_owned(),
            format!(
                r#"<Relationships xmlns="{PACKAGE}"><Relationship Id="w" Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>"#
            ),
        ),
        (
            "xl/workbook.xml".to_owned(),
            format!(r#"<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets>{listed}</sheets></workbook>"#),
        ),
        (
            "xl/_rels/workbook.xml.rels".to_owned(),
            format!(
                r#"<Relationships xmlns="{PACKAGE}">{related}<Relationship Id="s" Type="{OFFICE}/styles" Target="styles.xml"/></Relationships>"#
            ),
        ),
        ("xl/styles.xml".to_owned(), styles),
    ];
    for (at, (_, rows, merged)) in sheets.iter().enumerate() {
        let merged: String = merged.iter().map(|range| format!(r#"<mergeCell ref="{range}"/>"#)).collect();
        let merged = if merged.is_empty() { merged } else { format!("<mergeCells>{merged}</mergeCells>") };
        let text = format!(r#"<worksheet xmlns="{MAIN}"><sheetData>{rows}</sheetData>{merged}</worksheet>"#);
        entries.push((format!("xl/worksheets/sheet{}.xml", at + 1), text));
    }
    package(&entries.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect::<Vec<_>>())
}

/// A row of cells: a text, a number, `@` and a number that is shown as a date, or nothing.
fn row(number: u32, cells: &[&str]) -> String {
    let cell = |(at, text): (usize, &&str)| {
        let place = format!("{}{number}", char::from(b'A' + at as u8));
        match (text.strip_prefix('@'), text.parse::<f64>()) {
            _ if text.is_empty() => String::new(),
            (Some(date), _) => format!(r#"<c r="{place}" s="1"><v>{date}</v></c>"#),
            (None, Ok(value)) => format!(r#"<c r="{place}"><v>{value}</v></c>"#),
            _ => format!(r#"<c r="{place}" t="inlineStr"><is><t>{text}</t></is></c>"#),
        }
    };
    format!(r#"<row r="{number}">{}</row>"#, cells.iter().enumerate().map(cell).collect::<String>())
}

/// Of each row its file, and copies, order and due date or what is wrong.
fn read(bytes: &[u8]) -> Result<Vec<(String, String)>, String> {
    let list = OrderList::parse_list(bytes);
    let rows = list.rows().map_err(str::to_owned)?;
    let said = |ticket: &crate::Ticket| {
        let due = ticket.due.as_ref().map(ToString::to_string).unwrap_or_default();
        format!("{:?} {} {due}", ticket.copies.unwrap_or(0), ticket.order.as_deref().unwrap_or("-"))
    };
    let told = |row: &crate::OrderListRow| row.ticket.as_ref().map_or_else(|why| format!("no: {why}"), said);
    Ok(rows.iter().map(|row| (row.file.clone(), told(row))).collect())
}

#[test]
fn a_sheet_that_can_be_seen_and_has_the_columns_is_the_list() {
    let cover = row(1, &["Angebot 4711"]) + &row(2, &["gültig bis", "@46000"]);
    let list = row(1, &["Bestellung Müller & Söhne".replace('&', "&amp;").as_str()])
        + &row(3, &["", "Datei", "Stückzahl", "Termin", "Auftrag"])
        + &row(4, &["", "ring.stl", "12", "@46022", "4711"])
        + &row(7, &["", "Deckel; groß.stl", "3", "@46022.5", "A-1"]);
    let hidden = row(1, &["file", "copies"]) + &row(2, &["ring.stl", "99"]);
    let bytes = workbook(&[("hidden", &hidden, &[]), ("visible", &cover, &[]), ("visible", &list, &["A1:E1"])]);
    let wanted = [("ring.stl", "12 4711 2025-12-31"), ("Deckel; groß.stl", "3 A-1 2025-12-31 12:00")];
    assert_eq!(read(&bytes).unwrap(), wanted.map(|(file, said)| (file.to_owned(), said.to_owned())));
    let list = OrderList::parse_list(&bytes);
    let row = list.row_for_file(OsStr::new("ring.stl")).unwrap().unwrap();
    assert_eq!(OrderList::parse_single_row(&row.text).unwrap().ticket, row.ticket, "a row stands by itself");
}

#[test]
fn the_rows_of_all_sheets_that_can_be_seen_count_and_two_that_differ_are_asked_about() {
    let first = row(1, &["file", "copies"]) + &row(2, &["a.stl", "5"]) + &row(3, &["b.stl", "2"]);
    let second = row(1, &["Datei", "Stückzahl", "Auftrag"])
        + &row(2, &["A.stl", "7"])
        + &row(3, &["b.stl", "2"])
        + &row(4, &["c.stl", "4", "K-1"])
        + &row(5, &["PA12 powder", "20"]);
    let bytes = workbook(&[("visible", &first, &[]), ("visible", &second, &[])]);
    let list = OrderList::parse_list(&bytes);
    let said = |name: &str| {
        list.row_for_file(OsStr::new(name)).map(|row| row.and_then(|row| row.ticket.clone().unwrap().copies))
    };
    assert!(said("a.stl").is_err_and(|why| why.contains("2 rows are for a.stl; where all are wanted, add them up")));
    assert_eq!((said("b.stl"), said("c.stl")), (Ok(Some(2)), Ok(Some(4))));
    assert_eq!(list.rows().unwrap().len(), 4, "a row that says the same, or names no file, is left out");
    let row = list.row_for_file(OsStr::new("c.stl")).unwrap().unwrap();
    assert_eq!(OrderList::parse_single_row(&row.text).unwrap().ticket, row.ticket, "a row stands by itself");
}

#[test]
fn a_number_in_merged_cells_is_no_number_of_copies_and_a_text_counts_for_all_its_rows() {
    let rows = row(1, &["file", "copies", "order"])
        + &row(2, &["a.stl", "8", "K-1"])
        + &row(3, &["b.stl"])
        + &row(4, &["c.stl", "2", "K-2"]);
    let read = read(&workbook(&[("visible", &rows, &["B2:B3", "C2:C3"])])).unwrap();
    assert_eq!(read[0].1, "8 K-1 ");
    assert!(read[1].1.starts_with("no: ") && read[1].1.contains("merged with the cell above"), "{read:?}");
    assert_eq!(read[2].1, "2 K-2 ");
    let texts = super::sheet_texts(&workbook(&[("visible", &rows, &["C2:C3"])])).unwrap();
    assert_eq!(texts, ["file;copies;order\na.stl;8;K-1\nb.stl;;K-1\nc.stl;2;K-2\n"]);
}

#[test]
fn a_formula_counts_with_its_value_and_without_one_is_no_number_of_copies() {
    let rows = row(1, &["file", "copies"])
        + r#"<row r="2"><c r="A2" t="str"><f>"a"&amp;".stl"</f><v>a.stl</v></c><c r="B2"><f>2+3</f><v>5</v></c></row>"#
        + r#"<row r="3"><c r="A3" t="inlineStr"><is><t>b.stl</t></is></c><c r="B3"><f>2+3</f><v></v></c></row>"#
        + r#"<row r="4"><c r="A4" t="inlineStr"><is><t>c.stl</t></is></c><c r="B4" t="e"><f>1/0</f><v>#DIV/0!</v></c></row>"#;
    let read = read(&workbook(&[("visible", &rows, &[])])).unwrap();
    assert_eq!(read[0], ("a.stl".to_owned(), "5 - ".to_owned()));
    assert!(read[1].1.contains("a formula without a value") && read[2].1.contains("#DIV/0!"), "{read:?}");
}

#[test]
fn a_row_that_is_hidden_or_struck_through_says_so_against_itself() {
    let struck = row(4, &["c.stl", "4"]).replace(r#"<c r="A4""#, r#"<c r="A4" s="2""#);
    let half = r#"<row r="5"><c r="A5" t="inlineStr"><is><t>d.stl</t></is></c><c r="B5" t="inlineStr"><is><r><rPr><strike/></rPr><t>5</t></r><r><t>3</t></r></is></c></row>"#;
    let rows = row(1, &["file", "copies"])
        + &row(2, &["a.stl", "2"])
        + &row(3, &["b.stl", "3"]).replace("<row ", r#"<row hidden="1" "#)
        + &struck
        + half
        + &row(6, &["e.stl", "6"]).replace("<row ", r#"<row hidden="0" "#);
    let list = OrderList::parse_list(&workbook(&[("visible", &rows, &[])]));
    let said: Vec<_> = list.rows().unwrap().iter().map(|row| (row.file.as_str(), row.objection.as_deref())).collect();
    let wanted = [
        ("a.stl", None),
        ("b.stl", Some("hidden row")),
        ("c.stl", Some("struck through")),
        ("d.stl", Some("struck through")),
        ("e.stl", None),
    ];
    assert_eq!(said, wanted);
    let single = OrderList::parse_single_row(&list.rows().unwrap()[1].text).unwrap();
    assert_eq!(single.objection.as_deref(), Some("hidden row"), "the row by itself says so too");
}

#[test]
fn a_workbook_that_cannot_be_read_says_why() {
    let empty = workbook(&[("visible", "", &[])]);
    let no_columns = workbook(&[("visible", &row(1, &["Hello", "World"]), &[])]);
    let wide: String = (0..40).map(|n| format!(r#"<row r="{0}"><c r="XFD{0}"><v>1</v></c></row>"#, n + 1)).collect();
    let zeros = "0".repeat(65 << 20);
    for (bytes, why) in [
        (b"PK\x03\x04 no package".to_vec(), "as a package it is damaged"),
        (package(&[("a.txt", "a")]), "as a workbook it is damaged"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1 0000".to_vec(), "a password"),
        (empty, "its sheets are empty"),
        (no_columns, "column"),
        (workbook(&[("visible", &wide, &[])]), "too large for a list"),
        (package(&[("xl/workbook.xml", &zeros)]), "unpacks to more than"),
    ] {
        let said = read(&bytes).unwrap_err();
        assert!(said.contains(why), "{why}: {said}");
    }
}
