//! Aligned text tables, and the functions that print to the terminal. States have the colours of their tones where somebody sees them; a
//! pipe receives the same text without.

use std::{
    fmt,
    io::{self, Write},
};

use anyhow::{Context, Result};
use build_file::{escape_invisible, escape_invisible_lines, is_invisible};

use super::terminal::{LinePaint, columns_of, fit_lines, letter_width, seen_width, show_marks, wrap_words};
use crate::tables::{CellValue, FieldDefinition, TableColumn, TimeView, people_columns};

/// A row that is shown as a list is not wrapped into fewer columns than this.
const LEAST_WRAPPED: usize = 40;
/// Widths to which long texts of a table are wrapped, the first that lets it fit.
const TEXT_WIDTHS: [usize; 3] = [40, 32, 24];

/// A text table. Numbers are aligned to the right.
#[derive(Debug, Clone)]
pub struct TextTable {
    headings: Vec<TableHead>,
    rows: Vec<Vec<TableCell>>,
    /// Longer texts of columns that are wrapped stand in several lines.
    text_width: usize,
}

/// A cell: its text, and how it is shown.
#[derive(Debug, Clone)]
struct TableCell {
    text: String,
    paint: LinePaint,
}

impl TableCell {
    /// The text with its paint.
    fn painted(&self) -> String {
        self.paint.mark(&self.text)
    }
}

/// The head of a column.
#[derive(Debug, Clone)]
struct TableHead {
    key: &'static str,
    text: String,
    is_right: bool,
    /// Whether its texts are wrapped before other columns are left out.
    is_wrapped: bool,
}

impl TableHead {
    fn of(key: &'static str, field: &FieldDefinition) -> Self {
        Self { key, text: field.terminal_heading(), is_right: field.is_number(), is_wrapped: false }
    }
}

impl TextTable {
    /// Creates a table of rows with the columns that people see, but for those of counts in which all is 0; `view` is how times are shown.
    pub fn of<Row>(columns: &[TableColumn<Row>], rows: &[Row], view: &TimeView) -> Self {
        let cell = |column: &TableColumn<Row>, row: &Row| {
            let value = (column.value)(row);
            let text = escape_invisible(&column.field.cell_text(&value, view).unwrap_or_else(|| "-".to_owned()));
            let paint = if let CellValue::State(word) = &value { LinePaint::of_state(word) } else { LinePaint::Plain };
            TableCell { text, paint }
        };
        let columns = people_columns(columns, rows);
        Self {
            headings: columns.iter().map(|column| TableHead::of(column.key, &column.field)).collect(),
            rows: rows.iter().map(|row| columns.iter().map(|column| cell(column, row)).collect()).collect(),
            text_width: usize::MAX,
        }
    }

    /// The table with columns of these keys whose long texts are wrapped before other columns are left out.
    pub fn wrapping(mut self, keys: &[&str]) -> Self {
        self.headings.iter_mut().for_each(|head| head.is_wrapped = keys.contains(&head.key));
        self
    }

    /// The table in at most `columns` terminal columns, if texts need not be narrower for that than they may be.
    fn fitted(&self, columns: usize) -> Option<Self> {
        let widths = std::iter::once(usize::MAX).chain(TEXT_WIDTHS);
        widths.map(|text_width| Self { text_width, ..self.clone() }).find(|table| table.fits_columns(columns))
    }

    /// Whether the table has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The table if it fits into `columns` terminal columns; otherwise each row as a list of its headings and cells.
    pub fn fit_columns(&self, columns: usize) -> String {
        if self.is_empty() || self.fits_columns(columns) {
            return self.to_string();
        }
        self.rows.iter().map(|row| self.row_as_list(row, columns)).collect()
    }

    /// The table in at most `columns` terminal columns: as many as needed of the columns with the keys `least` are left out, the first of
    /// them first, and a last line names those. If it is still too wide, each row is a list that leaves nothing out.
    pub fn fit_essentials(&self, columns: usize, least: &[&str]) -> String {
        let mut table = self.clone();
        let mut left_out: Vec<String> = Vec::new();
        for key in least {
            if table.is_empty() || table.fitted(columns).is_some() {
                break;
            }
            if let Some(at) = table.headings.iter().position(|head| head.key == *key) {
                left_out.push(table.headings.remove(at).text);
                table.rows.iter_mut().for_each(|row| drop(row.remove(at)));
            }
        }
        let Some(fitted) = table.fitted(columns) else { return self.fit_columns(columns) };
        let text = fitted.to_string();
        match left_out.is_empty() {
            true => text,
            false => text + &wrap_words(&format!("(--wide: {})", left_out.join(", ")), columns, 1) + "\n",
        }
    }

    fn fits_columns(&self, columns: usize) -> bool {
        self.to_string().lines().all(|line| seen_width(line) <= columns)
    }

    /// A row as "PART: 3  MACHINE: mjf". Each line contains as many pairs as fit; all lines but the first are
    /// indented.
    fn row_as_list(&self, row: &[TableCell], columns: usize) -> String {
        let mut lines: Vec<String> = Vec::new();
        for (head, cell) in self.headings.iter().zip(row) {
            let pair = format!("{}: {}", head.text, cell.painted());
            match lines.last_mut() {
                Some(line) if seen_width(line) + 2 + seen_width(&pair) <= columns => *line += &format!("  {pair}"),
                Some(_) => lines.push(format!("  {pair}")),
                None => lines.push(pair),
            }
        }
        lines.iter().map(|line| wrap_words(line, columns.max(LEAST_WRAPPED), 4) + "\n").collect()
    }

    fn column_width(&self, column: usize) -> usize {
        let head = seen_width(&self.headings[column].text);
        let lines = self.rows.iter().flat_map(|row| self.lines_of(column, &row[column]));
        lines.map(|line| seen_width(&line.text)).fold(head, usize::max)
    }

    /// The lines of a cell.
    fn lines_of(&self, column: usize, cell: &TableCell) -> Vec<TableCell> {
        let width = if self.headings[column].is_wrapped { self.text_width } else { usize::MAX };
        wrap_cell(&cell.text, width).into_iter().map(|text| TableCell { text, paint: cell.paint }).collect()
    }
}

/// A text in lines of at most `width` columns, broken at blanks where that is possible.
fn wrap_cell(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut filled = 0;
    for word in text.split_inclusive(' ') {
        if filled > 0 && filled + seen_width(word.trim_end()) > width {
            lines.push(String::new());
            filled = 0;
        }
        for letter in word.chars() {
            let columns = letter_width(letter);
            if letter != ' ' && filled + columns > width {
                lines.push(String::new());
                filled = 0;
            }
            filled += columns;
            lines.last_mut().into_iter().for_each(|line| line.push(letter));
        }
    }
    lines.iter().map(|line| line.trim_end().to_owned()).collect()
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: Vec<usize> = (0..self.headings.len()).map(|column| self.column_width(column)).collect();
        let head = |head: &TableHead| TableCell { text: head.text.clone(), paint: LinePaint::Plain };
        let heads: Vec<TableCell> = self.headings.iter().map(head).collect();
        for row in std::iter::once(&heads).chain(&self.rows) {
            let cells: Vec<Vec<TableCell>> =
                row.iter().enumerate().map(|(column, cell)| self.lines_of(column, cell)).collect();
            for line in 0..cells.iter().map(Vec::len).max().unwrap_or(0) {
                let cells = cells.iter().zip(&widths).zip(&self.headings).map(|((lines, &width), head)| {
                    let Some(cell) = lines.get(line) else { return " ".repeat(width) };
                    let blanks = " ".repeat(width.saturating_sub(seen_width(&cell.text)));
                    if head.is_right { blanks + &cell.painted() } else { cell.painted() + &blanks }
                });
                writeln!(f, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
            }
        }
        Ok(())
    }
}

/// Prints what people read to standard output: a terminal gets no line that is wider than it. A closed pipe (`| head`) is no error.
/// Control characters are escaped, so that text from customers cannot move the cursor of the operator's terminal.
pub fn print_text(text: &str) -> Result<()> {
    print_as_is(&fit_lines(text, columns_of(&io::stdout())))
}

/// Prints as [`print_text`], unless all columns were asked for, however wide the terminal is.
pub fn print_fitted(text: &str, is_wide: bool) -> Result<()> {
    if is_wide { print_as_is(text) } else { print_text(text) }
}

/// Prints what programs read, as it is.
pub fn print_as_is(text: &str) -> Result<()> {
    let text = show_marks(&escape_invisible_lines(text));
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| match text.ends_with('\n') {
        true => out.flush(),
        false => out.write_all(b"\n").and_then(|()| out.flush()),
    });
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.context("cannot print"),
    }
}

/// Prints a value as JSON.
pub fn print_json(value: &impl serde::Serialize) -> Result<()> {
    print_as_is(&escaped_json(&serde_json::to_string_pretty(value)?))
}

/// Prints a line to standard error, in the columns of a terminal there.
pub fn print_to_stderr(text: &str) {
    let text = format!("nestd: {}", escape_invisible_lines(text));
    eprintln!("{}", fit_lines(&text, columns_of(&io::stderr())));
}

/// Escapes invisible characters that JSON leaves as they are, such as bidirectional controls. They occur only inside
/// strings.
fn escaped_json(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '\n' => out.push(c),
            c if is_invisible(c) => {
                c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| out.push_str(&format!("\\u{unit:04x}")));
            }
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use settings::FarmZone;

    use crate::tables::fields;

    /// (name, waiting copies, next build, current activity)
    type Sample = (&'static str, u32, &'static str, &'static str);

    const COLUMNS: &[TableColumn<Sample>] = &[
        TableColumn::new("name", fields::NAME, |row| row.0.into()),
        TableColumn::new("copies", fields::COPIES, |row| row.1.into()),
        TableColumn::for_programs("hidden", fields::KIND, |row| row.0.into()),
        TableColumn::for_people("next", fields::NEXT_BUILD, |row| row.2.into()),
        TableColumn::new("now", fields::NOW, |row| row.3.into()),
    ];

    #[test]
    fn columns_are_as_wide_as_their_widest_cell_and_numbers_stand_to_the_right() {
        let table = TextTable::of(
            COLUMNS,
            &[("größe.stl", 3, "", "waiting"), ("a\u{1b}", 12, "", "")],
            &TimeView::kept(&FarmZone::default()),
        );
        let text = "NAME       COPIES  NEXT BUILD  NOW\ngröße.stl       3  -           waiting\na\\u{1b}        12  -           -\n";
        assert_eq!(table.to_string(), text);
    }

    #[test]
    fn a_table_that_is_too_wide_is_shown_without_its_least_columns_and_names_them() {
        let rows = [("mjf", 3, "55.61 mm, 11 copies", "collecting"), ("sls", 0, "", "idle")];
        let table = TextTable::of(COLUMNS, &rows, &TimeView::kept(&FarmZone::default()));
        assert_eq!(table.fit_essentials(usize::MAX, &["next"]), table.to_string());
        let essential = "NAME  COPIES  NOW\nmjf        3  collecting\nsls        0  idle\n(--wide: NEXT BUILD)\n";
        assert_eq!(table.fit_essentials(30, &["unknown", "next", "copies"]), essential);
        assert!(table.fit_essentials(6, &["next"]).contains("NAME: mjf"), "however narrow it is");
    }

    #[test]
    fn long_texts_are_wrapped_before_a_column_is_left_out_and_wide_letters_take_two_columns() {
        let name = "Sonderauftrag Getriebegehaeuse";
        let rows = [(name, 3, "", "waiting"), ("試作品", 12, "", "-")];
        let table = TextTable::of(COLUMNS, &rows, &TimeView::kept(&FarmZone::default())).wrapping(&["name"]);
        let lines = [
            "NAME              COPIES  NEXT BUILD  NOW",
            "Sonderauftrag          3  -           waiting",
            "Getriebegehaeuse",
            "試作品                12  -           -",
        ];
        let shown = table.fit_essentials(50, &["next"]);
        assert_eq!(shown.lines().collect::<Vec<_>>(), lines);
        assert_eq!(wrap_cell("a-word-without-a-blank and more", 10), ["a-word-wit", "hout-a-bla", "nk and", "more"]);
    }

    #[test]
    fn a_table_that_is_too_wide_is_a_list_that_leaves_nothing_out() {
        let rows = [("mjf", 3, "55.61 mm, 11 copies", "collecting"), ("sls", 0, "", "idle")];
        let table = TextTable::of(COLUMNS, &rows, &TimeView::kept(&FarmZone::default()));
        let width = table.to_string().lines().map(|line| line.chars().count()).max().unwrap();
        assert_eq!(table.fit_columns(width), table.to_string());
        let list = "NAME: mjf  COPIES: 3\n  NEXT BUILD: 55.61 mm, 11 copies\n  NOW: collecting\n\
                    NAME: sls  COPIES: 0  NEXT BUILD: -\n  NOW: idle\n";
        assert_eq!(table.fit_columns(36), list);
        assert_eq!(table.fit_columns(12).matches(": ").count(), 8, "however narrow it is");
    }
}
