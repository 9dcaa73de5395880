//! Which file of a folder is its order list. People save lists under many names, and browsers number a second download, so
//! the only list of a folder counts whatever its name. Where there are several, or only a spreadsheet, the parts beside
//! them wait: otherwise they would be printed once, although a number of copies was written down.

use std::{
    collections::{HashMap, HashSet},
    ffi::OsStr,
    io::{self, Read},
    path::Path,
};

use super::{
    order_list::{MAX_LIST_BYTES, OrderList},
    served_rows::ServedRows,
};
use crate::{
    EntryKind, FoundList, InboxEntry, display_name,
    folder::{
        disk,
        file_role::{FileRole, LIST_NAME, file_role, has_extension, is_reason_file, without_hidden_txt},
        inbox_entry::{is_hidden, unreadable_reason},
    },
    names::{code_page::decode_candidates, name::is_part_name, name_match::fold_name},
};

/// Workbooks that are read.
pub(crate) const WORKBOOKS: [&str; 2] = ["xlsx", "xlsm"];
/// Spreadsheets that are not.
const SPREADSHEETS: [&str; 4] = ["xlsb", "xls", "ods", "numbers"];
/// Texts of other programs that may say how many are wanted of the parts beside them.
const FOREIGN_TEXTS: [&str; 5] = ["json", "toml", "yaml", "yml", "xml"];
/// Texts of people that may say the same.
const NOTES: [&str; 8] = ["txt", "md", "markdown", "eml", "htm", "html", "rtf", "log"];
/// Documents, links and other forms of lists that are not read either, and say how many are wanted if called so.
const DOCUMENTS: [&str; 20] = [
    "doc", "docx", "odt", "rtf", "pages", "pdf", "eml", "msg", "htm", "html", "mht", "tab", "prn", "dbf", "gz",
    "gsheet", "lnk", "url", "webloc", "desktop",
];
/// Pictures, drawings and films that come with parts.
const PICTURES: [&str; 15] =
    ["png", "jpg", "jpeg", "gif", "bmp", "webp", "tif", "tiff", "heic", "heif", "avif", "svg", "dxf", "dwg", "mp4"];
/// Starts of the names of texts and documents that say how many are wanted.
const LIST_STARTS: [&str; 26] = [
    "order",
    "ticket",
    "quantit",
    "qty",
    "copies",
    "bom",
    "parts list",
    "partslist",
    "parts_list",
    "parts-list",
    "purchase order",
    "purchase_order",
    "bestell",
    "auftrag",
    "stückliste",
    "stueckliste",
    "mengen",
    "anzahl",
    "commande",
    "quantité",
    "pedido",
    "ordine",
    "注文",
    "発注",
    "数量",
    "订单",
];
/// No more text files of one folder are read by each scan.
const MAX_TEXTS_PER_FOLDER: usize = 16;

/// A file that may say how many copies are ordered of the parts beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ListFormat {
    /// An `order.csv`, in any letter case.
    OrderCsv,
    /// Another list that nestd can read.
    OtherText,
    /// A workbook. It counts where no text does: people save their list as text, and leave the workbook beside it.
    Workbook,
    /// A spreadsheet or another program's list, which nestd does not read.
    Foreign,
    /// A link, a folder or another thing in place of a list.
    Unreadable,
}

/// Recognises lists by name. Text files need a look at their content too, see [`mark_lists`].
pub(crate) fn list_format(path: &Path) -> Option<ListFormat> {
    let name = path.file_name()?;
    if name.eq_ignore_ascii_case(LIST_NAME) {
        return Some(ListFormat::OrderCsv);
    }
    match without_hidden_txt(path).as_ref() {
        path if has_extension(path, &["csv", "tsv"]) => Some(ListFormat::OtherText),
        path if has_extension(path, &["txt"]) && has_list_start(path) => Some(ListFormat::OtherText),
        path if has_extension(path, &DOCUMENTS) && has_list_start(path) => Some(ListFormat::Foreign),
        path if has_extension(path, &WORKBOOKS) => Some(ListFormat::Workbook),
        path if has_extension(path, &SPREADSHEETS) => Some(ListFormat::Foreign),
        _ => None,
    }
}

/// Whether a name begins like that of an order list.
fn has_list_start(path: &Path) -> bool {
    let name = fold_name(&path.file_name().unwrap_or_default().to_string_lossy());
    let name = name.strip_prefix('.').unwrap_or(&name);
    LIST_STARTS.iter().any(|start| name.starts_with(start))
}

/// The format of an entry that is a list.
pub(crate) fn entry_list_format(seen: &InboxEntry) -> Option<ListFormat> {
    let format = match (list_format(&seen.path), seen.found_list) {
        (None, FoundList::None) | (_, FoundList::OfPart) => return None,
        (None, FoundList::Readable) => ListFormat::OtherText,
        (None, FoundList::Foreign) => ListFormat::Foreign,
        (Some(format), _) => format,
    };
    Some(if unreadable_reason(seen).is_some() { ListFormat::Unreadable } else { format })
}

/// Whether an entry is a part, as far as its name tells.
pub(crate) fn is_part_entry(seen: &InboxEntry) -> bool {
    seen.kind == EntryKind::File && entry_list_format(seen).is_none() && file_role(&seen.path) == FileRole::Part
}

/// The lists of one folder.
#[derive(Debug, Default)]
pub(crate) struct FolderLists<'a> {
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
        let mut orders = of(ListFormat::OrderCsv).peekable();
        let mut others: Vec<&InboxEntry> = of(ListFormat::OtherText).collect();
        let mut beside: Vec<&InboxEntry> = of(ListFormat::Workbook).collect();
        if orders.peek().is_none() && others.is_empty() {
            std::mem::swap(&mut others, &mut beside);
        }
        beside.extend(of(ListFormat::Foreign));
        let mut chosen = match (orders.next(), &others[..]) {
            (None, &[only]) => Self { list: Some(only), rivals: Vec::new(), surplus: beside },
            (None, _) => Self { list: None, rivals: others.into_iter().chain(beside).collect(), surplus: Vec::new() },
            (list, _) => Self { list, rivals: others, surplus: orders.chain(beside).collect() },
        };
        // Beside a list that counts, a hidden one is what a program has left.
        let has_list = chosen.list.is_some();
        chosen.rivals.extend(of(ListFormat::Unreadable).filter(|one| !has_list || !is_hidden(one)));
        chosen
    }

    /// What the parts beside the rivals wait for (part of a sentence that names the part first).
    pub fn rival_reason(&self) -> Option<String> {
        let of = |wanted| self.rivals.iter().copied().filter(move |one| entry_list_format(one) == Some(wanted));
        if let Some(unreadable) = of(ListFormat::Unreadable).next() {
            let why = unreadable_reason(unreadable).unwrap_or_default();
            return Some(format!("{}, which {why}", shown_name(unreadable)));
        }
        let texts: Vec<&InboxEntry> = self.rivals.iter().copied().filter(|one| !is_foreign(one)).collect();
        match (texts.is_empty(), of(ListFormat::Foreign).next()) {
            (true, None) => None,
            (true, Some(foreign)) => Some(format!(
                "{}, {}, which nestd does not read: {}",
                shown_name(foreign),
                foreign_kind(foreign),
                if is_no_table(&foreign.path) { WRITE_LIST } else { "save it as XLSX or CSV" }
            )),
            (false, _) => {
                let names: Vec<String> = texts.into_iter().chain(self.list).map(shown_name).collect();
                Some(format!("{}: put all rows into one list", names.join(" and ")))
            }
        }
    }
}

/// What helps where a text cannot be saved as a table.
const WRITE_LIST: &str = "write the files and their numbers into a list (CSV or XLSX) in its place";

/// Whether a list is no table, so that a program cannot save it as one.
fn is_no_table(path: &Path) -> bool {
    has_extension(path, &NOTES) || has_extension(path, &DOCUMENTS) && !has_extension(path, &["tab", "prn", "dbf"])
}

/// Whether a file of this name is a document or a picture, which comes with parts and is none. A packed file or a link may stand for a part.
pub fn is_document(name: &str) -> bool {
    let is = |extensions: &[&str]| has_extension(Path::new(name), extensions);
    is(&PICTURES) || is_no_table(Path::new(name)) && !is(&["gz", "lnk", "url", "webloc", "desktop"])
}

/// What a list that nestd does not read is.
fn foreign_kind(foreign: &InboxEntry) -> &'static str {
    match &foreign.path {
        path if has_extension(path, &SPREADSHEETS) => "a spreadsheet",
        path if is_no_table(path) => "a document",
        _ => "a list of another program",
    }
}

/// Why a list that does not count is refused, in whole sentences.
pub(crate) fn rival_refusal(rival: &InboxEntry, reason: &str) -> String {
    match unreadable_reason(rival) {
        Some(why) => {
            format!("{} {why}. Drop it together with the parts that were refused because of it.", shown_name(rival))
        }
        None if is_foreign(rival) && is_no_table(&rival.path) => {
            "This is a document that may say how many are wanted, and nestd does not read it. Write the files and their numbers into \
             a list (CSV or XLSX), and drop that together with the parts."
                .to_owned()
        }
        None if is_foreign(rival) => format!(
            "This is {}, which nestd does not read. Save it as XLSX or CSV, and drop that together with the parts.",
            foreign_kind(rival)
        ),
        None => format!(
            "A folder has one order list, but in this one there were {reason}. Drop that list together with the parts that \
             were refused."
        ),
    }
}

/// Why a list that changes nothing is refused, in whole sentences.
pub(crate) fn surplus_refusal(surplus: &InboxEntry, list: Option<&InboxEntry>) -> String {
    let shown_list = || list.map_or_else(|| LIST_NAME.to_owned(), shown_name);
    match entry_list_format(surplus) {
        Some(ListFormat::Workbook) => format!(
            "This is a workbook beside the list {}, which the parts go by. Nothing needs to be done, unless the workbook says \
             something else: then drop one of the two.",
            shown_list()
        ),
        Some(ListFormat::Foreign) => format!(
            "This is {}, which nestd does not read; the parts beside it go by {}. Nothing needs to be done, unless \
             it says something else: then save it as CSV under that name.",
            foreign_kind(surplus),
            shown_list()
        ),
        _ => "This folder has another order.csv, in other upper or lower case. Put all rows into one list.".to_owned(),
    }
}

/// Whether an entry is a list that nestd does not read.
pub(crate) fn is_foreign(seen: &InboxEntry) -> bool {
    entry_list_format(seen) == Some(ListFormat::Foreign)
}

/// The display name of an entry without its folder.
pub(crate) fn shown_name(seen: &InboxEntry) -> String {
    display_name(seen.path.file_name().unwrap_or_default())
}

/// Marks the files whose content is a list beside parts, although their names do not say so: texts with rows that name a file
/// beside them (or one that they were served to), and files of other programs that are called `order` or name a file beside them.
pub(crate) fn mark_lists(inbox: &Path, entries: &mut [InboxEntry]) {
    let mut folders: HashMap<&Path, (Vec<usize>, Vec<&OsStr>)> = HashMap::new();
    for (at, one) in entries.iter().enumerate().filter(|(_, one)| may_be_list(one)) {
        folders.entry(one.path.parent().unwrap_or(Path::new(""))).or_default().0.push(at);
    }
    if folders.is_empty() {
        return;
    }
    for one in entries.iter().filter(|one| is_part_entry(one) && !may_be_list(one)) {
        if let (Some((_, names)), Some(name)) =
            (one.path.parent().and_then(|folder| folders.get_mut(folder)), one.path.file_name())
        {
            names.push(name);
        }
    }
    let mut found = Vec::new();
    for (texts, names) in folders.into_values() {
        let parts = FolderParts::new(names);
        let texts = texts.into_iter().filter(|&at| !parts.has_part_of(&entries[at].path));
        found.extend(texts.take(MAX_TEXTS_PER_FOLDER).map(|at| (at, parts.found_list(inbox, &entries[at]))));
    }
    for (at, list) in found {
        entries[at].found_list = list;
    }
}

/// Whether the content of an entry tells whether it is a list.
fn may_be_list(seen: &InboxEntry) -> bool {
    match has_extension(&seen.path, &FOREIGN_TEXTS) {
        _ if is_hidden(seen) => false,
        // What nestd itself wrote beside a refused part comes back with it.
        _ if is_reason_file(&seen.path) => false,
        _ if part_of_table(&seen.path).is_some() => true,
        true => list_format(&seen.path).is_none(),
        false => has_extension(&seen.path, &NOTES) && is_part_entry(seen) && unreadable_reason(seen).is_none(),
    }
}

/// The name of the part that a table is called after: `part.stl` for `part.stl.csv`.
fn part_of_table(path: &Path) -> Option<String> {
    let shown = without_hidden_txt(path);
    let part = has_extension(&shown, &["csv", "tsv"]).then(|| shown.file_stem())??;
    is_part_name(part).then(|| fold_name(&part.to_string_lossy()))
}

/// The parts of one folder.
struct FolderParts<'a> {
    names: Vec<&'a OsStr>,
    /// The same, folded.
    folded: Vec<String>,
    /// Their folded names without extension.
    stems: HashSet<String>,
}

impl<'a> FolderParts<'a> {
    fn new(names: Vec<&'a OsStr>) -> Self {
        let folded: Vec<String> = names.iter().map(|name| fold_name(&name.to_string_lossy())).collect();
        let stem = |name: &String| name.rsplit_once('.').map(|(stem, _)| stem.to_owned());
        let stems = folded.iter().filter_map(stem).collect();
        Self { names, folded, stems }
    }

    /// Whether a file of another program has the name of a ticket: of one of these parts, or of one that comes later.
    fn has_part_of(&self, text: &Path) -> bool {
        let named = text.file_stem().unwrap_or_default();
        has_extension(text, &FOREIGN_TEXTS)
            && (is_part_name(named) || self.stems.contains(&fold_name(&named.to_string_lossy())))
    }

    /// What the content of a text says of the parts.
    fn found_list(&self, inbox: &Path, text: &InboxEntry) -> FoundList {
        if has_extension(&text.path, &FOREIGN_TEXTS) {
            let may_be_late_ticket = self.names.is_empty() && has_extension(&text.path, &["json", "toml"]);
            let is_list = has_list_start(&text.path) && !may_be_late_ticket || self.is_told_by(text);
            return if is_list { FoundList::Foreign } else { FoundList::None };
        }
        let names_part = || {
            has_extension(&text.path, &["txt", "csv", "tsv"])
                && !self.names.is_empty()
                && text.size <= MAX_LIST_BYTES
                && read_seen_list(text)
                    .is_ok_and(|bytes| OrderList::parse_for_files(&bytes, &self.names).names_any(&self.names))
        };
        let is_beside = |part: String| self.folded.contains(&part);
        let is_served = || ServedRows::load_marks(inbox, text).serving_files().next().is_some();
        match is_served() || names_part() {
            true => FoundList::Readable,
            false if has_extension(&text.path, &NOTES) && self.is_told_by(text) => FoundList::Foreign,
            false if part_of_table(&text.path).is_some_and(is_beside) => FoundList::OfPart,
            false => FoundList::None,
        }
    }

    /// Whether a file of another program names one of the parts, or holds more than a ticket does.
    fn is_told_by(&self, text: &InboxEntry) -> bool {
        if unreadable_reason(text).is_some() || text.size > MAX_LIST_BYTES {
            return false;
        }
        let bytes = read_seen_list(text).unwrap_or_default();
        let json = serde_json::from_slice::<serde_json::Value>(&bytes).ok();
        // JSON may escape the letters of a name.
        let text = || decode_candidates(&bytes).into_iter().next().map_or_else(String::new, |reading| reading.text);
        let content = fold_name(&json.as_ref().map_or_else(text, ToString::to_string));
        let is_named = |part: &String| {
            // `b.stl` does not stand in `lib.stl`.
            let is_start = |before: &str| !before.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '-'));
            content.match_indices(part.as_str()).any(|(at, _)| is_start(&content[..at]))
        };
        json.is_some_and(|json| is_nested(&json)) || self.folded.iter().any(is_named)
    }
}

/// Whether a value holds lists or objects, as no ticket does beside its directions.
fn is_nested(json: &serde_json::Value) -> bool {
    let Some(fields) = json.as_object() else { return json.is_array() };
    let is_direction = |key: &str| matches!(key, "keep_up" | "not_down");
    fields.iter().any(|(key, value)| !is_direction(key) && (value.is_array() || value.is_object()))
}

/// Reads a list, provided that it did not change since the scan.
pub(crate) fn read_seen_list(list: &InboxEntry) -> io::Result<Vec<u8>> {
    let file = disk::open_regular_file(&list.path)?;
    let mut bytes = Vec::new();
    (&file).take(MAX_LIST_BYTES + 1).read_to_end(&mut bytes)?;
    match disk::is_unchanged(list, &file.metadata()?) {
        true => Ok(bytes),
        false => Err(io::Error::other("it is being written to")),
    }
}
