//! Tests of numbers of copies in file names. The files `samples/*.tsv` hold names as people write them, each with what it
//! must mean.

use super::*;

/// Each file and the number of names that it has at least.
const NAMES: [(&str, usize); 5] = [
    (include_str!("../../samples/names.tsv"), 300),
    (include_str!("../../samples/sizes.tsv"), 150),
    (include_str!("../../samples/copies.tsv"), 150),
    (include_str!("../../samples/questions.tsv"), 150),
    (include_str!("../../samples/trades.tsv"), 500),
];

fn sample_names(file: &'static str) -> Vec<(&'static str, &'static str)> {
    let rows = file.lines().filter(|line| !line.starts_with('#'));
    rows.map(|line| line.split_once('\t').unwrap_or_else(|| panic!("no tab in {line:?}"))).collect()
}

#[test]
fn names_as_people_write_them_mean_what_they_must() {
    let mut wrong = Vec::new();
    for (file, least) in NAMES {
        assert!(sample_names(file).len() >= least, "only {} names", sample_names(file).len());
    }
    for (name, meaning) in NAMES.iter().flat_map(|(file, _)| sample_names(file)) {
        let read = read_copies_in_name(name);
        let shown = match &read {
            CopiesInName::Unsaid => "-".to_owned(),
            CopiesInName::Said(copies) => copies.to_string(),
            CopiesInName::Unclear(_) | CopiesInName::Many(_) | CopiesInName::Undecodable => "?".to_owned(),
        };
        if shown != meaning {
            wrong.push(format!("{name} must mean {meaning}, but is read as {read:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unclear_words_are_shown_as_they_are_written() {
    for (name, words) in [
        ("part_x0.stl", "x0"),
        ("screw_x2_x10.stl", "x2 .. x10"),
        ("Halter_3_Stk_5.stl", "3_stk"),
        ("lot de 5 clips.stl", "lot de 5"),
    ] {
        let CopiesInName::Unclear(text) = read_copies_in_name(name) else { panic!("{name} is clear") };
        assert_eq!(text, words, "{name}");
    }
}

#[test]
fn more_than_some_tens_by_a_sign_or_a_hundred_in_words_are_asked_for() {
    for (name, is_asked) in [
        ("adapter_x50.stl", false),
        ("adapter_x51.stl", true),
        ("51x adapter.stl", true),
        ("adapter_100pcs.stl", false),
        ("adapter_101pcs.stl", true),
        ("adapter_qty_1000_x1000.stl", true),
    ] {
        let read = read_copies_in_name(name);
        assert_eq!(matches!(read, CopiesInName::Many(_)), is_asked, "{name}: {read:?}");
        assert_eq!(read.unclear_reason().is_some(), is_asked, "{name}");
    }
}

#[test]
fn any_name_is_read_without_a_panic() {
    for name in
        ["", ".", "..", ".stl", "x", "×", "=", "=4", "4", "x.x", "\u{300}.stl", "(2).stl", ")(.stl", "1.1.1", "y"]
    {
        let _ = read_copies_in_name(name);
    }
    proptest::proptest!(|(name in "[x×0-9a-z個._ ()=-]{0,12}")| {
        let _ = read_copies_in_name(&name);
    });
}

#[test]
fn a_name_that_is_no_text_says_no_copies_and_is_asked_about() {
    let name: &OsStr = std::os::unix::ffi::OsStrExt::from_bytes(b"Halter \x93neu\x94 x4.stl".as_slice());
    assert_eq!(read_copies_in_file_name(name), CopiesInName::Undecodable);
    assert!(
        CopiesInName::Undecodable
            .unclear_reason()
            .is_some_and(|why| why.contains("no text") || why.contains("not text"))
    );
    assert_eq!(read_copies_in_file_name(OsStr::new("Halter x4.stl")), CopiesInName::Said(4));
}
