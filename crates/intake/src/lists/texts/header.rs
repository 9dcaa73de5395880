//! Finds the header of an order list, and splits its text into records.

use std::ffi::OsStr;

use crate::{
    lists::{
        list_cells::parse_whole_number,
        list_columns::{ColumnLayout, NO_HEADER},
    },
    names::name::is_part_name,
};

/// The header must be among this many first lines, because people write a title above it.
const HEADER_WITHIN: usize = 10;

/// The header that was found.
pub(in crate::lists) struct ListHeader<'a> {
    pub columns: ColumnLayout,
    pub text: &'a str,
    /// The lines above it.
    pub above: &'a str,
    /// Offset of the first row.
    pub end: usize,
}

/// Removes a first line such as `sep=;`, which tells Excel the delimiter.
pub(in crate::lists) fn strip_sep_line(text: &str) -> (&str, Option<u8>) {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    match first.trim_end_matches('\r').as_bytes() {
        [b's' | b'S', b'e' | b'E', b'p' | b'P', b'=', delimiter] => (rest, Some(*delimiter)),
        _ => (text, None),
    }
}

/// Calls `each` with every record that is not empty and with its text, until `each` returns `false`.
pub(in crate::lists) fn for_each_record(
    text: &str,
    delimiter: u8,
    mut each: impl FnMut(&csv::StringRecord, &str) -> bool,
) -> Result<usize, String> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .flexible(true)
        .has_headers(false)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut record = csv::StringRecord::new();
    loop {
        let from = reader.position().byte() as usize;
        if !reader.read_record(&mut record).map_err(|e| e.to_string())? {
            return Ok(text.len());
        }
        let end = reader.position().byte() as usize;
        let row = text[from..end].trim_matches(['\r', '\n']);
        if record.iter().any(|cell| !cell.is_empty()) && !each(&record, row) {
            return Ok(end);
        }
    }
}

/// Finds the header. Where two lines one below the other are headers, the one that says more is taken.
pub(in crate::lists) fn find_header(text: &str, delimiter: u8) -> Result<ListHeader<'_>, String> {
    let mut found: Result<ListHeader, String> = Err(NO_HEADER.to_owned());
    let mut lines = 0;
    for_each_record(text, delimiter, |record, row| {
        lines += 1;
        let columns = ColumnLayout::from_header(record.iter());
        let is_header = match &columns {
            // A title line may contain one header word. A header has at least two, or only one column.
            Ok(columns) => columns.known_count() > 1 || record.len() == 1,
            Err(why) => why != NO_HEADER,
        };
        let is_first = found.as_ref().is_err_and(|why| why == NO_HEADER);
        let says_more = |columns: &ColumnLayout| {
            found.as_ref().is_ok_and(|above| columns.known_count() >= above.columns.known_count())
        };
        if is_header && (is_first || columns.as_ref().is_ok_and(says_more)) {
            let from = row.as_ptr() as usize - text.as_ptr() as usize;
            let end = from + row.len();
            found = columns.map(|columns| ListHeader { columns, text: &text[from..end], above: &text[..from], end });
        }
        is_first && lines < HEADER_WITHIN + usize::from(is_header)
    })?;
    found
}

/// Recognises a list of two columns without a header, where it is clear which column holds files and which holds
/// copies.
pub(in crate::lists) fn infer_columns(text: &str, delimiter: u8) -> Option<ListHeader<'_>> {
    let mut file_at = None;
    let mut is_clear = true;
    for_each_record(text, delimiter, |record, _| {
        let is_file = |at: usize| record.get(at).is_some_and(|cell| is_part_name(OsStr::new(cell)));
        let is_count = |at: usize| record.get(at).is_some_and(|cell| parse_whole_number("", cell).is_ok());
        let here = (0..2).find(|&at| is_file(at) && is_count(1 - at) && !is_file(1 - at));
        let has_more = record.iter().skip(2).any(|cell| !cell.is_empty());
        is_clear = here.is_some() && !has_more && file_at.is_none_or(|at| Some(at) == here);
        file_at = here;
        is_clear
    })
    .ok()?;
    let file = file_at.filter(|_| is_clear)?;
    Some(ListHeader { columns: ColumnLayout::without_header(file, 1 - file), text: "", above: "", end: 0 })
}
