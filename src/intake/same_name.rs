//! Which name of a list or ticket means which file: names are compared as people mean them, and only where one file can be
//! meant.

use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
};

use unicode_normalization::{UnicodeNormalization, is_nfc};

use super::{display_name, name::is_part_name};

/// A name without what people and systems do not tell apart: decomposed letters, capital letters.
pub(super) fn folded(name: &str) -> String {
    match name.is_ascii() {
        true => name.to_ascii_lowercase(),
        false => name.nfc().collect::<String>().to_lowercase().nfc().collect(),
    }
}

/// The same of a path: only its last part is folded. A name that is no text is as it is.
pub(super) fn folded_path(path: &Path) -> PathBuf {
    match path.file_name().and_then(OsStr::to_str) {
        Some(name) => path.with_file_name(folded(name)),
        None => path.to_owned(),
    }
}

/// A way of reading a name.
type Reading = fn(Side) -> Option<Cow<'_, str>>;

/// How near a name of a list comes to a file's: a nearer one wins.
const NEARNESS: [Reading; 6] = [exact, composed, in_any_case, last_of_path, without_suffix, unnumbered];

#[derive(Clone, Copy)]
enum Side<'a> {
    /// As a list says it.
    Said(&'a str),
    /// As a file is called.
    File(&'a str),
}

impl<'a> Side<'a> {
    fn text(self) -> &'a str {
        match self {
            Self::Said(text) | Self::File(text) => text,
        }
    }
}

fn exact(side: Side<'_>) -> Option<Cow<'_, str>> {
    Some(side.text().into())
}

/// Letters composed, and without the `./` of a list.
fn composed(side: Side<'_>) -> Option<Cow<'_, str>> {
    let text = match side {
        Side::Said(said) => said.strip_prefix("./").or_else(|| said.strip_prefix(".\\")).unwrap_or(said),
        Side::File(file) => file,
    };
    Some(if is_nfc(text) { text.into() } else { text.nfc().collect::<String>().into() })
}

fn in_any_case(side: Side<'_>) -> Option<Cow<'_, str>> {
    composed(side).map(|text| folded(&text).into())
}

/// The last part of a path: lists are written elsewhere, with the folders of another computer.
fn last_of_path(side: Side<'_>) -> Option<Cow<'_, str>> {
    match side {
        Side::Said(said) => Some(folded(said.rsplit(['/', '\\']).next().unwrap_or(said)).into()),
        Side::File(file) => Some(folded(file).into()),
    }
}

/// `bracket` for `bracket.stl`.
fn without_suffix(side: Side<'_>) -> Option<Cow<'_, str>> {
    let last = last_of_path(side)?;
    match side {
        Side::Said(_) => Some(last).filter(|last| !is_part_name(OsStr::new(last.as_ref()))),
        Side::File(_) => last
            .rsplit_once('.')
            .filter(|_| is_part_name(OsStr::new(last.as_ref())))
            .map(|(stem, _)| stem.to_owned().into()),
    }
}

/// `bracket.stl` for `bracket (2).stl`: nestd and browsers number what is there already.
fn unnumbered(side: Side<'_>) -> Option<Cow<'_, str>> {
    let last = last_of_path(side)?;
    let Side::File(_) = side else { return Some(last) };
    let (stem, extension) = last.rsplit_once('.')?;
    let (before, number) = stem.strip_suffix(')')?.rsplit_once(" (")?;
    let is_number = (1..=4).contains(&number.len()) && number.bytes().all(|digit| digit.is_ascii_digit());
    is_number.then(|| format!("{before}.{extension}").into())
}

/// What the names of a list mean among the files of its folder.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Meant {
    /// For each file: the names of the list, by their numbers, that mean it; or those that could mean it or another file.
    pub files: HashMap<OsString, Meaning>,
    /// The names of the list that mean, or could mean, a file.
    pub named: HashSet<usize>,
}

/// What is said about a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Meaning {
    /// These names mean it and no other file.
    Only(Vec<usize>),
    /// This name could mean it, and these other files.
    Unclear(usize, Vec<String>),
}

impl Meant {
    /// Finds out. Each name and each file are used where they come nearest, and only there.
    pub fn new<'a>(said: &[&str], files: impl Iterator<Item = &'a OsStr>) -> Self {
        let files: Vec<(&OsStr, String)> = files.map(|file| (file, shown(file))).collect();
        let mut open_said: HashSet<usize> = (0..said.len()).filter(|&at| !said[at].is_empty()).collect();
        let mut open_files: HashSet<usize> = (0..files.len()).collect();
        let mut meant = Self::default();
        for key in NEARNESS {
            if open_said.is_empty() || open_files.is_empty() {
                break;
            }
            let mut by_key: HashMap<Cow<str>, (Vec<usize>, Vec<usize>)> = HashMap::new();
            for &at in &open_said {
                key(Side::Said(said[at])).into_iter().for_each(|key| by_key.entry(key).or_default().0.push(at));
            }
            for &at in &open_files {
                let Some(key) = key(Side::File(&files[at].1)) else { continue };
                by_key.entry(key).and_modify(|(_, files)| files.push(at));
            }
            for (mut names, candidates) in by_key.into_values().filter(|(_, files)| !files.is_empty()) {
                names.sort_unstable();
                for &file in &candidates {
                    let others = || candidates.iter().filter(|&&at| at != file).map(|&at| files[at].1.clone());
                    let meaning = match candidates.len() {
                        1 => Meaning::Only(names.clone()),
                        _ => Meaning::Unclear(names[0], others().collect()),
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

    /// How many files are meant by a name.
    pub fn found(&self) -> usize {
        self.files.len()
    }
}

/// A name as text; one that is no text is as `nestd status` shows it.
fn shown(file: &OsStr) -> String {
    file.to_str().map_or_else(|| display_name(file), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meant(said: &[&str], files: &[&str]) -> Vec<(String, Meaning)> {
        let meant = Meant::new(said, files.iter().map(OsStr::new));
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
            assert_eq!(meant(&[said], &[file]), [(file.to_owned(), Meaning::Only(vec![0]))], "{said}");
        }
    }

    #[test]
    fn a_nearer_name_wins_and_two_files_for_one_name_are_unclear() {
        let only = |file: &str, at: usize| (file.to_owned(), Meaning::Only(vec![at]));
        assert_eq!(meant(&["a.stl", "A.stl"], &["A.stl", "a.stl"]), [only("A.stl", 1), only("a.stl", 0)]);
        assert_eq!(meant(&["a.stl"], &["a.stl", "a (2).stl"]), [only("a.stl", 0)]);
        assert_eq!(meant(&["a"], &["a.stl", "a.3mf"]).len(), 2);
        assert!(
            matches!(&meant(&["a"], &["a.stl", "a.3mf"])[0].1, Meaning::Unclear(0, others) if others[..] == ["a.stl"])
        );
        assert_eq!(meant(&["a.stl", "a.stl"], &["a.stl"]), [("a.stl".to_owned(), Meaning::Only(vec![0, 1]))]);
        assert_eq!(meant(&["x/a.stl", "y/a.stl"], &["a.stl"]), [("a.stl".to_owned(), Meaning::Only(vec![0, 1]))]);
        assert_eq!(meant(&["a.stl"], &["a.3mf", "b.stl"]), []);
    }
}
