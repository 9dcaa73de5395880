//! What comes out of a printer: the pick map of 527 copies with names of 60 letters, the labels, and the history, printed by a real Chromium and
//! read back with `pdftotext`. Needs `NESTD_BROWSER=<chromium>` and poppler-utils.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use ledger::PartState;

use crate::{
    pages::{BrowserDashboard, MACHINE, browser},
    support::stl,
};

/// A machine with room for all copies in few layers; the search need not be good.
const PROFILE: &str = "volume_mm = [380, 284, 380]\nclearance_mm = 3.0\nlayer_mm = 0.08\nsettle_secs = 0.3\nunfinished_secs = 2\n\
                       final_secs = 1\narrival_secs = 0\n";
/// Kinds of parts, and copies of each.
const PARTS: (usize, usize) = (31, 17);
/// Letters of the name of a part and of its order.
const LETTERS: usize = 60;
/// Copies on a sheet.
const COPIES_PER_SHEET: usize = 22;
/// Most sheets of all copies.
const MOST_SHEETS: usize = 24;
/// White rim of a sheet in which nothing is printed, points.
const RIM_POINTS: f64 = 20.0;

/// A text of [`LETTERS`] letters without a blank that ends so.
fn long_text(first: char, end: &str) -> String {
    let letters = (0u8..).map(|n| char::from(b'a' + n % 26));
    std::iter::once(first).chain(letters).take(LETTERS - end.len()).chain(end.chars()).collect()
}

/// Why this test cannot run here.
pub fn missing() -> Option<String> {
    let is_there = Command::new("pdftotext").arg("-v").output().is_ok();
    (!is_there).then(|| "pdftotext is not installed (apt-get install poppler-utils)".to_owned())
}

/// Prints a page to PDF.
fn print_page(dashboard: &BrowserDashboard, path: &str, name: &str) -> PathBuf {
    let pdf = dashboard.farm.root().join(name);
    let print = Command::new(browser())
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"])
        .arg(format!("--user-data-dir={}", dashboard.farm.root().join("chromium").display()))
        .arg(format!("--print-to-pdf={}", pdf.display()))
        .arg(format!("{}{path}", dashboard.base))
        .output()
        .unwrap();
    assert!(pdf.is_file(), "{}", String::from_utf8_lossy(&print.stderr));
    pdf
}

/// The text of each page of a PDF.
fn pages_of_pdf(pdf: &Path, option: &str) -> Vec<String> {
    let read = Command::new("pdftotext").args([option, "-enc", "UTF-8"]).arg(pdf).arg("-").output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let text = String::from_utf8(read.stdout).unwrap();
    let end = if option == "-bbox" { "</page>" } else { "\u{c}" };
    text.split(end).map(ToOwned::to_owned).filter(|page| !page.trim().is_empty()).collect()
}

/// Without any blank: where a line is broken does not matter.
fn squeeze(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace()).collect()
}

/// Fails if a word of a PDF reaches into the rim of its sheet.
fn assert_nothing_is_cut(pdf: &Path) {
    let number = |text: &str, name: &str| -> Option<f64> {
        text.split(&format!("{name}=\"")).nth(1)?.split('"').next()?.parse().ok()
    };
    let mut words = 0;
    for page in pages_of_pdf(pdf, "-bbox").iter().filter(|page| page.contains("<page ")) {
        let sheet = page.split("<page ").nth(1).unwrap();
        let (width, height) = (number(sheet, "width").unwrap(), number(sheet, "height").unwrap());
        for word in page.split("<word ").skip(1) {
            let [x0, x1, y0, y1] = ["xMin", "xMax", "yMin", "yMax"].map(|name| number(word, name).unwrap());
            let is_inside = x0 > RIM_POINTS && x1 < width - RIM_POINTS && y0 > RIM_POINTS && y1 < height - RIM_POINTS;
            assert!(is_inside, "{} is at the edge of its sheet", word.lines().next().unwrap());
            words += 1;
        }
    }
    assert!(words > 10, "{words} words");
}

/// The texts of the cells of each row of the table that is called so, as the page has them.
fn rows_of_page(html: &str, is_table: impl Fn(&str) -> bool) -> Vec<Vec<String>> {
    let cells =
        |row: &str| row.split("<td").skip(1).map(|cell| cell_text(cell.split("</td>").next().unwrap())).collect();
    let tables = html.split("<table").filter(|table| is_table(table));
    tables
        .flat_map(|table| table.split("<tr>").filter(|row| row.contains("<td")).map(cells).collect::<Vec<_>>())
        .collect()
}

/// The text of a cell, whose tag is not closed yet.
fn cell_text(cell: &str) -> String {
    let mut text = String::new();
    for piece in cell.split('>').skip(1) {
        text += piece.split('<').next().unwrap();
    }
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

fn page_html(dashboard: &BrowserDashboard, path: &str) -> String {
    ureq::get(format!("{}{path}", dashboard.base)).call().unwrap().body_mut().read_to_string().unwrap()
}

/// Fails unless each row stands in the text, its cells one after the other.
fn assert_rows_are_printed(printed: &str, rows: &[Vec<String>]) {
    let printed = squeeze(printed);
    for row in rows {
        let text = squeeze(&row.concat());
        assert!(printed.contains(&text), "this row is not whole on paper: {row:?}");
    }
}

/// Fails unless the labels of build 1 are whole on each kind of sheet, with a page for as many as it has.
fn labels_are_whole(dashboard: &BrowserDashboard, names: &[String], order: &str) {
    for (sheet, per_page) in [("a4-70x37", 24), ("a4-99x38", 14), ("letter-5160", 30), ("roll-62", 1)] {
        let address = format!("{}/builds/1/labels.pdf?of=bags&sheet={sheet}", dashboard.base);
        let pdf = dashboard.farm.root().join(format!("{sheet}.pdf"));
        std::fs::write(&pdf, ureq::get(address).call().unwrap().body_mut().read_to_vec().unwrap()).unwrap();
        let pages = pages_of_pdf(&pdf, "-raw");
        assert_eq!(pages.len(), names.len().div_ceil(per_page), "{sheet}");
        let row = |name: &String| vec![order.to_owned(), name.clone(), format!("{} copies of build 1", PARTS.1)];
        assert_rows_are_printed(&pages.concat(), &names.iter().map(row).collect::<Vec<_>>());
    }
}

pub fn pick_map_and_history_lose_nothing_on_paper() {
    let dashboard = BrowserDashboard::start();
    dashboard.farm.write_profile(MACHINE, PROFILE);
    dashboard.farm.reload();
    let order = long_text('O', "order");
    let (kinds, each) = PARTS;
    let names: Vec<String> = (0..kinds).map(|n| long_text('P', &format!("{n:02}.stl"))).collect();
    let row = |name: &String| format!("{name};{each};2026-12-24;handle with care, do not blast\n");
    let list = "file;copies;due;note\n".to_owned() + &names.iter().map(row).collect::<String>();
    dashboard.drop(&order, "order.csv", list.as_bytes());
    for (n, name) in names.iter().enumerate() {
        let size = glam::DVec3::new(9.0 + (n % 5) as f64, 8.0 + (n % 7) as f64, 7.0 + (n % 3) as f64);
        dashboard.drop(&order, name, &stl(&sample_parts::cuboid(size)));
    }
    dashboard.wait_for(PartState::Waiting, kinds);
    dashboard.flush();
    let rows = rows_of_page(&page_html(&dashboard, "/builds/1/pick"), |_| true);
    assert_eq!(rows.len(), kinds * each, "a row for each copy");
    assert!(rows.iter().all(|row| row.len() == 12 && row.contains(&order)), "{:?}", rows[0]);
    let pdf = print_page(&dashboard, "/builds/1/pick", "pick.pdf");
    assert_nothing_is_cut(&pdf);
    let sheets = pages_of_pdf(&pdf, "-raw");
    assert_eq!(sheets.len(), rows.len().div_ceil(COPIES_PER_SHEET), "a page for {COPIES_PER_SHEET} copies");
    assert!(sheets.len() <= MOST_SHEETS, "{} sheets", sheets.len());
    for (sheet, rows) in sheets.iter().zip(rows.chunks(COPIES_PER_SHEET)) {
        assert_rows_are_printed(sheet, rows);
    }
    labels_are_whole(&dashboard, &names, &order);
    let history = page_html(&dashboard, "/history");
    let rows = rows_of_page(&history, |table| table.contains("Used, %"));
    assert_eq!(rows.len(), 1, "{history}");
    let pdf = print_page(&dashboard, "/history", "history.pdf");
    assert_nothing_is_cut(&pdf);
    assert_rows_are_printed(&pages_of_pdf(&pdf, "-raw").concat(), &rows);
}
