//! Names that are never parts: temporary files of copying programs, editors and browsers, and folders of operating
//! systems.

use std::ffi::OsStr;

/// Suffixes that copying programs, browsers and sync programs add to incomplete files (or folders: Safari's `x.stl.download`),
/// and editors to their backups.
const SUFFIXES: [&str; 39] = [
    ".tmp",
    ".temp",
    ".partial",
    ".part",
    ".crdownload",
    ".opdownload",
    ".download",
    ".downloading",
    ".filepart",
    ".upload",
    ".uploading",
    ".uploadpart",
    ".upload_part",
    ".incomplete",
    ".unfinished",
    ".inprogress",
    ".aria2",
    ".gstmp",
    ".driveupload",
    ".!sync",
    ".bts",
    ".!ut",
    ".!qb",
    "~",
    ".bak",
    ".bck",
    ".bkp",
    ".save",
    ".backup",
    ".old",
    ".orig",
    ".swp",
    ".autosave",
    ".pending",
    ".gdownload",
    ".mega",
    ".dtapart",
    ".bc!",
    ".icloud",
];
/// Prefixes of Office lock files, and of the snapshots of Samba, which are named by their time. Dotfiles (`.~lock.`, `._` of macOS, `.DS_Store`, `.stfolder`, `.Trashes`, `.snapshot`) are always
/// ignored.
const PREFIXES: [&str; 2] = ["~$", "@gmt-"];
/// Files and folders that operating systems, sync tools and network storage put into every folder: among them recycle bins and
/// snapshots, whose parts nobody has ordered.
const NAMES: [&str; 32] = [
    "desktop.ini",
    "thumbs.db",
    "__macosx",
    "lost+found",
    "system volume information",
    "$recycle.bin",
    "recycler",
    "recycled",
    "found.000",
    "#recycle",
    "@recycle",
    "@recycle_bin",
    "_recycle",
    "recycle.bin",
    "network trash folder",
    "temporary items",
    "thevolumesettingsfolder",
    "#snapshot",
    "~snapshot",
    "@snapshot",
    "@snapshots",
    "~tmp",
    "@synoresource",
    "@transfer",
    "@recently-snapshot",
    "@eadir",
    "@tmp",
    "@sharebin",
    "@syncignore",
    "@__thumb",
    "_gsdata_",
    "backups.backupdb",
];

/// Whether a file or folder of this name is ignored, at any depth. Case does not matter, because Windows and macOS do
/// not distinguish `THUMBS.DB` from `Thumbs.db`.
pub fn is_ignored(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes().to_ascii_lowercase();
    // Emacs saves `x.stl` as `#x.stl#` meanwhile.
    let is_autosave = name.len() > 2 && name.starts_with(b"#") && name.ends_with(b"#");
    name.starts_with(b".")
        || is_autosave
        || SUFFIXES.iter().any(|s| name.ends_with(s.as_bytes()))
        || PREFIXES.iter().any(|p| name.starts_with(p.as_bytes()))
        || NAMES.iter().any(|n| name == n.as_bytes())
}

/// Whether this is a status file that nestd itself writes into the top level of a hot folder.
pub(crate) fn is_status_file(name: &OsStr) -> bool {
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
            "#recycle",
            "$RECYCLE.BIN",
            "~snapshot",
            "@Recently-Snapshot",
            "System Volume Information",
            "part.stl~",
            "part.stl.BAK",
            "part.stl.old",
            "part.stl.!sync",
            "part.stl.uploading",
            "part.stl.opdownload",
            "part.stl.download",
            "#part.stl#",
            ".hidden.stl",
            "@eaDir",
            "@GMT-2026.01.01-12.00.00",
            "part.stl.bkp",
            ".stfolder",
            ".stversions",
            "__MACOSX",
            "lost+found",
            ".Trashes",
            "Backups.backupdb",
            ".claimed",
        ] {
            assert!(is_ignored(OsStr::new(name)), "{name}");
        }
    }

    #[test]
    fn parts_and_tickets_are_not_ignored() {
        for name in [
            "part.stl",
            "PART.3MF",
            "part",
            "tmp",
            "a~b.stl",
            "part.stl.toml",
            "order.csv",
            "x.part.stl",
            "partial",
            "#7.stl",
            "@a.stl",
        ] {
            assert!(!is_ignored(OsStr::new(name)), "{name}");
        }
    }
}
