//! File names for display. A name is a sequence of bytes; a display name is text from which the bytes can be restored.

use std::{
    ffi::{OsStr, OsString},
    os::unix::ffi::{OsStrExt, OsStringExt},
    path::Path,
};

use build_file::{is_invisible, part_endings};

/// Maximum length of a file name on common file systems.
pub(crate) const MAX_NAME_BYTES: usize = 255;

/// Converts a name to text. Printable characters stay as they are, all others are escaped (`\n`, `\xff`, `\u{202e}`,
/// `\\`), so that different names always look different in a log and cannot manipulate a terminal. [`raw_name`]
/// reverses this.
pub fn display_name(name: &OsStr) -> String {
    let mut text = String::with_capacity(name.len());
    for chunk in name.as_bytes().utf8_chunks() {
        for c in chunk.valid().chars() {
            match c {
                '\\' => text.push_str("\\\\"),
                '\n' => text.push_str("\\n"),
                '\r' => text.push_str("\\r"),
                '\t' => text.push_str("\\t"),
                c if is_invisible(c) => text.push_str(&format!("\\u{{{:x}}}", c as u32)),
                c => text.push(c),
            }
        }
        for byte in chunk.invalid() {
            text.push_str(&format!("\\x{byte:02x}"));
        }
    }
    text
}

/// Restores the bytes of a name that [`display_name`] escaped. `None` if the text is not a valid display name.
pub fn raw_name(display: &str) -> Option<OsString> {
    let mut bytes = Vec::with_capacity(display.len());
    let mut rest = display;
    while let Some(at) = rest.find('\\') {
        bytes.extend_from_slice(&rest.as_bytes()[..at]);
        let (escape, after) = split_escape(&rest[at + 1..])?;
        bytes.extend_from_slice(&escape);
        rest = after;
    }
    bytes.extend_from_slice(rest.as_bytes());
    Some(OsString::from_vec(bytes))
}

/// Parses the escape sequence at the start of `text` (after its backslash). Returns its bytes and the remaining text.
fn split_escape(text: &str) -> Option<(Vec<u8>, &str)> {
    let mut chars = text.chars();
    let one = |byte: u8, rest| Some((vec![byte], rest));
    match chars.next()? {
        '\\' => one(b'\\', chars.as_str()),
        'n' => one(b'\n', chars.as_str()),
        'r' => one(b'\r', chars.as_str()),
        't' => one(b'\t', chars.as_str()),
        'x' => one(u8::from_str_radix(text.get(1..3)?, 16).ok()?, text.get(3..)?),
        'u' => {
            let (hex, rest) = text.strip_prefix("u{")?.split_once('}')?;
            let c = char::from_u32(u32::from_str_radix(hex, 16).ok()?)?;
            Some((c.to_string().into_bytes(), rest))
        }
        _ => None,
    }
}

/// Makes an order name of sub-folders: each is escaped, and they are joined by `/`.
pub(crate) fn order_display_name(folders: &Path) -> String {
    folders.iter().map(display_name).collect::<Vec<_>>().join("/")
}

/// Returns `name (n).ext`, shortened to the maximum length of a name. `n` = 1 gives the name itself.
pub(crate) fn numbered_name(name: &OsStr, n: u32) -> OsString {
    with_suffix(name, &if n == 1 { String::new() } else { format!(" ({n})") }, "")
}

/// Returns `stem` + `number` + extension + `tail`. If this is too long, the stem is shortened at a character boundary.
pub(crate) fn with_suffix(name: &OsStr, number: &str, tail: &str) -> OsString {
    let bytes = name.as_bytes();
    // A longer "extension" is part of a long name with a dot in it.
    let dot = bytes.iter().rposition(|&b| b == b'.').filter(|&at| at > 0 && bytes.len() - at <= 32);
    let (stem, extension) = bytes.split_at(dot.unwrap_or(bytes.len()));
    let room = MAX_NAME_BYTES - extension.len() - number.len() - tail.len();
    let mut cut = stem.len().min(room);
    // A byte 10xxxxxx continues a character of UTF-8.
    while cut < stem.len() && cut > 0 && stem[cut] & 0b1100_0000 == 0b1000_0000 {
        cut -= 1;
    }
    OsString::from_vec([&stem[..cut], number.as_bytes(), extension, tail.as_bytes()].concat())
}

/// Whether a name ends like a part file. A folder with such a name is not an order: it was created by mistake or by
/// unpacking.
pub(crate) fn is_part_name(name: &OsStr) -> bool {
    Path::new(name).extension().is_some_and(|e| part_endings().any(|ending| e.eq_ignore_ascii_case(ending)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_of_people_stay_readable() {
        for name in ["Halter (links) 100%.stl", "größe_ä.stl", "部品.3mf", "👩‍🔧.stl"] {
            assert_eq!(display_name(OsStr::new(name)), name);
        }
    }

    #[test]
    fn what_cannot_be_seen_is_escaped() {
        assert_eq!(display_name(OsStr::from_bytes(b"a\nb\t\\c\xff.stl\x1b")), r"a\nb\t\\c\xff.stl\u{1b}");
        assert_eq!(display_name(OsStr::new("a\u{202e}lts.exe")), r"a\u{202e}lts.exe");
    }

    #[test]
    fn a_broken_escape_is_no_name() {
        for text in ["a\\", "\\q", "\\xg0", "\\x4", "\\u{110000}", "\\u{41"] {
            assert_eq!(raw_name(text), None, "{text}");
        }
    }

    #[test]
    fn a_long_name_keeps_its_extension_and_whole_characters() {
        let name = OsString::from("ä".repeat(125) + ".stl");
        let second = numbered_name(&name, 2);
        assert!(second.len() <= 255);
        assert!(second.to_str().unwrap().ends_with("ä (2).stl"));
        let reason = with_suffix(&name, "", ".reason.txt");
        assert!(reason.len() <= 255 && reason.to_str().unwrap().ends_with("ä.stl.reason.txt"));
    }

    #[test]
    fn a_name_without_extension_is_numbered_at_its_end() {
        assert_eq!(numbered_name(OsStr::new("socket"), 3), "socket (3)");
        assert_eq!(
            numbered_name(OsStr::new("v1.this is no extension but a sentence of it"), 2).to_str().unwrap().len(),
            48
        );
    }

    proptest! {
        #[test]
        fn every_name_comes_back_from_its_display_name(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let name = OsString::from_vec(bytes);
            prop_assert_eq!(raw_name(&display_name(&name)), Some(name));
        }

        #[test]
        fn a_numbered_name_always_fits(bytes in proptest::collection::vec(any::<u8>(), 1..256), n in 1u32..9999) {
            prop_assert!(numbered_name(OsStr::from_bytes(&bytes), n).len() <= 255);
            prop_assert!(with_suffix(OsStr::from_bytes(&bytes), " (9999)", ".reason.txt").len() <= 255);
        }
    }
}
