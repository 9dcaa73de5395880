//! Order lists: an `order.csv` says copies, due date, priority and orientation for the files of its own folder.

use std::{
    ffi::OsStr,
    io::{self, Read},
    path::Path,
};

use super::{
    Ticket, disk, display_name,
    ticket::{copies, due, priority},
};

/// A longer list is none.
const MAX_LIST_BYTES: u64 = 4 << 20;
const COLUMNS: [&str; 5] = ["file", "copies", "due", "priority", "orientation"];
/// Other words for a column, as `nest --list` takes them.
const OTHER_WORDS: [(&str, &str); 2] = [("quantity", "copies"), ("qty", "copies")];

/// A list as it stands there.
#[derive(Debug)]
pub struct OrderList {
    text: String,
    content: Result<Vec<Row>, String>,
}

/// What a list says about one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The file's name; empty = the row names none.
    pub file: String,
    /// What is said, or what is wrong with it.
    pub ticket: Result<Ticket, String>,
    /// Header and row, as received.
    pub text: String,
}

impl OrderList {
    /// Reads a list from the disk; what is wrong inside is kept in it.
    pub(super) fn read(path: &Path) -> io::Result<Self> {
        let mut bytes = Vec::new();
        disk::open_regular(path)?.take(MAX_LIST_BYTES + 1).read_to_end(&mut bytes)?;
        Ok(Self::parse(bytes))
    }

    /// Spreadsheets write UTF-8 with or without a byte order mark, or Latin-1; with commas, semicolons or tabs.
    pub fn parse(bytes: Vec<u8>) -> Self {
        let is_too_long = bytes.len() as u64 > MAX_LIST_BYTES;
        let text =
            String::from_utf8(bytes).unwrap_or_else(|e| e.into_bytes().into_iter().map(char::from).collect::<String>());
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned();
        let content = match is_too_long {
            true => Err(format!("it is longer than {MAX_LIST_BYTES} bytes")),
            false => rows(&text),
        };
        Self { text, content }
    }

    /// The rows, or why there are none.
    pub fn rows(&self) -> Result<&[Row], &str> {
        self.content.as_deref().map_err(String::as_str)
    }

    /// The row for a file. `Err` says why its copies cannot be known: its row is broken, there are two, or the list is
    /// broken and names the file somewhere.
    pub fn row_for(&self, name: &OsStr) -> Result<Option<&Row>, String> {
        let rows = match &self.content {
            Ok(rows) => rows,
            Err(why) if name.to_str().is_some_and(|n| self.text.contains(n)) => return Err(why.clone()),
            Err(_) => return Ok(None),
        };
        let shown = display_name(name);
        let mut found: Vec<&Row> = rows.iter().filter(|r| OsStr::new(&r.file) == name || r.file == shown).collect();
        if found.is_empty() {
            found = rows.iter().filter(|r| name.eq_ignore_ascii_case(&r.file)).collect();
        }
        match found[..] {
            [] => Ok(None),
            [row] => row.ticket.as_ref().map(|_| Some(row)).map_err(|why| format!("in the row of {shown}: {why}")),
            _ => Err(format!("{} rows are for {shown}; leave one", found.len())),
        }
    }
}

fn rows(text: &str) -> Result<Vec<Row>, String> {
    let header = text.lines().next().unwrap_or("");
    let delimiter = [b';', b'\t'].into_iter().find(|&d| header.contains(char::from(d))).unwrap_or(b',');
    let mut reader =
        csv::ReaderBuilder::new().delimiter(delimiter).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
    let columns = columns(reader.headers().map_err(|e| e.to_string())?)?;
    let header = header.trim_end();
    let mut rows = Vec::new();
    let mut record = csv::StringRecord::new();
    loop {
        let from = reader.position().byte() as usize;
        if !reader.read_record(&mut record).map_err(|e| e.to_string())? {
            return Ok(rows);
        }
        let row = text[from..reader.position().byte() as usize].trim();
        if record.iter().any(|cell| !cell.is_empty()) {
            let file = columns.cell(&record, 0).to_owned();
            rows.push(Row { ticket: columns.ticket(&record), file, text: format!("{header}\n{row}") });
        }
    }
}

/// Where each of [`COLUMNS`] stands in this list.
struct Columns {
    places: [Option<usize>; COLUMNS.len()],
    count: usize,
}

fn columns(header: &csv::StringRecord) -> Result<Columns, String> {
    let mut places = [None; COLUMNS.len()];
    for (at, name) in header.iter().enumerate() {
        let other = OTHER_WORDS.iter().find(|(other, _)| name.eq_ignore_ascii_case(other));
        let word = other.map_or(name, |&(_, word)| word);
        let known = COLUMNS.iter().position(|c| word.eq_ignore_ascii_case(c));
        let known = known.ok_or_else(|| format!("it has a column {name:?}; known are {}", COLUMNS.join(", ")))?;
        if places[known].replace(at).is_some() {
            return Err(format!("it has two columns for {}", COLUMNS[known]));
        }
    }
    match places[0] {
        Some(_) => Ok(Columns { places, count: header.len() }),
        None => Err(format!("its first line must name its columns, at least file; known are {}", COLUMNS.join(", "))),
    }
}

impl Columns {
    fn cell<'a>(&self, record: &'a csv::StringRecord, column: usize) -> &'a str {
        self.places[column].and_then(|at| record.get(at)).unwrap_or("")
    }

    fn ticket(&self, record: &csv::StringRecord) -> Result<Ticket, String> {
        let cell = |column| Some(self.cell(record, column)).filter(|cell| !cell.is_empty());
        let whole = |column: usize| {
            let number =
                |text: &str| text.parse::<i64>().map_err(|_| format!("{} = {text:?} is no number", COLUMNS[column]));
            cell(column).map(number).transpose()
        };
        if record.len() > self.count {
            return Err(format!("it has {} cells for {} columns", record.len(), self.count));
        }
        if self.cell(record, 0).contains('/') {
            return Err("it names a path; a list is for the files of its own folder".to_owned());
        }
        let orientation = |text: &str| {
            let word = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(text);
            serde::Deserialize::deserialize(word).map_err(|error| error.to_string())
        };
        Ok(Ticket {
            copies: whole(1)?.map(copies).transpose()?,
            due: cell(2).map(due).transpose()?,
            priority: whole(3)?.map(priority).transpose()?,
            orientation: cell(4).map(orientation).transpose()?,
            ..Ticket::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nest::OrientationRule;

    fn list(text: &str) -> OrderList {
        OrderList::parse(text.into())
    }

    fn row<'a>(list: &'a OrderList, name: &str) -> &'a Row {
        list.row_for(OsStr::new(name)).unwrap().unwrap_or_else(|| panic!("no row for {name}"))
    }

    #[test]
    fn each_column_is_read() {
        let list = list("file,copies,due,priority,orientation\na.stl,10,2026-11-25,80,fixed\nb.stl,,,,\n");
        let ticket = row(&list, "a.stl").ticket.clone().unwrap();
        assert_eq!((ticket.copies, ticket.priority), (Some(10), Some(80)));
        assert_eq!(ticket.orientation, Some(OrientationRule::Fixed));
        assert_eq!(ticket.due, Some(due("2026-11-25").unwrap()));
        assert_eq!(row(&list, "a.stl").text, "file,copies,due,priority,orientation\na.stl,10,2026-11-25,80,fixed");
        assert_eq!(row(&list, "b.stl").ticket, Ok(Ticket::default()));
        assert_eq!(list.row_for(OsStr::new("c.stl")), Ok(None));
    }

    #[test]
    fn lists_of_spreadsheets_are_read() {
        for text in [
            "\u{feff}File;Copies\r\n\"gr\u{f6}\u{df}e; 2.stl\";3\r\n;\r\n",
            "copies\tfile\n3\tgr\u{f6}\u{df}e; 2.stl\n",
            "file , copies\n gr\u{f6}\u{df}e; 2.stl , 3",
        ] {
            assert_eq!(row(&list(text), "größe; 2.stl").ticket.clone().unwrap().copies, Some(3), "{text:?}");
        }
        let latin1 = OrderList::parse(b"file,copies\ngr\xf6\xdfe.stl,3\n".to_vec());
        assert_eq!(row(&latin1, "größe.stl").ticket.clone().unwrap().copies, Some(3));
    }

    #[test]
    fn quantity_is_another_word_for_copies() {
        for text in ["file,quantity\na.stl,3\n", "Qty;File\n3;a.stl\n", "file\tQUANTITY\na.stl\t3\n"] {
            assert_eq!(row(&list(text), "a.stl").ticket.clone().unwrap().copies, Some(3), "{text:?}");
        }
        let both = list("file,copies,qty\na.stl,3,4\n");
        assert_eq!(both.row_for(OsStr::new("a.stl")).unwrap_err(), "it has two columns for copies");
    }

    #[test]
    fn letters_may_differ_in_case_where_no_row_fits_exactly() {
        let list = list("file,copies\nPart.STL,3\na.stl,1\nA.stl,2\n");
        assert_eq!(row(&list, "part.stl").ticket.clone().unwrap().copies, Some(3));
        assert_eq!(row(&list, "A.stl").ticket.clone().unwrap().copies, Some(2));
    }

    #[test]
    fn names_that_are_no_text_are_found_by_what_status_shows() {
        use std::os::unix::ffi::OsStrExt;
        let list = list("file,copies\na\\xff.stl,3\n");
        assert!(list.row_for(OsStr::from_bytes(b"a\xff.stl")).unwrap().is_some());
    }

    #[test]
    fn a_broken_row_speaks_for_its_own_file_only() {
        let list = list(
            "file,copies,priority\na.stl,ten,\nb.stl,0,\nc.stl,1,101\nd.stl,1,1,1\n../e.stl,1,\nf.stl,2,\nf.stl,3,\ng.stl,4\n",
        );
        for (name, said) in [
            ("a.stl", "\"ten\" is no number"),
            ("b.stl", "1 to 10000"),
            ("c.stl", "0 to 100"),
            ("d.stl", "4 cells"),
            ("../e.stl", "a path"),
            ("f.stl", "2 rows"),
        ] {
            let why = list.row_for(OsStr::new(name)).unwrap_err();
            assert!(why.contains(said), "{name}: {why}");
        }
        assert_eq!(row(&list, "g.stl").ticket.clone().unwrap().copies, Some(4));
    }

    #[test]
    fn a_broken_list_speaks_for_the_files_that_it_names() {
        for text in ["a.stl,10\n", "file,amount\na.stl,10\n", "file,file\na.stl,10\n", "a.stl"] {
            let list = list(text);
            assert!(list.rows().is_err(), "{text}");
            assert!(list.row_for(OsStr::new("a.stl")).is_err(), "{text}");
            assert_eq!(list.row_for(OsStr::new("b.stl")), Ok(None), "{text}");
        }
        assert!(list("").rows().is_err());
    }
}
