//! Number of copies in a file name: `bracket_x10.stl` means ten brackets.

/// More copies than this in one drop are taken for a typing error.
pub(super) const MAX_COPIES: u32 = 10_000;

/// Returns the number of copies that a file name asks for by `_x10 _10x _qty10 _10pcs` right before the extension,
/// separated by `_`, `-`, `.` or a space. `None` if it asks for none or is ambiguous: two such words, a leading zero,
/// more than 10 000 copies, or no other word in the name.
pub fn copies_in_name(name: &str) -> Option<u32> {
    let (last, before) = split_words(name)?;
    if before.iter().any(|w| parse_count(w).is_some()) {
        return None;
    }
    parse_count(last).filter(|&copies| copies <= u64::from(MAX_COPIES)).map(|copies| copies as u32)
}

/// Returns the word at the place of the copies that looks like a number of copies but that [`copies_in_name`] does not
/// accept.
pub(super) fn unclear_copies(name: &str) -> Option<String> {
    let (last, _) = split_words(name)?;
    let is_unclear = count_digits(last).is_some() && copies_in_name(name).is_none();
    is_unclear.then(|| last.to_owned())
}

/// Splits a file name into the last word before the extension and the words before it, at least one of which is not
/// empty.
fn split_words(name: &str) -> Option<(&str, Vec<&str>)> {
    let (stem, _) = name.rsplit_once('.')?;
    let stem = without_copy_number(stem);
    let mut words: Vec<&str> = stem.split(['_', '-', '.', ' ']).collect();
    let last = words.pop()?;
    words.iter().any(|w| !w.is_empty()).then_some((last, words))
}

/// Removes the ` (2)` that browsers and file managers add to the name of a second file.
fn without_copy_number(stem: &str) -> &str {
    let inner = stem.strip_suffix(')').and_then(|rest| rest.rsplit_once(" ("));
    inner.filter(|(_, n)| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit())).map_or(stem, |(before, _)| before)
}

/// Parses the number in a word such as `x10`, without a limit on its size.
fn parse_count(word: &str) -> Option<u64> {
    count_digits(word).filter(|digits| !digits.starts_with('0')).and_then(|digits| digits.parse().ok())
}

/// Returns the digits of a word that looks like a number of copies.
fn count_digits(word: &str) -> Option<String> {
    let word = word.to_ascii_lowercase();
    let digits = word
        .strip_prefix("qty")
        .or_else(|| word.strip_prefix('x'))
        .or_else(|| word.strip_suffix("pcs"))
        .or_else(|| word.strip_suffix('x'))?;
    (!digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())).then(|| digits.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_way_to_say_ten_is_understood() {
        for name in [
            "bracket_x10.stl",
            "bracket-10x.STL",
            "bracket qty10.3mf",
            "bracket_10pcs.stl",
            "bracket.X10.stl",
            "Größe 3_QTY10.stl",
            "m3x8_bolt_10PCS.stl",
            "a__x10.stl",
        ] {
            assert_eq!(copies_in_name(name), Some(10), "{name}");
        }
        assert_eq!(copies_in_name("bracket_x10 (2).stl"), Some(10), "a second download of the same file");
        assert_eq!(copies_in_name("bracket (2).stl"), None);
        assert_eq!(copies_in_name("a_x1.stl"), Some(1));
        assert_eq!(copies_in_name("a_x10000.stl"), Some(10_000));
    }

    #[test]
    fn what_looks_like_copies_and_is_not_understood_is_named() {
        for (name, word) in [
            ("part_x0.stl", "x0"),
            ("part_x99999.stl", "x99999"),
            ("part_x99999999999999999999.stl", "x99999999999999999999"),
            ("part-X05.stl", "X05"),
            ("part 0pcs.stl", "0pcs"),
            ("part_qty0.3mf", "qty0"),
            ("screw_x2_x10.stl", "x10"),
        ] {
            assert_eq!(unclear_copies(name).as_deref(), Some(word), "{name}");
        }
        for name in ["part_x10.stl", "part.stl", "box_10x20.stl", "axis_x.stl", "part_10.stl", "x0.stl", "part_x0", ""]
        {
            assert_eq!(unclear_copies(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_ambiguous_says_nothing() {
        for name in [
            "bracket.stl",
            "bracketx10.stl",
            "box_10x20.stl",
            "box_10x_20x.stl",
            "screw_x2_x10.stl",
            "part_x10_v2.stl",
            "part_x0.stl",
            "part_x05.stl",
            "part_x10001.stl",
            "part_x99999999999999999999.stl",
            "part_x.stl",
            "part_10.stl",
            "part_x-5.stl",
            "part_x1.5.stl",
            "x10.stl",
            "_x10.stl",
            "part_x10",
            "part_x１０.stl",
            "",
        ] {
            assert_eq!(copies_in_name(name), None, "{name}");
        }
    }
}
