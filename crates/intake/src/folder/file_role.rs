//! What a file is for, judged by its name: a part, a ticket, or an order list.

use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// The name of an order list.
pub(crate) const LIST_NAME: &str = "order.csv";
/// File in a claim that holds what the order list says about its part. Its name begins with a dot, so it is never taken
/// from a hot folder.
pub(crate) const LIST_LOOKUP_NAME: &str = ".said.json";

/// Role of a file, judged by its name.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum FileRole {
    Part,
    /// `part` is the ticket's path without its extensions: the part, or its short name.
    Ticket {
        part: PathBuf,
    },
    List,
}

/// Suffix of the name of a file with the reason why nestd refused another one.
pub const REASON_SUFFIX: &str = ".reason.txt";

/// Whether a file is such a reason, by its name.
pub fn is_reason_file(path: &Path) -> bool {
    path.as_os_str().as_encoded_bytes().ends_with(REASON_SUFFIX.as_bytes())
}

/// Extensions of texts that people write beside a part as a ticket, and that nestd does not read as one.
const OTHER_TEXTS: [&str; 19] = [
    "txt", "text", "ini", "cfg", "conf", "yaml", "yml", "xml", "md", "rtf", "doc", "docx", "odt", "pages", "csv",
    "tsv", "tml", "json5", "jsonc",
];

/// Whether the name of a file ends in one of these extensions, in any case.
pub(crate) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|e| extensions.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// The path without the `.txt` that editors add to the name of a ticket or list, which Windows hides: `a.toml` for
/// `a.toml.txt`.
pub(crate) fn without_hidden_txt(path: &Path) -> Cow<'_, Path> {
    if !has_extension(path, &["txt"]) {
        return path.into();
    }
    let shown = path.with_extension("");
    if has_extension(&shown, &["toml", "json", "csv", "tsv"]) { shown.into() } else { path.into() }
}

/// Whether a file is by its name such a text.
pub(crate) fn is_other_text(path: &Path) -> bool {
    has_extension(path, &OTHER_TEXTS)
}

/// The part that a text may be meant for as a ticket, although nestd does not read it as one: `a.stl` for `a.stl.ini`, or a
/// short name.
pub(crate) fn part_of_other_text(path: &Path) -> Option<PathBuf> {
    let mut part = is_other_text(path).then(|| path.with_extension(""))?;
    while is_other_text(&part) {
        part = part.with_extension("");
    }
    Some(part)
}

/// Distinguishes parts, tickets and `order.csv`, ignoring case. In a hot folder, other files may be lists too, see
/// [`folder_lists`](crate::lists::folder_lists); a claim of such a file holds it as its part.
pub(crate) fn file_role(path: &Path) -> FileRole {
    let Some(name) = path.file_name() else { return FileRole::Part };
    if name.eq_ignore_ascii_case(LIST_NAME) || name == LIST_LOOKUP_NAME {
        return FileRole::List;
    }
    let shown = without_hidden_txt(path);
    match has_extension(&shown, &["toml", "json"]) {
        true => FileRole::Ticket { part: shown.with_extension("") },
        false => FileRole::Part,
    }
}
