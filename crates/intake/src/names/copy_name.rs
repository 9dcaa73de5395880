//! Names that programs and people give to a second version of a file: conflict copies of sync programs, copies of file managers,
//! backups.

use super::{
    copies_words::is_digits,
    name::is_part_name,
    name_match::fold_name,
    old_words::{BACKUP, PAST},
};

/// How sure it is that a name is that of a copy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CopyKind {
    /// A sync program found two versions.
    Conflict,
    /// A backup, or what a program keeps of the file before.
    Backup,
    /// A copy if its original is there too.
    BesideOriginal,
}

/// A name that was made of another file's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CopyName {
    /// The name of the file that it is a copy of.
    pub original: String,
    /// What kind of copy it is.
    pub kind: CopyKind,
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
/// Words for a copy, behind a name and a sign, in brackets, or before a sign and a name.
const COPY_WORDS: [&str; 18] = [
    "copy",
    "kopie",
    "copie",
    "copia",
    "cópia",
    "kopia",
    "kopi",
    "コピー",
    "副本",
    "복사본",
    "копия",
    "копія",
    "kopya",
    "kopio",
    "másolat",
    "kópia",
    "kopija",
    "αντίγραφο",
];
/// The same without a sign.
const JOINED_COPY: &str = "のコピー";
/// What programs call the file that was there before.
const PROGRAM_BACKUPS: [&str; 4] = ["orig", "sav", "tmp", "autosave"];
/// Signs between such a word and the name.
const WORD_SIGNS: [char; 6] = ['.', '-', '_', ' ', '–', '—'];
/// What file managers put before a name.
const COPY_STARTS: [&str; 9] = [
    "copy of ",
    "copy (2) of ",
    "copy (3) of ",
    "kopie von ",
    "copie de ",
    "copia de ",
    "copia di ",
    "コピー ~ ",
    "コピー ～ ",
];
/// Starts of the names that Windows gives to computers, which OneDrive adds behind a hyphen.
const COMPUTERS: [&str; 4] = ["desktop", "laptop", "win", "pc"];
/// Length of the second half of such a name.
const COMPUTER_LETTERS: std::ops::RangeInclusive<usize> = 5..=11;

/// What a file name is a copy of, if a program made it of another one's.
pub fn read_copy_name(name: &str) -> Option<CopyName> {
    // `x.stl.1`: programs number what was there before.
    if let Some((original, _)) =
        name.rsplit_once('.').filter(|(part, n)| is_part_name(part.as_ref()) && is_copy_number(n))
    {
        return Some(CopyName { original: original.to_owned(), kind: CopyKind::Backup });
    }
    let (stem, extension) = name.rsplit_once('.').filter(|_| is_part_name(name.as_ref()))?;
    let copy = |stem: &str, kind| CopyName { original: format!("{}.{extension}", stem.trim_end()), kind };
    if let Some(stem) = conflict_original(stem) {
        return Some(copy(stem, CopyKind::Conflict));
    }
    let stem = stem.trim_end();
    let backup = without_word(stem, &BACKUP).or_else(|| without_word(stem, &PROGRAM_BACKUPS));
    if let Some(stem) = backup.or_else(|| without_tilde_number(stem)) {
        return Some(copy(stem, CopyKind::Backup));
    }
    let numbered = without_number(stem);
    let bare = numbered.unwrap_or(stem);
    let bare = without_blank_number(bare).unwrap_or(bare);
    let ending = without_word(bare, &COPY_WORDS).or_else(|| without_ending(bare, JOINED_COPY));
    let start = || COPY_STARTS.iter().find_map(|start| without_start(bare, start));
    let told = ending.or_else(|| without_bracketed_word(bare)).or_else(start).or(numbered);
    let told = told.or_else(|| without_computer(stem)).or_else(|| without_word(stem, &PAST));
    let first = || [&COPY_WORDS[..], &BACKUP, &PAST].into_iter().find_map(|words| without_first_word(bare, words));
    let original = told.or_else(first).or_else(|| without_low_number(stem))?;
    (!original.trim().is_empty()).then(|| copy(original, CopyKind::BesideOriginal))
}

fn is_copy_number(number: &str) -> bool {
    is_digits(number) && number.len() < 4
}

/// `x` of `x.bak`, `x_backup` and `x - old`.
fn without_word<'a>(stem: &'a str, words: &[&str]) -> Option<&'a str> {
    let before = words.iter().find_map(|word| without_ending(stem, word))?;
    let original = before.trim_end_matches(WORD_SIGNS);
    (original.len() < before.len() && !original.is_empty()).then_some(original)
}

/// `x` of `kopia_x` and `old - x`.
fn without_first_word<'a>(stem: &'a str, words: &[&str]) -> Option<&'a str> {
    let behind = |word: &&str| {
        let behind = without_start(stem, word)?;
        let original = behind.trim_start_matches(WORD_SIGNS);
        (original.len() < behind.len()).then_some(original)
    };
    words.iter().find_map(behind)
}

/// `x` of `x (copy)` and `x (3rd copy)`.
fn without_bracketed_word(stem: &str) -> Option<&str> {
    let (before, inside) = stem.strip_suffix(')')?.rsplit_once('(')?;
    let inside = fold_name(inside);
    COPY_WORDS.contains(&inside.rsplit(' ').next().unwrap_or_default()).then(|| before.trim_end())
}

/// `x copy` of `x copy 2`, as macOS numbers.
fn without_blank_number(stem: &str) -> Option<&str> {
    let (before, number) = stem.rsplit_once(' ')?;
    (is_copy_number(number) && without_word(before, &COPY_WORDS).is_some()).then_some(before)
}

/// `x` of `x~1`, and of `x~20260101-120000`, as Syncthing keeps versions.
fn without_tilde_number(stem: &str) -> Option<&str> {
    let (original, number) = stem.rsplit_once('~')?;
    let is_date = || has_date(number) && number.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-');
    ((is_copy_number(number) || is_date()) && !original.trim().is_empty()).then_some(original)
}

/// `x` of `x_1`, as browsers and CAD programs number a second file.
fn without_low_number(stem: &str) -> Option<&str> {
    let (original, number) = stem.rsplit_once('_')?;
    (number.len() == 1 && is_digits(number) && number != "0").then_some(original)
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
    (is_copy_number(number) && !before.trim().is_empty()).then(|| before.trim_end())
}

fn without_ending<'a>(stem: &'a str, ending: &str) -> Option<&'a str> {
    let (at, _) = stem.char_indices().nth_back(ending.chars().count().checked_sub(1)?)?;
    (fold_name(&stem[at..]) == ending).then(|| &stem[..at])
}

fn without_start<'a>(stem: &'a str, start: &str) -> Option<&'a str> {
    let (at, _) = stem.char_indices().nth(start.chars().count())?;
    (fold_name(&stem[..at]) == start).then(|| &stem[at..])
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
        for (name, kind) in [
            ("x.sync-conflict-20260101-120000-ABCDEFG.stl", CopyKind::Conflict),
            ("x (conflicted copy 2026-01-01 120000).stl", CopyKind::Conflict),
            ("x (Anna's conflicted copy 2026-01-01).stl", CopyKind::Conflict),
            ("x (In Konflikt stehende Kopie von Jörg 2026-01-01).stl", CopyKind::Conflict),
            ("x (Copie en conflit de Zoé 2026-01-01).stl", CopyKind::Conflict),
            ("x (田中の競合コピー 2026-01-01).stl", CopyKind::Conflict),
            ("x (SFConflict anna@example.org 2026-01-01-12-00-00).stl", CopyKind::Conflict),
            ("x_conflict-20260101-120000.stl", CopyKind::Conflict),
            ("x.Conflict.stl", CopyKind::Conflict),
            ("x [conflicted].stl", CopyKind::Conflict),
            ("x (1).stl", CopyKind::BesideOriginal),
            ("x(1).stl", CopyKind::BesideOriginal),
            ("x - Copy.stl", CopyKind::BesideOriginal),
            ("x - Copy (2).stl", CopyKind::BesideOriginal),
            ("x - Kopie.stl", CopyKind::BesideOriginal),
            ("x - コピー.stl", CopyKind::BesideOriginal),
            ("x copy.stl", CopyKind::BesideOriginal),
            ("xのコピー.stl", CopyKind::BesideOriginal),
            ("x-copia.stl", CopyKind::BesideOriginal),
            ("x.copy.stl", CopyKind::BesideOriginal),
            ("x (Copy).stl", CopyKind::BesideOriginal),
            ("x (Kopie) (2).stl", CopyKind::BesideOriginal),
            ("x_kopia.stl", CopyKind::BesideOriginal),
            ("x copy 2.stl", CopyKind::BesideOriginal),
            ("x — копия.stl", CopyKind::BesideOriginal),
            ("x – kopie.stl", CopyKind::BesideOriginal),
            ("x (another copy).stl", CopyKind::BesideOriginal),
            ("x (3rd copy).stl", CopyKind::BesideOriginal),
            ("Copy (2) of x.stl", CopyKind::BesideOriginal),
            ("x - Kopya.stl", CopyKind::BesideOriginal),
            ("kopia_x.stl", CopyKind::BesideOriginal),
            ("Kopie x.stl", CopyKind::BesideOriginal),
            ("old_x.stl", CopyKind::BesideOriginal),
            ("Sicherung - x.stl", CopyKind::BesideOriginal),
            ("x old version.stl", CopyKind::BesideOriginal),
            ("x_antigua.stl", CopyKind::BesideOriginal),
            ("x-Sicherungen.stl", CopyKind::Backup),
            ("コピー ～ x.stl", CopyKind::BesideOriginal),
            ("Copy of x.stl", CopyKind::BesideOriginal),
            ("Kopie von x.stl", CopyKind::BesideOriginal),
            ("x-DESKTOP-ABC123.stl", CopyKind::BesideOriginal),
            ("x-LAPTOP-7F3K2Q9A.stl", CopyKind::BesideOriginal),
            ("x_1.stl", CopyKind::BesideOriginal),
            ("x_old.stl", CopyKind::BesideOriginal),
            ("x - alt.stl", CopyKind::BesideOriginal),
            ("x_旧.stl", CopyKind::BesideOriginal),
            ("x.stl.1", CopyKind::Backup),
            ("x.stl.12", CopyKind::Backup),
            ("x.bak.stl", CopyKind::Backup),
            ("x-backup.stl", CopyKind::Backup),
            ("x_Sicherung.stl", CopyKind::Backup),
            ("x - copia de seguridad.stl", CopyKind::Backup),
            ("x.orig.stl", CopyKind::Backup),
            ("x~1.stl", CopyKind::Backup),
            ("x~20260101-120000.stl", CopyKind::Backup),
        ] {
            let expected = CopyName { original: "x.stl".to_owned(), kind };
            assert_eq!(read_copy_name(name), Some(expected), "{name}");
        }
    }

    #[test]
    fn names_of_people_are_no_copies() {
        for name in [
            "x.stl",
            "hardcopy.stl",
            "copyholder.stl",
            "kopiakopia.stl",
            "oldtimer.stl",
            "altar-1.stl",
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
            "threshold.stl",
            "backup.stl",
            "old.stl",
            "asphalt.stl",
            "x_10.stl",
            "x_0.stl",
            "x-1.stl",
            "x.stl.2026",
            "x.stl.x10",
            "1.stl",
            "~1.stl",
            "a~b.stl",
        ] {
            assert_eq!(read_copy_name(name), None, "{name}");
        }
    }
}
