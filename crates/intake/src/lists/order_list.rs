//! Order lists: an `order.csv` (or the only list of its folder) gives copies, due date, priority and more for the files of its own folder. It accepts
//! lists as people write them: as text in any code page, with any delimiter, or as a workbook; with headers in their own words or
//! without a header.

use std::{
    collections::{HashMap, HashSet},
    ffi::OsStr,
};

use build_file::{
    check_clearance, check_copies, check_email, check_finish, check_name, check_note, check_priority, escape_invisible,
};

use super::{
    list_cells::{bare_cell, is_placeholder, parse_decimal, parse_due_cell, parse_unit, parse_whole_number},
    list_columns::{ColumnLayout, ListColumn, NO_HEADER},
    list_extras::ExtraRows,
    texts::{
        header::{ListHeader, find_header, for_each_record, infer_columns, strip_sep_line},
        heading::{Heading, priority_warning},
        plain_rows::plain_rows,
    },
    workbook::{is_workbook, sheet_texts},
};
use crate::{
    Ticket, display_name,
    names::{
        code_page::{CodePage, decode_candidates, text_plausibility},
        name::is_part_name,
        name_match::{FileNameMatch, NameMatches, fold_name},
    },
};

/// A longer file is not accepted as a list.
pub(crate) const MAX_LIST_BYTES: u64 = 4 << 20;
const DELIMITERS: [u8; 4] = [b';', b'\t', b',', b'|'];

/// A parsed order list.
#[derive(Debug)]
pub struct OrderList {
    content: Result<Vec<OrderListRow>, String>,
    /// Column headers that nestd does not know.
    unknown: Vec<String>,
    /// What is told with each of its parts, in whole sentences.
    warnings: Vec<String>,
    /// In which it was read. The names of files in the same bytes are read in it, too.
    page: CodePage,
}

/// What a list says about one file.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderListRow {
    /// File name as written in the list. Empty = the row names no file.
    pub file: String,
    /// The parsed instructions, or the error in the row.
    pub ticket: Result<Ticket, String>,
    /// What it says against itself in a column of another kind, such as `status = cancelled`.
    pub objection: Option<String>,
    /// Header and row as received: a valid list with only this row.
    pub text: String,
}

impl OrderList {
    /// Parses a list without knowing the files of its folder.
    pub fn parse_list(bytes: &[u8]) -> Self {
        Self::parse_for_files(bytes, &[])
    }

    /// Parses a list in the folder of `files`. The bytes do not tell the code page, so the decoding in which the list
    /// names most of the files is chosen.
    pub fn parse_for_files(bytes: &[u8], files: &[&OsStr]) -> Self {
        if bytes.len() as u64 > MAX_LIST_BYTES {
            let why = format!("it is longer than {MAX_LIST_BYTES} bytes");
            return Self::broken(why);
        }
        if is_workbook(bytes) {
            return Self::from_workbook(bytes, &folded_names(files));
        }
        let names = folded_names(files);
        let mut best = None;
        for reading in decode_candidates(bytes) {
            let list = Self { page: reading.page, ..Self::from_text_for(&reading.text, &names) };
            let fitness = (list.match_quality(files), text_plausibility(&reading.text));
            if best.as_ref().is_none_or(|(known, _)| fitness > *known) {
                best = Some((fitness, list));
            }
        }
        best.map_or_else(|| Self::from_text(""), |(_, list)| list)
    }

    /// The rows of all sheets that have the columns of a list; where none has, what is wrong with the first.
    fn from_workbook(bytes: &[u8], files: &HashSet<String>) -> Self {
        let lists = match sheet_texts(bytes) {
            Ok(texts) if texts.is_empty() => return Self::broken("its sheets are empty".to_owned()),
            Ok(texts) => texts.into_iter().map(|text| Self::from_text_for(&text, files)),
            Err(why) => return Self::broken(why),
        };
        let with_sheet = |known: Self, sheet: Self| match (&known.content, &sheet.content) {
            (_, Err(_)) => known,
            (Err(_), Ok(_)) => sheet,
            (Ok(_), Ok(_)) => known.with_sheet(sheet),
        };
        lists.reduce(with_sheet).unwrap_or_else(|| Self::broken(NO_HEADER.to_owned()))
    }

    /// The list with the rows of a further sheet. A row that says the same once more is left out, as is one that names no file: a sheet may
    /// have the columns of a list for something else.
    fn with_sheet(mut self, sheet: Self) -> Self {
        if let (Ok(rows), Ok(more)) = (&mut self.content, sheet.content) {
            let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
            rows.iter().enumerate().for_each(|(at, row)| by_name.entry(fold_name(&row.file)).or_default().push(at));
            let says_same = |a: &OrderListRow, b: &OrderListRow| (&a.ticket, &a.objection) == (&b.ticket, &b.objection);
            for mut row in more {
                let known = by_name.get(&fold_name(&row.file)).map(Vec::as_slice);
                let is_file = known.is_some() || is_part_name(row.file.as_ref());
                // In whatever letter case, it is the same file.
                if let Some(&[at, ..]) = known {
                    row.file.clone_from(&rows[at].file);
                }
                if is_file && !known.into_iter().flatten().any(|&at| says_same(&rows[at], &row)) {
                    rows.push(row);
                }
            }
            let known: Vec<String> = sheet.unknown.into_iter().filter(|name| !self.unknown.contains(name)).collect();
            self.unknown.extend(known);
            self.warnings.extend(sheet.warnings);
        }
        self
    }

    /// Parses the single row of [`OrderListRow::text`].
    pub(crate) fn parse_single_row(text: &str) -> Result<OrderListRow, String> {
        Self::from_text(text).content?.into_iter().next().ok_or_else(|| "its row is empty".to_owned())
    }

    fn broken(why: String) -> Self {
        Self { content: Err(why), unknown: Vec::new(), warnings: Vec::new(), page: CodePage::Unicode }
    }

    fn from_text(text: &str) -> Self {
        Self::from_text_for(text, &HashSet::new())
    }

    fn from_text_for(text: &str, files: &HashSet<String>) -> Self {
        match parse_rows(text, files) {
            Ok((rows, unknown, warnings)) => Self { content: Ok(rows), unknown, warnings, page: CodePage::Unicode },
            Err(why) => Self::broken(why),
        }
    }

    /// Scores a decoding: whether the list can be parsed, and how many of the files it names.
    fn match_quality(&self, files: &[&OsStr]) -> (bool, usize) {
        (self.content.is_ok(), self.match_files(files.iter().copied()).matched_count())
    }

    /// The rows, or why the list cannot be parsed.
    pub fn rows(&self) -> Result<&[OrderListRow], &str> {
        self.content.as_deref().map_err(String::as_str)
    }

    /// The code page in which it was read.
    pub(crate) fn page(&self) -> CodePage {
        self.page
    }

    /// Matches rows with files.
    pub(crate) fn match_files<'a>(&self, files: impl Iterator<Item = &'a OsStr>) -> NameMatches {
        let said: Vec<&str> = self.rows().unwrap_or_default().iter().map(|row| row.file.as_str()).collect();
        NameMatches::in_code_page(&said, files, self.page)
    }

    /// Whether a row names one of these files.
    pub(super) fn names_any(&self, files: &[&OsStr]) -> bool {
        self.match_quality(files).1 > 0
    }

    /// Finds the row for a single file. `Err` says why its number of copies is unknown: its row is broken, two rows
    /// match, or the list is broken.
    pub fn row_for_file(&self, name: &OsStr) -> Result<Option<&OrderListRow>, String> {
        self.rows()?;
        let meant = self.match_files(std::iter::once(name));
        meant.files.get(name).map(|meaning| self.matched_row(meaning, name)).transpose()
    }

    /// The row that was matched with a file.
    pub(super) fn matched_row(&self, meaning: &FileNameMatch, name: &OsStr) -> Result<&OrderListRow, String> {
        let rows = self.rows()?;
        let shown = display_name(name);
        match meaning {
            FileNameMatch::Only(at) => match at[..] {
                [at] => {
                    rows[at].ticket.as_ref().map(|_| &rows[at]).map_err(|why| format!("in the row of {shown}: {why}"))
                }
                _ => Err(format!(
                    "{} rows are for {shown}; where all are wanted, add them up or give each its own file name or folder, otherwise leave one",
                    at.len()
                )),
            },
            FileNameMatch::Ambiguous(at, others) => {
                let (said, other) = (escape_invisible(&rows[*at].file), others.first().map_or("", String::as_str));
                let last = |path: &str| fold_name(path.rsplit('/').next().unwrap_or(path));
                // Of files with one name, the folder tells which is meant.
                let remedy = match last(other) == last(&name.to_string_lossy()) {
                    true => "write its folder too, as here",
                    false => "write the whole name",
                };
                Err(format!("its row {said} may be for {shown} or for {}; {remedy}", escape_invisible(other)))
            }
        }
    }

    /// Warnings about the list, to be reported with each of its parts.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let names: Vec<String> = self.unknown.iter().map(|name| format!("{:?}", escape_invisible(name))).collect();
        let ignored = match names.len() {
            0 => None,
            1 => Some(format!("The column {} of its order list is unknown to nestd and was ignored.", names[0])),
            _ => {
                let names = names.join(", ");
                Some(format!("The columns {names} of its order list are unknown to nestd and were ignored."))
            }
        };
        ignored.into_iter().chain(self.warnings.iter().cloned()).collect()
    }
}

/// The rows of a list, the headers of unknown columns, and warnings.
type ParsedRows = (Vec<OrderListRow>, Vec<String>, Vec<String>);

/// The names of files in folded form, without their folders, with and without extension.
fn folded_names(files: &[&OsStr]) -> HashSet<String> {
    let mut names = HashSet::new();
    for file in files {
        let name = fold_name(&file.to_string_lossy());
        let name = name.rsplit('/').next().unwrap_or(&name);
        names.extend(name.rsplit_once('.').map(|(stem, _)| stem.to_owned()));
        names.insert(name.to_owned());
    }
    names
}

/// Parses the rows of a list. Where the header leaves a choice, the column in which most of `files` stand is that of the files.
fn parse_rows(text: &str, files: &HashSet<String>) -> Result<ParsedRows, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (text, forced) = strip_sep_line(text);
    let delimiters: Vec<u8> = forced.map_or(DELIMITERS.to_vec(), |delimiter| vec![delimiter]);
    let found = delimiters.iter().map(|&delimiter| (delimiter, find_header(text, delimiter)));
    let mut best: Result<(u8, ListHeader), String> = Err(NO_HEADER.to_owned());
    for (delimiter, found) in found {
        match (found, &best) {
            (Ok(header), Ok((_, known))) if header.columns.known_count() <= known.columns.known_count() => {}
            (Ok(header), _) => best = Ok((delimiter, header)),
            (Err(why), Err(_)) if why != NO_HEADER => best = Err(why),
            (Err(_), _) => {}
        }
    }
    let (delimiter, mut header) = match best {
        Ok(found) => found,
        Err(why) => match delimiters.iter().find_map(|&d| infer_columns(text, d).map(|header| (d, header))) {
            Some(found) => found,
            None => return plain_rows(text).map_or(Err(why), |rows| parse_rows(&rows, files)),
        },
    };
    let body = &text[header.end..];
    let mut names = vec![(0, 0); header.columns.count];
    for_each_record(body, delimiter, |record, _| {
        for ((matched, names), cell) in names.iter_mut().zip(record) {
            let last = bare_cell(cell).rsplit(['/', '\\']).next().unwrap_or_default();
            *matched += usize::from(!last.is_empty() && files.contains(&fold_name(last)));
            *names += usize::from(is_part_name(OsStr::new(bare_cell(cell))));
        }
        true
    })?;
    header.columns.choose_file_column(|at| names[at]);
    let heading = Heading::read(header.above, delimiter);
    let mut rows = Vec::new();
    let mut extras = ExtraRows::new(header.text, delimiter);
    for_each_record(body, delimiter, |record, text| {
        let ticket = parse_row_ticket(&header.columns, record);
        if extras.is_extra_row(&header.columns, record, text, &ticket) {
            return true;
        }
        let row = match header.text {
            "" => text.to_owned(),
            header => format!("{}{header}\n{text}", heading.text),
        };
        rows.push(OrderListRow {
            ticket: ticket.map(|ticket| ticket.merge_weaker(heading.ticket.clone())),
            objection: header.columns.objection(record).map(|said| escape_invisible(&said)),
            file: header.columns.cell_text(record, ListColumn::File).to_owned(),
            text: row,
        });
        true
    })?;
    let mut warnings = heading.warnings;
    warnings.extend(priority_warning(rows.iter().filter_map(|row| row.ticket.as_ref().ok()?.priority)));
    Ok((rows, header.columns.unknown_headers(), warnings))
}

/// Parses the instructions of a row.
fn parse_row_ticket(columns: &ColumnLayout, record: &csv::StringRecord) -> Result<Ticket, String> {
    // A dash for a number of copies may mean none.
    let is_empty =
        |column, cell: &str| if column == ListColumn::Copies { cell.is_empty() } else { is_placeholder(cell) };
    let cell = |column| Some(columns.cell_text(record, column)).filter(|cell: &&str| !is_empty(column, cell));
    let number =
        |column: ListColumn| cell(column).map(|text| parse_whole_number(column.ticket_word(), text)).transpose();
    if record.iter().skip(columns.count).any(|cell| !cell.is_empty()) {
        return Err(format!("it has {} cells for {} columns", record.len(), columns.count));
    }
    if columns.cell_text(record, ListColumn::File).split(['/', '\\']).any(|folder| folder == "..") {
        return Err("it names a path; a list is for the files of its own folder".to_owned());
    }
    let orientation = |word: &str| {
        let lower = word.to_lowercase();
        let word = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(&lower);
        serde::Deserialize::deserialize(word).map_err(|error| error.to_string())
    };
    Ok(Ticket {
        copies: number(ListColumn::Copies)?.map(check_copies).transpose()?,
        due: cell(ListColumn::Due).map(parse_due_cell).transpose()?,
        priority: number(ListColumn::Priority)?.map(check_priority).transpose()?,
        orientation: cell(ListColumn::Orientation).map(orientation).transpose()?,
        order: cell(ListColumn::Order).map(|order| check_name("order", order)).transpose()?,
        customer: cell(ListColumn::Customer).map(|name| check_name("customer", name)).transpose()?,
        email: cell(ListColumn::Email).map(check_email).transpose()?,
        material: cell(ListColumn::Material).map(|name| check_name("material", name)).transpose()?,
        finish: cell(ListColumn::Finish).map(check_finish).transpose()?,
        unit: cell(ListColumn::Unit).map(parse_unit).transpose()?.flatten(),
        clearance_mm: cell(ListColumn::Clearance)
            .map(|c| parse_decimal("clearance", c))
            .transpose()?
            .map(check_clearance)
            .transpose()?,
        note: cell(ListColumn::Note).map(check_note).transpose()?,
        ..Ticket::default()
    })
}

#[cfg(test)]
#[path = "tests/order_list_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "tests/list_samples_tests.rs"]
mod list_samples_tests;

#[cfg(test)]
#[path = "tests/heading_tests.rs"]
mod heading_tests;
