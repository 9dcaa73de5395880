//! Which file of a folder is its order list. People save lists under many names, and browsers number a second download, so
//! the only list of a folder counts whatever its name. Where there are several, or only a spreadsheet, the parts beside
//! them wait: otherwise they would be printed once, although a number of copies was written down.

use std::{
    collections::HashMap,
    ffi::{OsStr, OsString},
    io::{self, Read},
    path::Path,
};

use super::{
    EntryKind, InboxEntry, disk, display_name,
    file_role::{FileRole, LIST_NAME, file_role},
    order_list::{MAX_LIST_BYTES, OrderList},
    served_rows::ServedRows,
};

const SPREADSHEETS: [&str; 4] = ["xlsx", "xls", "ods", "numbers"];
/// Start of the name of a text file that is taken for an order list.
const TEXT_LIST_START: &str = "order";
/// No more text files of one folder are read by each scan.
const MAX_TEXTS_PER_FOLDER: usize = 16;

/// A file that may say how many copies are ordered of the parts beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ListFormat {
    /// An `order.csv`, in any letter case.
    OrderCsv,
    /// Another list that nestd can read.
    OtherText,
    /// A file that nestd cannot read.
    Spreadsheet,
}

/// Recognises lists by name. Text files need a look at their content too, see [`mark_text_lists`].
pub(super) fn list_format(path: &Path) -> Option<ListFormat> {
    let name = path.file_name()?;
    if name.eq_ignore_ascii_case(LIST_NAME) {
        return Some(ListFormat::OrderCsv);
    }
    let has_start =
        |name: &str| name.get(..TEXT_LIST_START.len()).is_some_and(|start| start.eq_ignore_ascii_case(TEXT_LIST_START));
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "csv" | "tsv" => Some(ListFormat::OtherText),
        "txt" if has_start(&name.to_string_lossy()) => Some(ListFormat::OtherText),
        other if SPREADSHEETS.contains(&other) => Some(ListFormat::Spreadsheet),
        _ => None,
    }
}

/// The format of an entry that is a list.
pub(super) fn entry_list_format(seen: &InboxEntry) -> Option<ListFormat> {
    match list_format(&seen.path) {
        _ if seen.kind != EntryKind::File => None,
        None if seen.is_text_list => Some(ListFormat::OtherText),
        other => other,
    }
}

/// Whether an entry is a part, as far as its name tells.
pub(super) fn is_part_entry(seen: &InboxEntry) -> bool {
    seen.kind == EntryKind::File && entry_list_format(seen).is_none() && file_role(&seen.path) == FileRole::Part
}

/// The lists of one folder.
#[derive(Debug, Default)]
pub(super) struct FolderLists<'a> {
    /// The list that counts: `order.csv`, or the only one that can be read.
    pub list: Option<&'a InboxEntry>,
    /// Other lists, and spreadsheets without a list. The parts of the folder wait for a person to settle it.
    pub rivals: Vec<&'a InboxEntry>,
    /// `order.csv` in other letter case, and spreadsheets beside a list. They change nothing.
    pub surplus: Vec<&'a InboxEntry>,
}

impl<'a> FolderLists<'a> {
    /// The lists of all folders that have any.
    pub fn by_folder(seen: &'a [InboxEntry]) -> HashMap<&'a Path, Self> {
        let mut found: HashMap<&Path, Vec<(ListFormat, &InboxEntry)>> = HashMap::new();
        for one in seen {
            if let Some(format) = entry_list_format(one) {
                found.entry(one.path.parent().unwrap_or(Path::new(""))).or_default().push((format, one));
            }
        }
        found.into_iter().map(|(folder, lists)| (folder, Self::choose_list(&lists))).collect()
    }

    fn choose_list(lists: &[(ListFormat, &'a InboxEntry)]) -> Self {
        let of = |wanted| lists.iter().filter(move |(format, _)| *format == wanted).map(|&(_, one)| one);
        let mut orders = of(ListFormat::OrderCsv);
        let others: Vec<&InboxEntry> = of(ListFormat::OtherText).collect();
        match (orders.next(), &others[..]) {
            (None, &[only]) => {
                Self { list: Some(only), rivals: Vec::new(), surplus: of(ListFormat::Spreadsheet).collect() }
            }
            (None, _) => Self {
                list: None,
                rivals: others.into_iter().chain(of(ListFormat::Spreadsheet)).collect(),
                surplus: Vec::new(),
            },
            (list, _) => Self { list, rivals: others, surplus: orders.chain(of(ListFormat::Spreadsheet)).collect() },
        }
    }

    /// What the parts beside the rivals wait for (part of a sentence that names the part first).
    pub fn rival_reason(&self) -> Option<String> {
        let (sheets, texts): (Vec<&InboxEntry>, Vec<&InboxEntry>) =
            self.rivals.iter().copied().partition(|one| is_spreadsheet(one));
        match (texts.is_empty(), sheets.first()) {
            (true, None) => None,
            (true, Some(sheet)) => Some(format!(
                "{}, a spreadsheet, which nestd does not read: save it as CSV under the name {LIST_NAME}",
                shown_name(sheet)
            )),
            (false, _) => {
                let names: Vec<String> = texts.into_iter().chain(self.list).map(shown_name).collect();
                Some(format!("{}: put all rows into one list", names.join(" and ")))
            }
        }
    }
}

/// Why a list that does not count is refused, in whole sentences.
pub(super) fn rival_refusal(rival: &InboxEntry, reason: &str) -> String {
    match is_spreadsheet(rival) {
        true => format!(
            "This is a spreadsheet, which nestd does not read. Save it as CSV under the name {LIST_NAME}, and drop that \
             together with the parts."
        ),
        false => format!(
            "A folder has one order list, but in this one there were {reason}. Drop that list together with the parts that \
             were refused."
        ),
    }
}

/// Why a list that changes nothing is refused, in whole sentences.
pub(super) fn surplus_refusal(surplus: &InboxEntry, list: Option<&InboxEntry>) -> String {
    match is_spreadsheet(surplus) {
        true => format!(
            "This is a spreadsheet, which nestd does not read; the parts beside it go by {}. Nothing needs to be done, unless \
             the spreadsheet says something else: then save it as CSV under that name.",
            list.map_or_else(|| LIST_NAME.to_owned(), shown_name)
        ),
        false => {
            "This folder has another order.csv, in other upper or lower case. Put all rows into one list.".to_owned()
        }
    }
}

pub(super) fn is_spreadsheet(seen: &InboxEntry) -> bool {
    entry_list_format(seen) == Some(ListFormat::Spreadsheet)
}

/// The display name of an entry without its folder.
pub(super) fn shown_name(seen: &InboxEntry) -> String {
    display_name(seen.path.file_name().unwrap_or_default())
}

/// Marks the text files whose content is an order list that names a file beside it, or one that it was served to.
pub(super) fn mark_text_lists(inbox: &Path, entries: &mut [InboxEntry]) {
    let is_text = |one: &InboxEntry| {
        one.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("txt"))
            && is_part_entry(one)
            && !one.is_private_link
            && one.size <= MAX_LIST_BYTES
    };
    let mut folders: HashMap<&Path, (Vec<usize>, Vec<OsString>)> = HashMap::new();
    for (at, one) in entries.iter().enumerate().filter(|(_, one)| is_text(one)) {
        let texts = &mut folders.entry(one.path.parent().unwrap_or(Path::new(""))).or_default().0;
        if texts.len() < MAX_TEXTS_PER_FOLDER {
            texts.push(at);
        }
    }
    if folders.is_empty() {
        return;
    }
    for one in entries.iter().filter(|one| is_part_entry(one) && !is_text(one)) {
        if let (Some((_, names)), Some(name)) =
            (one.path.parent().and_then(|folder| folders.get_mut(folder)), one.path.file_name())
        {
            names.push(name.to_owned());
        }
    }
    let mut found = Vec::new();
    for (texts, names) in folders.values() {
        let names: Vec<&OsStr> = names.iter().map(OsString::as_os_str).collect();
        let names_part = |list: &InboxEntry| {
            !names.is_empty()
                && read_seen_list(list).is_ok_and(|bytes| OrderList::parse_for_files(&bytes, &names).names_any(&names))
        };
        let is_served = |list: &InboxEntry| ServedRows::load_marks(inbox, list).serving_files().next().is_some();
        found.extend(texts.iter().copied().filter(|&at| is_served(&entries[at]) || names_part(&entries[at])));
    }
    for at in found {
        entries[at].is_text_list = true;
    }
}

/// Reads a list, provided that it did not change since the scan.
pub(super) fn read_seen_list(list: &InboxEntry) -> io::Result<Vec<u8>> {
    let file = disk::open_regular_file(&list.path)?;
    let mut bytes = Vec::new();
    (&file).take(MAX_LIST_BYTES + 1).read_to_end(&mut bytes)?;
    match disk::is_unchanged(list, &file.metadata()?) {
        true => Ok(bytes),
        false => Err(io::Error::other("it is being written to")),
    }
}
