//! Order lists: an `order.csv` says copies, due date, priority and more for the files of its own folder. It is read as
//! people make it: in any code page, with any delimiter, with headers in their own words or none.

use std::{borrow::Cow, ffi::OsStr};

use build_file::{visible, visible_lines};

use super::{
    Ticket,
    cells::{decimal, due_date, unit, whole},
    code_page::readings,
    columns::{Column, Columns, NO_HEADER},
    display_name,
    name::is_part_name,
    same_name::{Meaning, Meant},
    ticket::{clearance, copies, priority, text},
};

/// A longer list is none.
pub(super) const MAX_LIST_BYTES: u64 = 4 << 20;
/// A header stands among so many lines: people write a title above it.
const HEADER_WITHIN: usize = 10;
const DELIMITERS: [u8; 4] = [b';', b'\t', b',', b'|'];

/// A list as it stands there.
#[derive(Debug)]
pub struct OrderList {
    content: Result<Vec<Row>, String>,
    /// Headers of columns that mean nothing to nestd.
    unknown: Vec<String>,
}

/// What a list says about one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The file's name as the list says it; empty = the row names none.
    pub file: String,
    /// What is said, or what is wrong with it.
    pub ticket: Result<Ticket, String>,
    /// Header and row, as received: a list of this row alone.
    pub text: String,
}

impl OrderList {
    /// Reads a list whose files are not known.
    pub fn parse(bytes: &[u8]) -> Self {
        Self::parse_beside(bytes, &[])
    }

    /// Reads a list beside `files`. A code page cannot be told from the bytes: the one in which the list names most of the
    /// files is right.
    pub fn parse_beside(bytes: &[u8], files: &[&OsStr]) -> Self {
        if bytes.len() as u64 > MAX_LIST_BYTES {
            let why = format!("it is longer than {MAX_LIST_BYTES} bytes");
            return Self { content: Err(why), unknown: Vec::new() };
        }
        let mut lists = readings(bytes).into_iter().map(|text| Self::of_text(&text));
        let Some(first) = lists.next() else { return Self::of_text("") };
        let mut best = (first.fitness(files), first);
        for list in lists {
            let fitness = list.fitness(files);
            if fitness > best.0 {
                best = (fitness, list);
            }
        }
        best.1
    }

    /// What the one row of [`Row::text`] says.
    pub(super) fn alone(text: &str) -> Result<Ticket, String> {
        match Self::of_text(text).content?.into_iter().next() {
            Some(row) => row.ticket,
            None => Err("its row is empty".to_owned()),
        }
    }

    fn of_text(text: &str) -> Self {
        match rows(text) {
            Ok((rows, unknown)) => Self { content: Ok(rows), unknown },
            Err(why) => Self { content: Err(why), unknown: Vec::new() },
        }
    }

    /// How well it speaks for the files: whether it is understood at all, and how many of them it names.
    fn fitness(&self, files: &[&OsStr]) -> (bool, usize) {
        (self.content.is_ok(), self.meant(files.iter().copied()).found())
    }

    /// The rows, or why there are none.
    pub fn rows(&self) -> Result<&[Row], &str> {
        self.content.as_deref().map_err(String::as_str)
    }

    /// Which rows are for which files.
    pub(super) fn meant<'a>(&self, files: impl Iterator<Item = &'a OsStr>) -> Meant {
        let said: Vec<&str> = self.rows().unwrap_or_default().iter().map(|row| row.file.as_str()).collect();
        Meant::new(&said, files)
    }

    /// The row for a file that is alone with the list. `Err` says why its copies cannot be known: its row is broken, there
    /// are two, or the list is broken.
    pub fn row_for(&self, name: &OsStr) -> Result<Option<&Row>, String> {
        self.rows()?;
        let meant = self.meant(std::iter::once(name));
        meant.files.get(name).map(|meaning| self.row_of(meaning, name)).transpose()
    }

    /// The row that a file's name means.
    pub(super) fn row_of(&self, meaning: &Meaning, name: &OsStr) -> Result<&Row, String> {
        let rows = self.rows()?;
        let shown = display_name(name);
        match meaning {
            Meaning::Only(at) => match at[..] {
                [at] => {
                    rows[at].ticket.as_ref().map(|_| &rows[at]).map_err(|why| format!("in the row of {shown}: {why}"))
                }
                _ => Err(format!("{} rows are for {shown}; leave one", at.len())),
            },
            Meaning::Unclear(at, others) => {
                let (said, other) = (visible(&rows[*at].file), others.first().map_or("", String::as_str));
                Err(format!("its row {said} may be for {shown} or for {}; write the whole name", visible(other)))
            }
        }
    }

    /// What is to be told about it beside each part.
    pub(super) fn warnings(&self) -> Vec<String> {
        let names: Vec<String> = self.unknown.iter().map(|name| format!("{:?}", visible(name))).collect();
        match names.len() {
            0 => Vec::new(),
            1 => vec![format!("The column {} of its order list means nothing to nestd and was passed over.", names[0])],
            _ => {
                let names = names.join(", ");
                vec![format!("The columns {names} of its order list mean nothing to nestd and were passed over.")]
            }
        }
    }
}

/// The rows of a list and the columns that are not known.
fn rows(text: &str) -> Result<(Vec<Row>, Vec<String>), String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (text, forced) = without_sep(text);
    let delimiters: Vec<u8> = forced.map_or(DELIMITERS.to_vec(), |delimiter| vec![delimiter]);
    let found = delimiters.iter().map(|&delimiter| (delimiter, header(text, delimiter)));
    let mut best: Result<(u8, Header), String> = Err(NO_HEADER.to_owned());
    for (delimiter, found) in found {
        match (found, &best) {
            (Ok(header), Ok((_, known))) if header.columns.known() <= known.columns.known() => {}
            (Ok(header), _) => best = Ok((delimiter, header)),
            (Err(why), Err(_)) if why != NO_HEADER => best = Err(why),
            (Err(_), _) => {}
        }
    }
    let (delimiter, header) = match best {
        Ok(found) => found,
        Err(why) => delimiters.iter().find_map(|&d| headless(text, d).map(|header| (d, header))).ok_or(why)?,
    };
    let mut rows = Vec::new();
    each_record(&text[header.end..], delimiter, |record, row| {
        let row = match header.text {
            "" => row.to_owned(),
            header => format!("{header}\n{row}"),
        };
        let file = header.columns.cell(record, Column::File).to_owned();
        rows.push(Row { ticket: ticket(&header.columns, record), file, text: row });
        true
    })?;
    Ok((rows, header.columns.unknown))
}

/// A header as it was found.
struct Header<'a> {
    columns: Columns,
    text: &'a str,
    /// Where the rows begin.
    end: usize,
}

/// What stands behind `sep=;`, by which Excel knows the delimiter.
fn without_sep(text: &str) -> (&str, Option<u8>) {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    match first.trim_end_matches('\r').as_bytes() {
        [b's' | b'S', b'e' | b'E', b'p' | b'P', b'=', delimiter] => (rest, Some(*delimiter)),
        _ => (text, None),
    }
}

/// Calls `each` with every record that says anything and its text, until it says no.
fn each_record(
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

fn header(text: &str, delimiter: u8) -> Result<Header<'_>, String> {
    let mut found = Err(NO_HEADER.to_owned());
    let mut lines = 0;
    let end = each_record(text, delimiter, |record, row| {
        lines += 1;
        let columns = Columns::of(record.iter());
        let is_header = match &columns {
            // A title may hold a word of a header; a header has two, or is a line of its own.
            Ok(columns) => columns.known() > 1 || record.len() == 1,
            Err(why) => why != NO_HEADER,
        };
        if is_header {
            let from = row.as_ptr() as usize - text.as_ptr() as usize;
            found = columns.map(|columns| Header { columns, text: &text[from..from + row.len()], end: 0 });
        }
        !is_header && lines < HEADER_WITHIN
    })?;
    found.map(|header| Header { end, ..header })
}

/// A list of two columns without a header, where only one of them can be files and only the other copies.
fn headless(text: &str, delimiter: u8) -> Option<Header<'_>> {
    let mut file_at = None;
    let mut is_clear = true;
    each_record(text, delimiter, |record, _| {
        let is_file = |at: usize| record.get(at).is_some_and(|cell| is_part_name(OsStr::new(cell)));
        let is_count = |at: usize| record.get(at).is_some_and(|cell| whole("", cell).is_ok());
        let here = (0..2).find(|&at| is_file(at) && is_count(1 - at) && !is_file(1 - at));
        let has_more = record.iter().skip(2).any(|cell| !cell.is_empty());
        is_clear = here.is_some() && !has_more && file_at.is_none_or(|at| Some(at) == here);
        file_at = here;
        is_clear
    })
    .ok()?;
    let file = file_at.filter(|_| is_clear)?;
    Some(Header { columns: Columns::without_header(file, 1 - file), text: "", end: 0 })
}

/// What a row says.
fn ticket(columns: &Columns, record: &csv::StringRecord) -> Result<Ticket, String> {
    let cell = |column| Some(columns.cell(record, column)).filter(|cell: &&str| !cell.is_empty());
    let number = |column: Column| cell(column).map(|text| whole(column.word(), text)).transpose();
    if record.iter().skip(columns.count).any(|cell| !cell.is_empty()) {
        return Err(format!("it has {} cells for {} columns", record.len(), columns.count));
    }
    if columns.cell(record, Column::File).split(['/', '\\']).any(|folder| folder == "..") {
        return Err("it names a path; a list is for the files of its own folder".to_owned());
    }
    let orientation = |word: &str| {
        let lower = word.to_lowercase();
        let word = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(&lower);
        serde::Deserialize::deserialize(word).map_err(|error| error.to_string())
    };
    Ok(Ticket {
        copies: number(Column::Copies)?.map(copies).transpose()?,
        due: cell(Column::Due).map(due_date).transpose()?,
        priority: number(Column::Priority)?.map(priority).transpose()?,
        orientation: cell(Column::Orientation).map(orientation).transpose()?,
        order: cell(Column::Order).map(|order| text("order", visible(order))).transpose()?,
        unit: cell(Column::Unit).map(unit).transpose()?.flatten(),
        clearance_mm: cell(Column::Clearance)
            .map(|c| decimal("clearance", c))
            .transpose()?
            .map(clearance)
            .transpose()?,
        note: note(&cell).map(|note| text("note", visible_lines(&note))).transpose()?,
        ..Ticket::default()
    })
}

/// What is for people: the note, and what else a list says that a machine does not need.
fn note<'a>(cell: &impl Fn(Column) -> Option<&'a str>) -> Option<String> {
    let own = cell(Column::Note).map(Cow::from);
    let others = [Column::Customer, Column::Material].into_iter();
    let others = others.filter_map(|column| Some(Cow::from(format!("{}: {}", column.word(), cell(column)?))));
    let all: Vec<Cow<str>> = own.into_iter().chain(others).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

#[cfg(test)]
#[path = "order_list_tests.rs"]
mod tests;
