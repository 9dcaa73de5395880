//! Workbooks as order lists: the text of each sheet that can be seen, as if it had been saved as CSV. What a cell shows is read: a date as
//! a date, a number as a number. A row that is hidden or struck through is asked about ([`marks`]). Where cells are merged downwards, a text counts for all rows; a number does not, since it may be meant
//! for all of them together.

use std::{
    collections::BTreeMap,
    io::{Cursor, Read},
};

use build_file::escape_invisible;
use calamine::{
    DataRef, Dimensions, ExcelDateTime, Reader, SheetType, SheetVisible, Xlsx, XlsxError, open_workbook_from_rs,
};
use zip::ZipArchive;

use self::marks::row_marks;

mod marks;

/// How a workbook begins, as every package.
const PACKAGE: &[u8] = b"PK\x03\x04";
/// How old workbooks begin, and those with a password.
const CONTAINER: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";
/// A workbook that unpacks to more is not read, bytes.
const MAX_UNPACKED_BYTES: u64 = 64 << 20;
/// A workbook with more entries is not read.
const MAX_ENTRIES: usize = 2000;
/// A sheet with more text is not read, bytes.
const MAX_TEXT_BYTES: usize = 16 << 20;
/// A sheet with text in more columns is not read.
const MAX_COLUMNS: u32 = 256;
/// What stands for a number that is in the cell above, merged with this one. No number of copies is read from it.
const MERGED_NUMBER: &str = "merged with the cell above";

/// What stands for a formula that no program has worked out. No number of copies is read from it.
const WITHOUT_VALUE: &str = "a formula without a value";

/// Whether the bytes are those of a workbook.
pub(super) fn is_workbook(bytes: &[u8]) -> bool {
    bytes.starts_with(PACKAGE) || bytes.starts_with(CONTAINER)
}

/// The texts of all visible sheets that are not empty, in their order.
///
/// # Errors
/// It cannot be read: why, as a part of a sentence.
pub(super) fn sheet_texts(bytes: &[u8]) -> Result<Vec<String>, String> {
    if bytes.starts_with(CONTAINER) {
        return Err("it has a password, or is of an old kind; save it without a password as XLSX, or as CSV".to_owned());
    }
    check_unpacked(bytes)?;
    let broken = |error: XlsxError| format!("as a workbook it is damaged: {}", escape_invisible(&error.to_string()));
    let mut workbook: Xlsx<_> = open_workbook_from_rs(Cursor::new(bytes)).map_err(broken)?;
    let is_seen =
        |sheet: &&calamine::Sheet| sheet.typ == SheetType::WorkSheet && sheet.visible == SheetVisible::Visible;
    let names: Vec<String> =
        workbook.sheets_metadata().iter().filter(is_seen).map(|sheet| sheet.name.clone()).collect();
    let (mut texts, marks) = (Vec::new(), row_marks(bytes));
    for name in names {
        let mut rows = sheet_rows(&mut workbook, &name).map_err(|error| match error {
            SheetError::TooLarge => format!("its sheet {} is too large for a list", escape_invisible(&name)),
            SheetError::Workbook(error) => broken(error),
        })?;
        // A cell behind all others says what the look of a row says.
        let behind = rows.cells.values().flat_map(BTreeMap::keys).max().map_or(0, |last| last + 1);
        for (row, mark) in marks.get(&name).into_iter().flatten() {
            rows.cells.entry(*row).and_modify(|cells| _ = cells.insert(behind, mark.word().to_owned()));
        }
        texts.extend((!rows.cells.is_empty()).then(|| as_csv(&rows.cells)));
    }
    Ok(texts)
}

/// Why a sheet cannot be read.
#[derive(Debug)]
enum SheetError {
    Workbook(XlsxError),
    TooLarge,
}

impl From<XlsxError> for SheetError {
    fn from(error: XlsxError) -> Self {
        Self::Workbook(error)
    }
}

/// What the cells of a sheet show, by row and column; no empty ones.
#[derive(Debug, Default)]
struct SheetRows {
    cells: BTreeMap<u32, BTreeMap<u32, String>>,
    text_bytes: usize,
}

impl SheetRows {
    fn put(&mut self, (row, column): (u32, u32), text: &str) -> Result<(), SheetError> {
        self.text_bytes += text.len() + 1;
        if self.text_bytes > MAX_TEXT_BYTES || column >= MAX_COLUMNS {
            return Err(SheetError::TooLarge);
        }
        self.cells.entry(row).or_default().insert(column, text.to_owned());
        Ok(())
    }
}

fn sheet_rows(workbook: &mut Xlsx<Cursor<&[u8]>>, name: &str) -> Result<SheetRows, SheetError> {
    let merged: Vec<Dimensions> = workbook.merge_cells_by_sheet_name(name)?;
    let mut rows = SheetRows::default();
    let mut formulas = workbook.worksheet_cells_reader(name)?;
    while let Some(formula) = formulas.next_formula()? {
        if !formula.get_value().is_empty() {
            rows.put(formula.get_position(), WITHOUT_VALUE)?;
        }
    }
    drop(formulas);
    let mut cells = workbook.worksheet_cells_reader(name)?;
    while let Some(cell) = cells.next_cell()? {
        let (at, text) = (cell.get_position(), cell_text(cell.get_value()));
        if text.trim().is_empty() {
            continue;
        }
        rows.put(at, &text)?;
        let is_number = matches!(cell.get_value(), DataRef::Int(_) | DataRef::Float(_));
        let below = merged.iter().filter(|region| region.start == at).flat_map(|region| at.0 + 1..=region.end.0);
        for row in below {
            rows.put((row, at.1), if is_number { MERGED_NUMBER } else { &text })?;
        }
    }
    Ok(rows)
}

/// Refuses what unpacks to more than a list needs. The sizes that its directory claims are not believed.
fn check_unpacked(bytes: &[u8]) -> Result<(), String> {
    let damaged =
        |error: &dyn std::error::Error| format!("as a package it is damaged: {}", escape_invisible(&error.to_string()));
    let mut package = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let too_large = || format!("it unpacks to more than {MAX_UNPACKED_BYTES} bytes");
    if package.len() > MAX_ENTRIES {
        return Err(too_large());
    }
    let mut left = MAX_UNPACKED_BYTES;
    for at in 0..package.len() {
        let entry = package.by_index(at).map_err(|error| damaged(&error))?;
        let unpacked =
            std::io::copy(&mut entry.take(left + 1), &mut std::io::sink()).map_err(|error| damaged(&error))?;
        left = left.checked_sub(unpacked).ok_or_else(too_large)?;
    }
    Ok(())
}

/// What a cell shows.
fn cell_text(value: &DataRef<'_>) -> String {
    match value {
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => text.clone(),
        DataRef::SharedString(text) => (*text).to_owned(),
        DataRef::Bool(is_true) => if *is_true { "yes" } else { "no" }.to_owned(),
        DataRef::DateTime(time) => time_text(time),
        DataRef::Error(error) => error.to_string(),
        DataRef::Empty => String::new(),
    }
}

/// A day, with the time if it has one; a time alone.
fn time_text(time: &ExcelDateTime) -> String {
    let (year, month, day, hour, minute, ..) = time.to_ymd_hms_milli();
    let clock = format!("{hour:02}:{minute:02}");
    match (time.is_duration() || time.as_f64() < 1.0, clock.as_str()) {
        (true, _) => clock,
        (false, "00:00") => format!("{year:04}-{month:02}-{day:02}"),
        (false, _) => format!("{year:04}-{month:02}-{day:02} {clock}"),
    }
}

/// The rows as CSV, each with the same number of cells.
fn as_csv(rows: &BTreeMap<u32, BTreeMap<u32, String>>) -> String {
    let columns = || rows.values().flat_map(BTreeMap::keys);
    let (first, last) = (columns().min().copied().unwrap_or(0), columns().max().copied().unwrap_or(0));
    let mut csv = csv::WriterBuilder::new().delimiter(b';').from_writer(Vec::new());
    for row in rows.values() {
        // Memory does not fail to be written to.
        let _ = csv.write_record((first..=last).map(|column| row.get(&column).map_or("", String::as_str)));
    }
    String::from_utf8(csv.into_inner().unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
#[path = "tests/workbook_tests.rs"]
mod workbook_tests;
