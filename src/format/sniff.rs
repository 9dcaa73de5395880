//! Which format a file is in: by its first bytes and its size, then by its name.

use super::stl_read::{binary_len, claimed_count};

/// Bytes of the head that the decision needs.
pub(super) const HEAD_BYTES: u64 = 1024;

/// What a file is taken for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    /// A ZIP package, so a 3MF if anything.
    Package,
    TextStl,
    BinaryStl,
    /// Nothing that we read; says what it looks like.
    Other(String),
}

/// Decides from the head (up to [`HEAD_BYTES`]), the size and the dropped name.
pub(super) fn kind(head: &[u8], len: u64, name: &str) -> Kind {
    let extension = name.rsplit_once('.').map_or(String::new(), |(_, e)| e.to_ascii_lowercase());
    if len == 0 {
        return Kind::Other("the file is empty".to_owned());
    }
    let exact = claimed_count(head).is_some_and(|count| count > 0 && binary_len(count) == len);
    if exact {
        return Kind::BinaryStl;
    }
    if head.starts_with(b"PK\x03\x04") {
        return match extension.as_str() {
            "3mf" | "stl" | "zip" | "" => Kind::Package,
            other => Kind::Other(format!("it is a ZIP package named `.{other}`")),
        };
    }
    if let Some(what) = foreign(head) {
        return Kind::Other(what);
    }
    if claims_binary_facets(head) {
        return Kind::BinaryStl;
    }
    if starts_like_text_stl(head) || (is_text(head) && contains_word(head, b"facet")) {
        return Kind::TextStl;
    }
    match extension.as_str() {
        "stl" if is_text(head) && head.len() > 84 => Kind::Other("it is text without `solid`".to_owned()),
        "stl" => Kind::BinaryStl,
        // A package may follow other bytes; the reader finds its directory at the end or says that there is none.
        "3mf" => Kind::Package,
        _ => Kind::Other(format!("neither its first bytes nor its name `.{extension}` are known")),
    }
}

/// Formats that are known not to be ours.
fn foreign(head: &[u8]) -> Option<String> {
    let known: [(&[u8], &str); 9] = [
        (b"version https://git-lfs", "it is a Git LFS pointer, not the file itself"),
        (b"\xff\xfe", "it is UTF-16 text"),
        (b"\xfe\xff", "it is UTF-16 text"),
        (b"ply", "it is a PLY file"),
        (b"OFF", "it is an OFF file"),
        (b"\x00\x05\x16\x07", "it is an AppleDouble side file of macOS"),
        (b"ISO-10303-21", "it is a STEP file"),
        (b"<", "it is XML outside a package (AMF?)"),
        (b"%PDF", "it is a PDF file"),
    ];
    known.iter().find(|(start, _)| trimmed(head).starts_with(start)).map(|(_, what)| (*what).to_owned())
}

/// Whether the head reads `solid`, after a byte order mark, white space and comments.
pub(super) fn starts_like_text_stl(head: &[u8]) -> bool {
    let start = trimmed(head);
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid")
}

/// Whether the head is text: no control characters but white space.
pub(super) fn is_text(head: &[u8]) -> bool {
    !head.is_empty() && head.iter().all(|&b| b >= 0x20 && b != 0x7f || b.is_ascii_whitespace() || b == 0x0b)
}

/// Whether a head that starts with `solid` is binary all the same: what stands where a binary file has its count is no text,
/// and no facet follows as a word. Such a file is torn, as its size is not what the count asks for.
fn claims_binary_facets(head: &[u8]) -> bool {
    let count_is_text = head.get(80..84).is_none_or(is_text);
    !count_is_text && starts_like_text_stl(head) && !contains_word(&head[84..], b"facet")
}

fn contains_word(head: &[u8], word: &[u8]) -> bool {
    head.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word))
}

/// Without the byte order mark, white space and `#` comments in front.
fn trimmed(head: &[u8]) -> &[u8] {
    let mut rest = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    while rest.starts_with(b"#") {
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        rest = rest[end..].trim_ascii_start();
    }
    rest
}
