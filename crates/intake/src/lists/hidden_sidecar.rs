//! Tickets and lists whose names begin with a dot. nestd does not read them, and no part is printed without what they may say.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
};

use super::folder_lists::list_format;
use crate::folder::file_role::{FileRole, file_role};

/// The path of a hidden ticket or list without the dot: `part.toml` for `.part.toml`. What macOS and office programs hide begins with
/// two signs, and editors add endings of their own.
pub(crate) fn shown_sidecar(path: &Path) -> Option<PathBuf> {
    let shown = path.file_name()?.to_str()?.strip_prefix('.').filter(|shown| !shown.starts_with(['.', '_', '~']))?;
    let shown = path.with_file_name(shown);
    let is_sidecar = matches!(file_role(&shown), FileRole::Ticket { .. }) || list_format(&shown).is_some();
    is_sidecar.then_some(shown)
}

/// Whether this is the name of a hidden ticket or list.
pub(crate) fn is_hidden_sidecar(name: &OsStr) -> bool {
    shown_sidecar(name.as_ref()).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_tickets_and_lists_are_told_from_what_programs_hide() {
        for (name, is_hidden) in [
            (".part.stl.toml", true),
            (".part.3mf.JSON", true),
            (".part.stl.toml.txt", true),
            (".part.toml", true),
            (".order.csv", true),
            (".Order.CSV.txt", true),
            (".bom.tsv", true),
            (".order.txt", true),
            (".list.xlsx", true),
            ("._part.stl.toml", false),
            ("._part.toml", false),
            ("._order.csv", false),
            (".~part.stl.toml", false),
            (".~lock.order.csv#", false),
            ("~$list.xlsx", false),
            (".part.stl", false),
            ("part.stl.toml", false),
            (".part.stl.toml.swp", false),
            ("part.stl.toml.bak", false),
            (".order.csv~", false),
            (".DS_Store", false),
            (".nestd-lease", false),
        ] {
            assert_eq!(is_hidden_sidecar(OsStr::new(name)), is_hidden, "{name}");
        }
    }
}
