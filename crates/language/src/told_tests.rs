//! Sentences that are known by their English words: each is found again in every language, and is one that the code writes.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    Arg, Language,
    catalog::{AREAS, sentence},
    catalog_tests::source_files,
    retold,
    retold::{SENTENCES, TOLD, sentences_of, values_of},
};

/// A sentence that stands in others, in English and by its name.
const INNER: (&str, &str) = ("the file is empty", "told-file-is-empty");

fn told_sentences() -> impl Iterator<Item = (&'static str, &'static str)> {
    AREAS.iter().filter(|area| TOLD.contains(&area.name)).flat_map(|area| sentences_of(area.texts[0]))
}

/// A sentence with values of each kind: in English, and as a language has it. `number` is that of all numbers.
fn with_values(name: &'static str, text: &'static str, language: Language, number: u32) -> (String, String) {
    let values = values_of(text);
    let args = |inner: String| -> Vec<(&'static str, Arg)> {
        let arg = |(at, value): (usize, &&'static str)| {
            let arg = match () {
                () if text.contains(&format!("${value} ->")) => Arg::Number(number.into()),
                () if SENTENCES.contains(value) => Arg::Text(inner.clone()),
                () if *value == "path" => Arg::Text(format!("/v{at}.x")),
                () => Arg::Text(format!("v{at}.x")),
            };
            (*value, arg)
        };
        values.iter().enumerate().map(arg).collect()
    };
    let inner = sentence(language, INNER.1, &[]);
    (sentence(Language::English, name, &args(INNER.0.to_owned())), sentence(language, name, &args(inner)))
}

#[test]
fn each_sentence_that_is_said_again_is_found_by_its_words_in_every_language() {
    let mut faults = Vec::new();
    for (name, text) in told_sentences() {
        for language in Language::ALL.into_iter().skip(1) {
            for number in [1, 3] {
                let (english, expected) = with_values(name, text, language, number);
                let found = language.within(|| retold(&english));
                let bare = |text: &str| text.trim_end_matches(['.', '。']).to_owned();
                if found.as_deref().map(bare) != Some(bare(&expected)) {
                    faults.push(format!("{name}: {english} -> {found:?} instead of {expected}"));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{} faults: {}", faults.len(), faults.join("\n"));
}

/// A text without what separates words, for texts are broken over lines and quoted in sources.
fn letters(text: &str) -> String {
    text.chars().filter(|letter| letter.is_alphanumeric() || "().,:;=`".contains(*letter)).collect()
}

/// Sentences that the code puts together of smaller pieces than clauses.
const COMPOSED: [&str; 6] = [
    "told-newer-revision",
    "told-newer-revision-order",
    "told-copies-cancelled-of-order",
    "told-copies-not-asked",
    "told-at-risk-more",
    "told-at-risk-more-of",
];

fn split_each<'t>(pieces: Vec<&'t str>, between: &&str) -> Vec<&'t str> {
    pieces.into_iter().flat_map(|piece| piece.split(between)).collect()
}

#[test]
fn the_words_of_each_sentence_that_is_said_again_stand_in_the_code() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = Vec::new();
    for folder in ["src", "crates"] {
        source_files(&workspace.join(folder), &mut files);
    }
    let is_code = |file: &PathBuf| {
        let file = file.strip_prefix(&workspace).unwrap().to_string_lossy();
        !file.contains("test") && !file.starts_with("crates/language")
    };
    files.retain(is_code);
    let code: String = files.iter().map(|file| letters(&fs::read_to_string(file).unwrap())).collect();
    let mut missing = Vec::new();
    for (name, text) in told_sentences().filter(|(name, _)| name.starts_with("told-") && !name.starts_with("told-os-"))
    {
        let flat: String = text.lines().map(str::trim).collect::<Vec<_>>().join("\n");
        // Words between values and the forms that a number chooses.
        let pieces = flat.split(['{', '}', '\n', '[', ']']);
        let clauses = pieces.flat_map(|piece| [". ", ", ", ": ", "; ", "? "].iter().fold(vec![piece], split_each));
        let clauses = clauses.map(letters);
        let is_word = |piece: &String| {
            let is_syntax = piece.is_empty() || ["one", "*", "other"].contains(&piece.as_str());
            !is_syntax && piece.chars().any(char::is_alphabetic)
        };
        let values = values_of(text);
        for piece in clauses.filter(is_word).filter(|_| !COMPOSED.contains(&name)) {
            let piece = piece.trim_matches(['.', ',', ':', ';', '(', ')']);
            // The syntax of the catalogs: `$count ->`.
            if !code.contains(piece) && !values.contains(&piece) {
                missing.push(format!("{name}: {piece}"));
            }
        }
    }
    assert!(missing.is_empty(), "{} that no code writes: {}", missing.len(), missing.join("\n"));
}

/// Words that end as plurals do and are none.
const NO_PLURALS: &[&str] =
    &["is", "as", "was", "has", "s", "prints", "serves", "stands", "lies", "fires", "keeps", "writes", "does"];
/// Sentences whose number is never 1, or none.
const NEVER_ONE: &[&str] = &[
    "last-press-all",
    "note-none-printed",
    "note-all-printed",
    "note-all-should",
    "note-some-should",
    "triangles",
    "script-several-late",
    "bytes-and-hash",
    "status-drop",
    "files-of",
    "nothing-came-drop",
    "nothing-came-copy",
];

#[test]
fn a_number_before_a_noun_chooses_its_form() {
    let mut faults = Vec::new();
    for area in AREAS.iter().filter(|area| !TOLD.contains(&area.name)) {
        for (name, text) in sentences_of(area.texts[0]) {
            for (value, rest) in text.split("{ $").skip(1).filter_map(|piece| piece.split_once(" } ")) {
                let noun = rest.split(|letter: char| !letter.is_alphabetic()).next().unwrap_or_default();
                let is_plural = noun.ends_with('s') && !NO_PLURALS.contains(&noun) || noun == "copies";
                if is_plural && !text.contains("->") && !NEVER_ONE.contains(&name) {
                    faults.push(format!("{name}: {value} {noun}"));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
