//! Texts with the name of a file and a number in each line, as people write them in an editor: `a.stl: 5`, `b.stl - 3 pcs`.

use std::ffi::OsStr;

use crate::{
    lists::list_cells::parse_whole_number,
    names::{copies_words::is_word_for_pieces, name::is_part_name, name_match::fold_name},
};

/// Signs between a file and its number.
const SIGNS: [char; 9] = [':', '=', '-', '–', '—', '→', '>', ',', ';'];

/// The same as a list with a header, if each line that is not empty names a file and its number of copies, and nothing else.
pub(in crate::lists) fn plain_rows(text: &str) -> Option<String> {
    let mut rows = "file;copies".to_owned();
    let before = rows.len();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (file, copies) = split_line(line)?;
        rows.push_str(&format!("\n{file};{copies}"));
    }
    (rows.len() > before).then_some(rows)
}

/// Splits a line behind the last name of a file that it may hold.
fn split_line(line: &str) -> Option<(&str, i64)> {
    let line = line.trim_start_matches(['*', '•', '-', '–']).trim_start();
    if line.contains([';', '"']) {
        return None;
    }
    let ends = line.char_indices().filter(|(_, c)| c.is_whitespace() || SIGNS.contains(c)).map(|(at, _)| at);
    let (file, rest) = ends.map(|at| line.split_at(at)).rfind(|(file, _)| is_part_name(OsStr::new(file)))?;
    // A table names several things in a line.
    (!file.contains([',', '\t', '|'])).then_some(())?;
    Some((file, parse_number(rest)?))
}

/// `5`, `x5`, `5x`, `5 pcs`
fn parse_number(text: &str) -> Option<i64> {
    let text = fold_name(text.trim_start_matches(|c: char| c.is_whitespace() || SIGNS.contains(&c)).trim_end());
    let text = text.strip_prefix(['x', '×']).map_or(text.as_str(), str::trim_start);
    let (digits, unit) = text.split_at(text.bytes().take_while(u8::is_ascii_digit).count());
    let unit = unit.trim().trim_end_matches('.');
    let is_unit = unit.is_empty() || matches!(unit, "x" | "×") || is_word_for_pieces(unit);
    parse_whole_number("", digits).ok().filter(|_| is_unit)
}
