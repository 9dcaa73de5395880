//! Plain aligned tables and the one door to the terminal. No colours, so that a pipe gets what a person sees.

use std::{
    fmt,
    io::{self, Write},
};

use anyhow::{Context, Result};
use build_file::{counted, is_invisible, visible, visible_lines};

/// A table; the columns of a heading that starts with '>' stand to the right.
#[derive(Debug, Clone)]
pub struct Table {
    heads: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(heads: &[&'static str]) -> Self {
        Self { heads: heads.to_vec(), rows: Vec::new() }
    }

    /// Adds a row, one cell per heading.
    pub fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.heads.len());
        self.rows.push(cells.iter().map(|cell| visible(cell)).collect());
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The table where it fits so many columns of a terminal; where not, each row as a list of its cells with their headings.
    pub fn within(&self, columns: usize) -> String {
        let table = self.to_string();
        if self.is_empty() || table.lines().all(|line| line.chars().count() <= columns) {
            return table;
        }
        self.rows.iter().map(|row| self.list(row, columns)).collect()
    }

    /// "PART: 3  PROFILE: mjf", as many in a line as fit, the first line further out.
    fn list(&self, row: &[String], columns: usize) -> String {
        let mut lines: Vec<String> = Vec::new();
        for (head, cell) in self.heads.iter().zip(row) {
            let pair = format!("{}: {cell}", head.trim_start_matches('>'));
            match lines.last_mut() {
                Some(line) if line.chars().count() + 2 + pair.chars().count() <= columns => {
                    *line += &format!("  {pair}")
                }
                Some(_) => lines.push(format!("  {pair}")),
                None => lines.push(pair),
            }
        }
        lines.iter().map(|line| format!("{line}\n")).collect()
    }

    fn width(&self, column: usize) -> usize {
        let head = self.heads[column].trim_start_matches('>').chars().count();
        self.rows.iter().map(|row| row[column].chars().count()).fold(head, usize::max)
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: Vec<usize> = (0..self.heads.len()).map(|column| self.width(column)).collect();
        let heads: Vec<String> = self.heads.iter().map(|head| head.trim_start_matches('>').to_owned()).collect();
        for row in std::iter::once(&heads).chain(&self.rows) {
            let cells =
                row.iter().zip(&widths).zip(&self.heads).map(|((cell, &width), head)| match head.starts_with('>') {
                    true => format!("{cell:>width$}"),
                    false => format!("{cell:<width$}"),
                });
            writeln!(f, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// Prints; a reader that has seen enough (`| head`) is no fault. What a customer wrote does not move the cursor of an
/// operator's terminal.
pub fn say(text: &str) -> Result<()> {
    let text = visible_lines(text);
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

/// Prints as JSON.
pub fn say_json(value: &impl serde::Serialize) -> Result<()> {
    say(&escaped_json(&serde_json::to_string_pretty(value)?))
}

/// Tells on standard error.
pub fn tell(text: &str) {
    eprintln!("nestd: {}", visible_lines(text));
}

/// JSON escapes the oldest controls only; the others, and what turns text around, stand in strings alone.
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

/// A number with so many decimals, "-" when there is none.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(dash, |v| format!("{v:.decimals$}"))
}

/// Whatever prints, "-" when there is none.
pub fn or_dash(value: Option<impl fmt::Display>) -> String {
    value.map_or_else(dash, |v| v.to_string())
}

/// '1 copy', '2 copies'.
pub fn copies(count: u32) -> String {
    counted(count, "copy", "copies")
}

/// A share 0..1 in percent.
pub fn percent(share: Option<f64>) -> String {
    number(share.map(|s| 100.0 * s), 1)
}

/// A text, "-" when it is empty.
pub fn text(value: &str) -> String {
    if value.is_empty() { dash() } else { value.to_owned() }
}

fn dash() -> String {
    "-".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell_and_numbers_stand_to_the_right() {
        let mut table = Table::new(&["NAME", ">COPIES", "STATE"]);
        table.row(vec!["größe.stl".into(), "3".into(), "waiting".into()]);
        table.row(vec!["a\u{1b}".into(), "12".into(), String::new()]);
        assert_eq!(table.to_string(), "NAME       COPIES  STATE\ngröße.stl       3  waiting\na\\u{1b}        12\n");
    }

    #[test]
    fn a_table_that_is_too_wide_is_a_list_that_leaves_nothing_out() {
        let mut table = Table::new(&["PROFILE", ">WAITING", "NEXT BUILD", "NOW"]);
        table.row(vec!["mjf".into(), "3".into(), "55.61 mm, 11 copies".into(), "collecting".into()]);
        table.row(vec!["sls".into(), "0".into(), "-".into(), "idle".into()]);
        assert_eq!(table.within(49), table.to_string());
        let list = "PROFILE: mjf  WAITING: 3\n  NEXT BUILD: 55.61 mm, 11 copies\n  NOW: collecting\n\
                    PROFILE: sls  WAITING: 0  NEXT BUILD: -\n  NOW: idle\n";
        assert_eq!(table.within(48), list);
        assert_eq!(table.within(12).matches(": ").count(), 8, "however narrow it is");
    }

    #[test]
    fn what_is_not_known_is_a_dash() {
        assert_eq!((number(None, 2), number(Some(87.5), 2), percent(Some(0.2149))), dashes());
        assert_eq!((or_dash(None::<u32>), or_dash(Some(3)), text("")), ("-".into(), "3".into(), "-".into()));
    }

    fn dashes() -> (String, String, String) {
        ("-".into(), "87.50".into(), "21.5".into())
    }
}
