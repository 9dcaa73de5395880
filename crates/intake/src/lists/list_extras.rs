//! Rows of an order list that order nothing: totals, the header again on a new page, comments, units below the header.

use std::ffi::OsStr;

use super::{
    list_cells::{bare_cell, normalize_word, parse_whole_number},
    list_columns::{ColumnLayout, ListColumn},
};
use crate::{Ticket, names::name::is_part_name};

/// Starts of words for a total. [`normalize_word`] is applied to them.
const TOTALS: &str =
    "summe total totale gesamt insgesamt zwischensumme subtotal soustotal grandtotal sum suma summa 合計 小計 総計";

/// Recognises the rows that order nothing, from the first to the last.
#[derive(Debug)]
pub(crate) struct ExtraRows {
    header: String,
    delimiter: char,
    /// Sum of the copies so far; `None` if a row has none.
    copies: Option<i64>,
}

impl ExtraRows {
    pub fn new(header: &str, delimiter: u8) -> Self {
        Self { header: header.to_owned(), delimiter: char::from(delimiter), copies: Some(0) }
    }

    /// Whether a row orders nothing. Otherwise its copies are added to the sum.
    pub fn is_extra_row(
        &mut self,
        columns: &ColumnLayout,
        record: &csv::StringRecord,
        text: &str,
        ticket: &Result<Ticket, String>,
    ) -> bool {
        let file = columns.cell_text(record, ListColumn::File);
        let cells = || record.iter().map(bare_cell).filter(|cell| !cell.is_empty());
        let is_comment = file.starts_with('#') && cells().count() == 1;
        let is_bracketed = |cell: &str| cell.starts_with(['[', '(']) && cell.ends_with([']', ')']);
        let is_below_header = file.is_empty() && cells().all(is_bracketed);
        let is_header = !self.header.is_empty() && self.bare_text(text) == self.bare_text(&self.header);
        if !is_part_name(OsStr::new(file))
            && (is_comment || is_below_header || is_header || self.is_total(columns, record, file))
        {
            return true;
        }
        let copies = ticket.as_ref().ok().and_then(|ticket| ticket.copies);
        self.copies = self.copies.zip(copies).map(|(sum, copies)| sum + i64::from(copies));
        false
    }

    /// A row without a file or with a word for a total in its place, whose number is the sum of the copies so far.
    fn is_total(&self, columns: &ColumnLayout, record: &csv::StringRecord, file: &str) -> bool {
        let is_total_of = |cell: &str, matches: fn(&str, &str) -> bool| {
            let word = normalize_word(cell);
            TOTALS.split_whitespace().any(|total| matches(&word, &normalize_word(total)))
        };
        let is_total_word = |cell: &str| is_total_of(cell, |word, total| word.starts_with(total));
        let has_word = match file {
            "" => record.iter().any(|cell| is_total_word(bare_cell(cell))),
            file => is_total_word(file),
        };
        let number = columns.cell_text(record, ListColumn::Copies);
        match (has_word, number) {
            // Without a number, the word must not begin the name of a file.
            (true, "") => file.is_empty() || is_total_of(file, |word, total| word == total),
            (false, _) if !file.is_empty() || number.is_empty() => false,
            (_, number) => match (parse_whole_number("", number), self.copies) {
                (Ok(number), Some(sum)) => number == sum && sum > 0,
                // The sum is not known, but the word says it.
                _ => has_word,
            },
        }
    }

    fn bare_text(&self, text: &str) -> String {
        text.trim_end_matches(['\r', '\n', ' ', self.delimiter]).to_lowercase()
    }
}
