//! Catalogs are whole, and alike in all languages; what the code says exists, and what exists is said.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use fluent_bundle::FluentResource;

use crate::{
    Language,
    catalog::{AREAS, word_id},
};

/// Kinds of words, and what stands before a word of the kind in the code where all of them are.
const KINDS: [&str; 7] = ["field", "state", "ledger", "http", "event", "trigger", "turned"];

/// Kinds of words that are not written in the code: those of HTTP, and the names of kinds of events.
const MADE_KINDS: [&str; 2] = ["http", "event"];

/// Sentences that are the same in English and in a language: (language, name). The book is in English, and so are examples of its words.
const EQUAL: &[(&str, &str)] = &[
    ("de", "delay-min"),
    ("de", "delay-hours"),
    ("de", "field-version"),
    ("de", "field-name"),
    ("de", "field-x"),
    ("de", "field-y"),
    ("de", "nav-farm"),
    ("de", "words-in-book-example"),
    ("fr", "found-machines"),
    ("fr", "machine-named"),
    ("fr", "count-machines"),
    ("fr", "triangles"),
    ("fr", "delay-min"),
    ("fr", "delay-hours"),
    ("fr", "field-machine"),
    ("fr", "field-question"),
    ("fr", "field-note"),
    ("fr", "field-volume"),
    ("fr", "field-version"),
    ("fr", "field-orientation"),
    ("fr", "field-machines"),
    ("fr", "field-x"),
    ("fr", "field-y"),
    ("fr", "words-in-book-example"),
    ("fr", "count-sections"),
];

/// The sentences of a catalog: name -> its text.
fn sentences(text: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut last: Option<String> = None;
    for line in text.lines() {
        let is_name = line.starts_with(|letter: char| letter.is_ascii_lowercase());
        match line.split_once('=').filter(|_| is_name) {
            Some((name, rest)) => {
                let name = name.trim().to_owned();
                assert!(found.insert(name.clone(), rest.trim().to_owned()).is_none(), "{name} stands twice");
                last = Some(name);
            }
            None if line.starts_with([' ', '}']) => {
                if let Some(text) = last.as_ref().and_then(|name| found.get_mut(name)) {
                    text.push('\n');
                    text.push_str(line.trim());
                }
            }
            None => last = None,
        }
    }
    found
}

/// The values that a sentence names.
fn values(text: &str) -> BTreeSet<&str> {
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
    text.split('$').skip(1).map(|rest| rest.split(|letter| !is_letter(letter)).next().unwrap_or_default()).collect()
}

/// Whether a sentence says something beside its values.
fn has_words(text: &str) -> bool {
    let beside = |piece: &str| match piece.split_once('}') {
        Some((value, rest)) if !value.contains("->") => rest.to_owned(),
        _ => piece.split_once("->").map_or(piece, |(_, rest)| rest).to_owned(),
    };
    let mut pieces = text.split("{ $");
    let first = pieces.next().unwrap_or_default().to_owned();
    std::iter::once(first).chain(pieces.map(beside)).any(|piece| piece.contains(char::is_alphabetic))
}

#[test]
fn each_catalog_can_be_read_and_no_name_stands_twice() {
    let mut names = BTreeSet::new();
    for area in AREAS {
        for (language, text) in Language::ALL.into_iter().zip(area.texts) {
            if let Err((_, faults)) = FluentResource::try_new(text.to_owned()) {
                panic!("{}/{}.ftl: {faults:?}", language.tag(), area.name);
            }
            sentences(text);
        }
        for name in sentences(area.texts[0]).into_keys() {
            assert!(names.insert(name.clone()), "{name} stands in two areas");
        }
    }
}

#[test]
fn all_languages_say_the_same_sentences_with_the_same_values() {
    let mut faults = Vec::new();
    for area in AREAS {
        let source = sentences(area.texts[0]);
        for (language, text) in Language::ALL.into_iter().zip(area.texts).skip(1) {
            let (tag, own) = (language.tag(), sentences(text));
            let place = format!("{tag}/{}.ftl", area.name);
            faults.extend(source.keys().filter(|name| !own.contains_key(*name)).map(|n| format!("{place} lacks {n}")));
            faults.extend(
                own.keys().filter(|name| !source.contains_key(*name)).map(|n| format!("{place}: {n} is unknown")),
            );
            for (name, english) in &source {
                let Some(said) = own.get(name) else { continue };
                if values(english) != values(said) {
                    faults.push(format!("{place}: {name} has other values: {english} / {said}"));
                }
                if has_words(english) && english == said && !EQUAL.contains(&(tag, name)) {
                    faults.push(format!("{place}: {name} is English: {english}"));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// All source files of the workspace but this crate's tests.
pub(crate) fn source_files(dir: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            source_files(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// No name and no word is longer.
const LONGEST_NAME: usize = 60;
/// What stands before the name of a sentence; not written as it is, because this file is searched as well.
const CALLS: [&str; 2] = [concat!("say", "!("), concat!("phrase", "!(")];

#[test]
fn every_name_that_the_code_says_exists_and_every_sentence_is_said() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = Vec::new();
    for folder in ["src", "crates"] {
        source_files(&workspace.join(folder), &mut files);
    }
    let known: BTreeMap<String, &str> =
        AREAS.iter().flat_map(|area| sentences(area.texts[0]).into_keys().map(|name| (name, area.name))).collect();
    let (mut said, mut missing) = (BTreeSet::new(), Vec::new());
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        for (at, _) in text.match_indices('"') {
            let quoted = text[at + 1..].split('"').next().unwrap_or_default();
            if quoted.len() > LONGEST_NAME || quoted.contains('\n') {
                continue;
            }
            let words = KINDS.map(|kind| word_id(kind, quoted));
            said.extend([quoted.to_owned()].into_iter().chain(words.clone()).filter(|name| known.contains_key(name)));
            let before = text[..at].trim_end();
            let is_call = before.ends_with(CALLS[0]) || before.ends_with(CALLS[1]);
            let is_label = before.contains("FieldDefinition::")
                && before.rsplit("FieldDefinition::").next().is_some_and(|kind| kind.len() < 8 && kind.ends_with('('));
            if is_call && !known.contains_key(quoted) || is_label && !known.contains_key(&words[0]) {
                missing.push(format!("{}: {quoted}", file.display()));
            }
        }
    }
    let is_made =
        |name: &str| MADE_KINDS.iter().any(|kind| name.strip_prefix(kind).is_some_and(|rest| rest.starts_with('-')));
    // Sentences that are known by their words are another test's.
    let is_told = |name: &str| name.starts_with("told-");
    let unsaid: Vec<_> =
        known.iter().filter(|(name, _)| !said.contains(*name) && !is_made(name) && !is_told(name)).collect();
    assert!(missing.is_empty(), "no catalog has: {missing:#?}");
    assert!(unsaid.is_empty(), "nobody says: {unsaid:#?}");
}
