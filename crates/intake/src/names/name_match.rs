//! Matches the names in a list or ticket with files. Names are compared as people mean them, and match only if one file
//! can be meant.

use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
    ffi::{OsStr, OsString},
    os::unix::ffi::OsStrExt,
    path::{Path, PathBuf},
};

use unicode_normalization::{UnicodeNormalization, is_nfc};

use super::{code_page::CodePage, name::is_part_name};
use crate::display_name;

/// Folds differences that people and file systems ignore: decomposed letters, upper case, and kinds of blanks.
pub fn fold_name(name: &str) -> String {
    let plain_blank = |c: char| if matches!(c, '\u{a0}' | '\u{202f}' | '\u{3000}') { ' ' } else { c };
    match name.is_ascii() {
        true => name.to_ascii_lowercase(),
        false => name.nfc().map(plain_blank).collect::<String>().to_lowercase().nfc().collect(),
    }
}

/// Folds the last component of a path. A name that is not valid text stays as it is.
pub(crate) fn fold_path(path: &Path) -> PathBuf {
    match path.file_name().and_then(OsStr::to_str) {
        Some(name) => path.with_file_name(fold_name(name)),
        None => path.to_owned(),
    }
}

/// Normalizes a name for comparison.
type NameNormalizer = fn(ComparedName) -> Option<Cow<'_, str>>;

/// The normalizers, the strictest first. A match by a stricter one takes precedence. Files in folders below that of the list have
/// these folders in their names.
const NORMALIZERS: [NameNormalizer; 12] = [
    exact_name,
    composed_name,
    in_any_case,
    whole_path,
    |side| path_end(side, 3),
    |side| path_end(side, 2),
    last_of_bare,
    last_of_path,
    path_without_extension,
    bare_without_extension,
    without_extension,
    without_number,
];

#[derive(Clone, Copy)]
enum ComparedName<'a> {
    /// A name as written in a list.
    InList(&'a str),
    /// The name of a file.
    OnDisk(&'a str),
}

impl<'a> ComparedName<'a> {
    fn text(self) -> &'a str {
        match self {
            Self::InList(text) | Self::OnDisk(text) => text,
        }
    }
}

fn exact_name(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    Some(side.text().into())
}

/// Composes the letters and removes a leading `./` of a list.
fn composed_name(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    let text = match side {
        ComparedName::InList(said) => said.strip_prefix("./").or_else(|| said.strip_prefix(".\\")).unwrap_or(said),
        ComparedName::OnDisk(file) => file,
    };
    Some(if is_nfc(text) { text.into() } else { text.nfc().collect::<String>().into() })
}

fn in_any_case(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    composed_name(side).map(|text| fold_name(&text).into())
}

/// A path with one kind of slash, without a leading `./`.
fn whole_path(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    let text = in_any_case(side)?;
    let ComparedName::InList(_) = side else { return Some(text) };
    Some(text.replace('\\', "/").trim_start_matches("./").trim_start_matches('/').to_owned().into())
}

/// The last components of a path: lists may be written on another computer and contain its folders.
fn path_end(side: ComparedName<'_>, components: usize) -> Option<Cow<'_, str>> {
    let path = whole_path(side)?;
    let (from, _) = path.rmatch_indices('/').nth(components - 1).unwrap_or((0, ""));
    let end = path[from..].trim_start_matches('/');
    (end.matches('/').count() + 1 == components).then(|| end.to_owned().into())
}

fn last_component(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// The name of a file, for a name in the list that tells no folder of the order: alone, or with a path of another computer.
fn last_of_bare(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    if let ComparedName::InList(said) = side {
        let is_absolute = said.starts_with(['/', '\\']) || said.as_bytes().get(1) == Some(&b':');
        let path = whole_path(side)?;
        return (is_absolute || !path.contains('/')).then(|| last_component(&path).to_owned().into());
    }
    Some(last_component(&in_any_case(side)?).to_owned().into())
}

/// The last component of any path in the list, for a file beside the list.
fn last_of_path(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    match side {
        ComparedName::InList(_) => Some(last_component(&whole_path(side)?).to_owned().into()),
        ComparedName::OnDisk(file) => (!file.contains('/')).then(|| fold_name(file).into()),
    }
}

/// `left/bracket` for `left/bracket.stl`.
fn path_without_extension(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    stem_of(side, whole_path(side)?)
}

/// `bracket` for `left/bracket.stl`.
fn bare_without_extension(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    stem_of(side, last_of_bare(side)?)
}

/// `bracket` for `bracket.stl`.
fn without_extension(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    stem_of(side, last_of_path(side)?)
}

fn stem_of<'a>(side: ComparedName<'_>, name: Cow<'a, str>) -> Option<Cow<'a, str>> {
    let is_part = is_part_name(OsStr::new(name.as_ref()));
    match side {
        ComparedName::InList(_) => Some(name).filter(|_| !is_part),
        ComparedName::OnDisk(_) => name.rsplit_once('.').filter(|_| is_part).map(|(stem, _)| stem.to_owned().into()),
    }
}

/// Matches `bracket.stl` with `bracket (2).stl`: nestd and browsers add such a number when a name is taken.
fn without_number(side: ComparedName<'_>) -> Option<Cow<'_, str>> {
    let ComparedName::OnDisk(_) = side else { return last_of_path(side) };
    let last = last_of_bare(side)?;
    let (stem, extension) = last.rsplit_once('.')?;
    let (before, number) = stem.strip_suffix(')')?.rsplit_once(" (")?;
    let is_number = (1..=4).contains(&number.len()) && number.bytes().all(|digit| digit.is_ascii_digit());
    is_number.then(|| format!("{before}.{extension}").into())
}

/// Whether a name in a list means the file at this path below the folder of the list. `may_be_bare` = the name of the file
/// alone means it too.
pub(crate) fn means_file_below(said: &str, relative: &str, may_be_bare: bool) -> bool {
    let said = fold_name(&said.replace('\\', "/"));
    let (said, relative) = (said.trim_start_matches("./"), fold_name(relative));
    let is_same = |said: &str, path: &str| {
        said == path || path.rsplit_once('.').is_some_and(|(stem, _)| is_part_name(OsStr::new(path)) && said == stem)
    };
    let last = relative.rsplit('/').next().unwrap_or(&relative);
    is_same(said, &relative)
        || said.ends_with(&format!("/{relative}"))
        || may_be_bare && !said.contains('/') && is_same(said, last)
}

/// Matches between the names in a list and the files of its folder.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct NameMatches {
    /// For each matched file: the indexes of the names that mean it, or a name that could also mean another file.
    pub files: HashMap<OsString, FileNameMatch>,
    /// Indexes of the names that mean, or could mean, a file.
    pub named: HashSet<usize>,
}

/// The match of one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum FileNameMatch {
    /// Names (by index) that mean this file and no other.
    Only(Vec<usize>),
    /// A name (by index) that could mean this file or these other files.
    Ambiguous(usize, Vec<String>),
}

impl NameMatches {
    /// Computes the matches for a list in this code page. Each name and each file is used only at its strictest match.
    pub fn in_code_page<'a>(said: &[&str], files: impl Iterator<Item = &'a OsStr>, page: CodePage) -> Self {
        let files: Vec<(&OsStr, String)> = files.map(|file| (file, compared_text(file, page))).collect();
        let mut open_said: HashSet<usize> = (0..said.len()).filter(|&at| !said[at].is_empty()).collect();
        let mut open_files: HashSet<usize> = (0..files.len()).collect();
        let mut meant = Self::default();
        for key in NORMALIZERS {
            if open_said.is_empty() || open_files.is_empty() {
                break;
            }
            let mut by_key: HashMap<Cow<str>, (Vec<usize>, Vec<usize>)> = HashMap::new();
            for &at in &open_said {
                key(ComparedName::InList(said[at]))
                    .into_iter()
                    .for_each(|key| by_key.entry(key).or_default().0.push(at));
            }
            for &at in &open_files {
                let Some(key) = key(ComparedName::OnDisk(&files[at].1)) else { continue };
                by_key.entry(key).and_modify(|(_, files)| files.push(at));
            }
            for (mut names, candidates) in by_key.into_values().filter(|(_, files)| !files.is_empty()) {
                names.sort_unstable();
                for &file in &candidates {
                    let others = || candidates.iter().filter(|&&at| at != file).map(|&at| files[at].1.clone());
                    let meaning = match candidates.len() {
                        1 => FileNameMatch::Only(names.clone()),
                        _ => FileNameMatch::Ambiguous(names[0], others().collect()),
                    };
                    meant.files.insert(files[file].0.to_owned(), meaning);
                    open_files.remove(&file);
                }
                names.iter().for_each(|at| _ = open_said.remove(at));
                meant.named.extend(names);
            }
        }
        meant
    }

    /// Number of files that a name refers to.
    pub fn matched_count(&self) -> usize {
        self.files.len()
    }
}

/// Converts a file name to text. A name that is not UTF-8 is read in the code page of the list, so that equal bytes are equal
/// names; otherwise it is escaped as in `nestd status`.
fn compared_text(file: &OsStr, page: CodePage) -> String {
    let in_page = || page.decode(file.as_bytes()).unwrap_or_else(|| display_name(file));
    file.to_str().map_or_else(in_page, str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meant(said: &[&str], files: &[&str]) -> Vec<(String, FileNameMatch)> {
        let meant = NameMatches::in_code_page(said, files.iter().map(OsStr::new), CodePage::Unicode);
        let mut all: Vec<_> = meant.files.into_iter().map(|(f, m)| (f.into_string().unwrap(), m)).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    }

    #[test]
    fn a_name_means_the_file_that_people_mean_by_it() {
        for (said, file) in [
            ("Größe.stl", "Gro\u{308}ße.stl"),
            ("Gro\u{308}ße.STL", "größe.stl"),
            (".\\bracket.stl", "bracket.stl"),
            ("./bracket.stl", "bracket.stl"),
            ("C:\\orders\\7\\Bracket.stl", "bracket.stl"),
            ("bracket", "bracket.STL"),
            ("v1.2 lid", "v1.2 lid.3mf"),
            ("bracket.stl", "bracket (2).stl"),
            ("デバイス.stl", "テ\u{3099}ハ\u{3099}イス.stl"),
            ("a\\b.stl", "a\\b.stl"),
        ] {
            assert_eq!(meant(&[said], &[file]), [(file.to_owned(), FileNameMatch::Only(vec![0]))], "{said}");
        }
    }

    #[test]
    fn the_folders_that_a_row_names_decide_among_files_below_the_list() {
        let only = |file: &str, at: usize| (file.to_owned(), FileNameMatch::Only(vec![at]));
        let files = ["L/a.stl", "R/a.stl"];
        let both = |at: usize, other: &str| FileNameMatch::Ambiguous(at, vec![other.to_owned()]);
        for rows in [
            ["R/a.stl", "L/a.stl"],
            ["r\\A.STL", "./L/a.stl"],
            ["C:\\orders\\7\\R\\a.stl", "/home/x/L/a.stl"],
            ["kunde/R/a.stl", "kunde/L/a.stl"],
            ["R/a", "L\\a"],
        ] {
            assert_eq!(meant(&rows, &files), [only("L/a.stl", 1), only("R/a.stl", 0)], "{rows:?}");
        }
        for said in ["a.stl", "A", "C:\\orders\\a.stl", "/orders/a.stl"] {
            let unclear = [("L/a.stl".to_owned(), both(0, "R/a.stl")), ("R/a.stl".to_owned(), both(0, "L/a.stl"))];
            assert_eq!(meant(&[said], &files), unclear, "{said}");
        }
        // Another folder of the order is not meant.
        assert_eq!(meant(&["M/a.stl"], &files), []);
        assert_eq!(meant(&["a.stl"], &["a.stl", "L/a.stl"]), [only("a.stl", 0)]);
        assert_eq!(meant(&["R/a.stl"], &["L/a.stl", "a.stl"]), [only("a.stl", 0)]);
        assert_eq!(meant(&["sub/a.stl"], &["sub/a.stl", "sub/b.stl"]), [only("sub/a.stl", 0)]);
    }

    #[test]
    fn a_nearer_name_wins_and_two_files_for_one_name_are_unclear() {
        let only = |file: &str, at: usize| (file.to_owned(), FileNameMatch::Only(vec![at]));
        assert_eq!(meant(&["a.stl", "A.stl"], &["A.stl", "a.stl"]), [only("A.stl", 1), only("a.stl", 0)]);
        assert_eq!(meant(&["a.stl"], &["a.stl", "a (2).stl"]), [only("a.stl", 0)]);
        assert_eq!(meant(&["a"], &["a.stl", "a.3mf"]).len(), 2);
        assert!(
            matches!(&meant(&["a"], &["a.stl", "a.3mf"])[0].1, FileNameMatch::Ambiguous(0, others) if others[..] == ["a.stl"])
        );
        assert_eq!(meant(&["a.stl", "a.stl"], &["a.stl"]), [("a.stl".to_owned(), FileNameMatch::Only(vec![0, 1]))]);
        assert_eq!(meant(&["x/a.stl", "y/a.stl"], &["a.stl"]), [("a.stl".to_owned(), FileNameMatch::Only(vec![0, 1]))]);
        assert_eq!(meant(&["a.stl"], &["a.3mf", "b.stl"]), []);
    }
}
