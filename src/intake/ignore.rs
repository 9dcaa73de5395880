//! Names that are never parts: temporary files of copying programs, editors and browsers, and folders of operating
//! systems.

use std::ffi::OsStr;

/// Suffixes that copying programs and browsers add to incomplete files.
const SUFFIXES: [&str; 5] = [".tmp", ".partial", ".part", ".crdownload", ".filepart"];
/// Prefix of Office lock files. Dotfiles (`.~lock.`, `._` of macOS, `.DS_Store`, `.stfolder`, `.Trashes`) are always
/// ignored.
const PREFIXES: [&str; 1] = ["~$"];
/// Files and folders that operating systems and sync tools put into every folder.
const NAMES: [&str; 5] = ["desktop.ini", "thumbs.db", "@eadir", "__macosx", "lost+found"];

/// Whether a file or folder of this name is ignored, at any depth. Case does not matter, because Windows and macOS do
/// not distinguish `THUMBS.DB` from `Thumbs.db`.
pub fn is_ignored(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes().to_ascii_lowercase();
    name.starts_with(b".")
        || SUFFIXES.iter().any(|s| name.ends_with(s.as_bytes()))
        || PREFIXES.iter().any(|p| name.starts_with(p.as_bytes()))
        || NAMES.iter().any(|n| name == n.as_bytes())
}

/// Whether this is a status file that nestd itself writes into the top level of a hot folder.
pub(super) fn is_status_file(name: &OsStr) -> bool {
    name == super::status::TEXT_NAME || name == super::status::JSON_NAME
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_files_and_folders_of_systems_are_ignored_in_any_case() {
        for name in [
            "part.stl.tmp",
            "part.stl.TMP",
            "part.partial",
            "part.stl.part",
            "part.stl.crdownload",
            "part.stl.filepart",
            "~$list.xlsx",
            ".~lock.order.csv#",
            ".DS_Store",
            "._part.stl",
            "desktop.ini",
            "Desktop.ini",
            "Thumbs.db",
            "THUMBS.DB",
            ".hidden.stl",
            "@eaDir",
            ".stfolder",
            ".stversions",
            "__MACOSX",
            "lost+found",
            ".Trashes",
            ".claimed",
        ] {
            assert!(is_ignored(OsStr::new(name)), "{name}");
        }
    }

    #[test]
    fn parts_and_tickets_are_not_ignored() {
        for name in
            ["part.stl", "PART.3MF", "part", "tmp", "a~b.stl", "part.stl.toml", "order.csv", "x.part.stl", "partial"]
        {
            assert!(!is_ignored(OsStr::new(name)), "{name}");
        }
    }
}
