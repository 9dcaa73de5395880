//! Tests of numbers of copies in file names. `samples/names.tsv` holds names as people write them, each with what it
//! must mean.

use super::*;

const NAMES: &str = include_str!("samples/names.tsv");

fn sample_names() -> Vec<(&'static str, &'static str)> {
    let rows = NAMES.lines().filter(|line| !line.starts_with('#'));
    rows.map(|line| line.split_once('\t').unwrap_or_else(|| panic!("no tab in {line:?}"))).collect()
}

#[test]
fn names_as_people_write_them_mean_what_they_must() {
    let names = sample_names();
    assert!(names.len() >= 300, "only {} names", names.len());
    let mut wrong = Vec::new();
    for (name, meaning) in names {
        let read = read_copies_in_name(name);
        let shown = match &read {
            CopiesInName::Unsaid => "-".to_owned(),
            CopiesInName::Said(copies) => copies.to_string(),
            CopiesInName::Unclear(_) => "?".to_owned(),
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
