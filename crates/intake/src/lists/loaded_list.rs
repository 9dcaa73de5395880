//! An order list that was read, matched with the files of its folder and with those already claimed from there.

use std::ffi::{OsStr, OsString};

use super::{
    order_list::{OrderList, OrderListRow},
    served_rows::ServedRows,
};
use crate::{
    InboxEntry, ListLookup, display_name,
    names::name_match::{FileNameMatch, NameMatches},
};

/// A loaded list and its matches among the files of its folder.
#[derive(Debug)]
pub(crate) struct LoadedList {
    /// Inode, change time and size of the file that was read.
    pub fingerprint: (u64, i128, u64),
    /// Its name, escaped for display.
    name: String,
    bytes: Vec<u8>,
    pub list: OrderList,
    /// The files that `meant` was computed for.
    names: Vec<OsString>,
    pub matches: NameMatches,
    pub marks: ServedRows,
    /// When this process saw a row served, seconds.
    pub served_secs: Option<f64>,
    /// Whether every row is served.
    is_served: bool,
    /// Number of the scan that this was computed for.
    pub scan_number: u64,
}

impl LoadedList {
    /// A list that is matched with no file yet.
    pub fn new(print: (u64, i128, u64), name: String, bytes: Vec<u8>, marks: ServedRows) -> Self {
        let list = OrderList::parse_for_files(&bytes, &[]);
        Self {
            fingerprint: print,
            name,
            bytes,
            list,
            names: Vec::new(),
            matches: NameMatches::default(),
            marks,
            served_secs: None,
            is_served: false,
            scan_number: 0,
        }
    }

    /// Matches the list with these files, unless that was done before.
    pub fn match_files(mut self, names: Vec<OsString>, look: u64) -> Self {
        if self.names != names {
            let files: Vec<&OsStr> = names.iter().map(OsString::as_os_str).collect();
            self.list = OrderList::parse_for_files(&self.bytes, &files);
            self.matches = self.list.match_files(files.into_iter());
            self.names = names;
        }
        let is_served = |row: &OrderListRow| !row.file.is_empty() && self.marks.is_served(&row.file);
        self.is_served = self.list.rows().is_ok_and(|rows| !rows.is_empty() && rows.iter().all(is_served));
        self.scan_number = look;
        self
    }

    /// Returns what the list says about a file. `Err` says why it says nothing.
    pub fn look_up_part(&self, name: &OsStr) -> Result<ListLookup, String> {
        let list = &self.name;
        let rows = self.list.rows().map_err(|why| format!("stands beside {list}, which is not understood: {why}"))?;
        let Some(meaning) = self.matches.files.get(name) else {
            return Err(format!("stands in none of the {} rows of {list}", rows.len()));
        };
        if let FileNameMatch::Only(at) = meaning
            && at.iter().any(|&at| self.marks.is_late(&rows[at].file))
        {
            return Err(format!(
                "came after its row in {list} was used for a part of that name that had been taken before"
            ));
        }
        let said = ListLookup { list_name: list.clone(), ..ListLookup::default() };
        let unclear = matches!(meaning, FileNameMatch::Ambiguous(..));
        let unused_rows = self.rows_for(name);
        match self.list.matched_row(meaning, name) {
            // The claim stores only this row, so the row must parse to the same ticket by itself.
            Ok(row) if OrderList::parse_single_row(&row.text).and_then(|alone| alone.ticket) != row.ticket => {
                let why = "the list cannot be split into rows; save it again as UTF-8, with a header and commas";
                Ok(ListLookup { problem: Some(why.to_owned()), unused_rows, ..said })
            }
            Ok(row) => Ok(ListLookup {
                row: Some(row.text.clone()),
                file: Some(row.file.clone()),
                warnings: self.list.warnings(),
                ..said
            }),
            Err(why) if unclear => Err(format!("is not clear in {list}: {why}")),
            Err(why) => Ok(ListLookup { problem: Some(why), unused_rows, ..said }),
        }
    }

    /// What is asked about a part in a folder below the list that no row names.
    pub fn question_below(&self, part: &InboxEntry) -> Option<ListLookup> {
        let list = &self.name;
        let why = match self.list.rows() {
            Err(_) => format!("{list} in a folder above is not understood"),
            Ok(rows) => format!(
                "{} stands in none of the {} rows of {list} in a folder above",
                display_name(part.path.file_name().unwrap_or_default()),
                rows.len()
            ),
        };
        Some(ListLookup { question: Some(why), ..ListLookup::default() })
    }

    /// File names as written in the rows that mean a file, or may mean it.
    pub fn rows_for(&self, name: &OsStr) -> Vec<String> {
        let rows = self.list.rows().unwrap_or_default();
        let meant = match self.matches.files.get(name) {
            Some(FileNameMatch::Only(at)) => at.clone(),
            Some(FileNameMatch::Ambiguous(at, _)) => vec![*at],
            None => Vec::new(),
        };
        meant.into_iter().filter_map(|at| Some(rows.get(at)?.file.clone())).collect()
    }

    /// Whether a part that the list does not name may still belong to it, because the part arrived while the list was
    /// being served. A part that arrived after all rows were served, or long after the list, is unrelated to it.
    pub fn may_cover_part(&self, list: &InboxEntry, part_ctime_ns: i128, incomplete_secs: f64) -> bool {
        let last_ns = self.marks.last_served_ns().unwrap_or(list.ctime_ns).max(list.ctime_ns);
        match self.is_served {
            true => part_ctime_ns <= last_ns,
            false => part_ctime_ns <= last_ns.saturating_add((incomplete_secs * 1e9) as i128),
        }
    }
}
