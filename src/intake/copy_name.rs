//! Names that programs give to a second version of a file: conflict copies of sync programs, copies of file managers.

use super::{copies_words::is_digits, name::is_part_name, name_match::fold_name};

/// A name that a program made of another file's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CopyName {
    /// The name of the file that it is a copy of.
    pub original: String,
    /// Whether it is certainly the copy of a sync program that found two versions. Otherwise it is one if its original is
    /// there too.
    pub is_conflict: bool,
}

/// Words in the brackets that sync programs add where they found two versions: Dropbox, Nextcloud, ownCloud, Seafile, Box,
/// Google Drive and others, in their languages.
const CONFLICT_WORDS: [&str; 14] = [
    "conflict",
    "konflikt",
    "in konflikt",
    "conflit",
    "en conflit",
    "conflicto",
    "conflitto",
    "conflito",
    "競合",
    "冲突",
    "衝突",
    "충돌",
    "конфликт",
    "ristiriita",
];
/// What file managers add behind a name, before a number in brackets.
const COPY_ENDINGS: [&str; 18] = [
    " - copy",
    " - kopie",
    " - copie",
    " - copia",
    " - cópia",
    " - kopia",
    " - kopi",
    " - コピー",
    " - 副本",
    " - 복사본",
    " copy",
    " kopie",
    " copie",
    " copia",
    "のコピー",
    " のコピー",
    " (copy)",
    " (kopie)",
];
/// What file managers put before a name.
const COPY_STARTS: [&str; 6] = ["copy of ", "kopie von ", "copie de ", "copia de ", "copia di ", "コピー ~ "];
/// Starts of the names that Windows gives to computers, which OneDrive adds behind a hyphen.
const COMPUTERS: [&str; 4] = ["desktop", "laptop", "win", "pc"];
/// Length of the second half of such a name.
const COMPUTER_LETTERS: std::ops::RangeInclusive<usize> = 5..=11;

/// What a file name is a copy of, if a program made it of another one's.
pub fn read_copy_name(name: &str) -> Option<CopyName> {
    let (stem, extension) = name.rsplit_once('.').filter(|_| is_part_name(name.as_ref()))?;
    let copy = |stem: &str, is_conflict| CopyName { original: format!("{}.{extension}", stem.trim_end()), is_conflict };
    if let Some(stem) = conflict_original(stem) {
        return Some(copy(stem, true));
    }
    let stem = stem.trim_end();
    let numbered = without_number(stem);
    let bare = numbered.unwrap_or(stem);
    let ending = COPY_ENDINGS.iter().find_map(|ending| without_ending(bare, ending));
    let start = || COPY_STARTS.iter().find_map(|start| without_start(bare, start));
    let original = ending.or_else(start).or(numbered).or_else(|| without_computer(stem))?;
    (!original.trim().is_empty()).then(|| copy(original, false))
}

/// The stem of a name before what a sync program added.
fn conflict_original(stem: &str) -> Option<&str> {
    // Syncthing: `x.sync-conflict-20260101-120000-ABCDEFG`; ownCloud: `x_conflict-20260101-120000`; Resilio: `x.Conflict`.
    let lower = stem.to_ascii_lowercase();
    for mark in [".sync-conflict-", "_conflict-", ".conflict"] {
        let found =
            lower.rfind(mark).filter(|at| *at > 0 && (mark == ".conflict" || has_date(&lower[at + mark.len()..])));
        if let Some(at) = found {
            return Some(&stem[..at]);
        }
    }
    let (before, inside) = stem.trim_end().strip_suffix([')', ']'])?.rsplit_once(['(', '['])?;
    let inside = fold_name(inside);
    let is_conflict = CONFLICT_WORDS.iter().any(|word| inside.contains(word));
    (is_conflict && !before.trim().is_empty()).then_some(before)
}

/// Whether a text begins with a date as sync programs write it: `20260101-`.
fn has_date(text: &str) -> bool {
    text.len() >= 8 && text.bytes().take(8).all(|byte| byte.is_ascii_digit())
}

/// `x` of `x (2)`.
fn without_number(stem: &str) -> Option<&str> {
    let (before, number) = stem.strip_suffix(')')?.rsplit_once('(')?;
    (is_digits(number) && number.len() < 4 && !before.trim().is_empty()).then(|| before.trim_end())
}

fn without_ending<'a>(stem: &'a str, ending: &str) -> Option<&'a str> {
    let at = stem.len().checked_sub(ending.len())?;
    (stem.is_char_boundary(at) && fold_name(&stem[at..]) == ending).then(|| &stem[..at])
}

fn without_start<'a>(stem: &'a str, start: &str) -> Option<&'a str> {
    (stem.is_char_boundary(start.len()) && fold_name(stem.get(..start.len())?) == start).then(|| &stem[start.len()..])
}

/// `x` of `x-DESKTOP-ABC123`, with the name of a Windows computer.
fn without_computer(stem: &str) -> Option<&str> {
    let (before, letters) = stem.rsplit_once('-')?;
    let (original, computer) = before.rsplit_once('-')?;
    let is_name = COMPUTER_LETTERS.contains(&letters.len()) && letters.bytes().all(|byte| byte.is_ascii_alphanumeric());
    let is_computer = COMPUTERS.iter().any(|start| computer.eq_ignore_ascii_case(start));
    (is_name && is_computer && !original.is_empty()).then_some(original)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_of_sync_programs_and_file_managers_name_their_original() {
        for (name, is_conflict) in [
            ("x.sync-conflict-20260101-120000-ABCDEFG.stl", true),
            ("x (conflicted copy 2026-01-01 120000).stl", true),
            ("x (Anna's conflicted copy 2026-01-01).stl", true),
            ("x (In Konflikt stehende Kopie von Jörg 2026-01-01).stl", true),
            ("x (Copie en conflit de Zoé 2026-01-01).stl", true),
            ("x (田中の競合コピー 2026-01-01).stl", true),
            ("x (SFConflict anna@example.org 2026-01-01-12-00-00).stl", true),
            ("x_conflict-20260101-120000.stl", true),
            ("x.Conflict.stl", true),
            ("x [conflicted].stl", true),
            ("x (1).stl", false),
            ("x(1).stl", false),
            ("x - Copy.stl", false),
            ("x - Copy (2).stl", false),
            ("x - Kopie.stl", false),
            ("x - コピー.stl", false),
            ("x copy.stl", false),
            ("xのコピー.stl", false),
            ("Copy of x.stl", false),
            ("Kopie von x.stl", false),
            ("x-DESKTOP-ABC123.stl", false),
            ("x-LAPTOP-7F3K2Q9A.stl", false),
        ] {
            let expected = CopyName { original: "x.stl".to_owned(), is_conflict };
            assert_eq!(read_copy_name(name), Some(expected), "{name}");
        }
    }

    #[test]
    fn names_of_people_are_no_copies() {
        for name in [
            "x.stl",
            "hardcopy.stl",
            "copyholder.stl",
            "bracket (left).stl",
            "bracket (v2).stl",
            "(1).stl",
            "conflict.stl",
            "resolver_conflict-free.stl",
            "desk-top-plate.stl",
            "mount-PC-2.stl",
            "plate-win-x.stl",
            "photocopie.3mf",
            "part (2026).stl",
            "x (1)",
        ] {
            assert_eq!(read_copy_name(name), None, "{name}");
        }
    }
}
