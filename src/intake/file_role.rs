//! What a file is for, judged by its name: a part, a ticket, or an order list.

use std::path::{Path, PathBuf};

/// The name of an order list.
pub(super) const LIST_NAME: &str = "order.csv";
/// File in a claim that holds what the order list says about its part. Its name begins with a dot, so it is never taken
/// from a hot folder.
pub(super) const LIST_LOOKUP_NAME: &str = ".said.json";

/// Role of a file, judged by its name.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum FileRole {
    Part,
    /// `part` is the ticket's path without its extension: the part, or its short name.
    Ticket {
        part: PathBuf,
    },
    List,
}

/// Distinguishes parts, tickets and `order.csv`, ignoring case. In a hot folder, other files may be lists too, see
/// [`folder_lists`](super::folder_lists); a claim of such a file holds it as its part.
pub(super) fn file_role(path: &Path) -> FileRole {
    let Some(name) = path.file_name() else { return FileRole::Part };
    if name.eq_ignore_ascii_case(LIST_NAME) || name == LIST_LOOKUP_NAME {
        return FileRole::List;
    }
    let is_ticket = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml") || e.eq_ignore_ascii_case("json"));
    match is_ticket {
        true => FileRole::Ticket { part: path.with_extension("") },
        false => FileRole::Part,
    }
}
