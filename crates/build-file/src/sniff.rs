//! Which format a file is in: by its first bytes and its size, then by its name.

use super::{
    number::decimal,
    stl_read::{binary_len, claimed_count},
};

/// Bytes of the head that the decision needs.
pub(super) const HEAD_BYTES: u64 = 1024;

/// What a file is taken for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    /// A ZIP package, so a 3MF if anything.
    Package,
    TextStl,
    BinaryStl,
    /// Nothing that we read.
    Other(Foreign),
}

/// A file that is none of ours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Foreign {
    /// What it looks like.
    pub(super) what: String,
    /// What gives a file that can be read; a sentence.
    pub(super) remedy: &'static str,
}

/// Of a solid or mesh in another format.
const EXPORT: &str = "Export the part from the CAD program as STL or 3MF, and drop that.";
/// Of packed files.
const UNPACK: &str = "Unpack it, and drop the STL or 3MF files that are in it.";
/// Of text in 16 bits a character.
const AS_TEXT: &str = "Save it as plain text (ASCII or UTF-8), or export the part as binary STL.";
/// Of what holds no shape.
const NO_SHAPE: &str = "It holds no shape to print: drop the part as STL or 3MF.";
/// Of what nobody knows.
const UNKNOWN: &str = "Drop STL or 3MF files, named so; export other formats from the CAD program.";

/// Decides from the head (up to [`HEAD_BYTES`]), the size and the dropped name.
pub(super) fn kind(head: &[u8], len: u64, name: &str) -> Kind {
    let extension = name.rsplit_once('.').map_or(String::new(), |(_, e)| e.to_ascii_lowercase());
    if len == 0 {
        return other("the file is empty", "Copy it once more; where the original is empty too, export it again.");
    }
    let exact = claimed_count(head).is_some_and(|count| count > 0 && binary_len(count) == len);
    if exact {
        return Kind::BinaryStl;
    }
    if head.starts_with(b"PK\x03\x04") {
        return match extension.as_str() {
            "3mf" | "stl" | "zip" | "" => Kind::Package,
            "amf" => other("it is a packed AMF file", EXPORT),
            named => {
                foreign_name(named).unwrap_or_else(|| other(format!("it is a ZIP package named `.{named}`"), UNPACK))
            }
        };
    }
    if let Some(foreign) = foreign(head) {
        return foreign;
    }
    if claims_binary_facets(head) {
        return Kind::BinaryStl;
    }
    if starts_like_text_stl(head) || (is_text(head) && contains_word(head, b"facet")) {
        return Kind::TextStl;
    }
    match extension.as_str() {
        "stl" if is_text(head) && head.len() > 84 => other("it is text without `solid`", EXPORT),
        "stl" => Kind::BinaryStl,
        // A package may follow other bytes; the reader finds its directory at the end or says that there is none.
        "3mf" => Kind::Package,
        "" => other("its first bytes are not known, and its name has no ending", UNKNOWN),
        _ => foreign_name(&extension).unwrap_or_else(|| {
            other(format!("neither its first bytes nor its name `.{extension}` are known"), UNKNOWN)
        }),
    }
}

fn other(what: impl Into<String>, remedy: &'static str) -> Kind {
    Kind::Other(Foreign { what: what.into(), remedy })
}

/// Formats that are known not to be ours, by their first bytes.
fn foreign(head: &[u8]) -> Option<Kind> {
    let known: [(&[u8], &str, &'static str); 12] = [
        (
            b"version https://git-lfs",
            "it is a Git LFS pointer, not the file itself",
            "Run `git lfs pull`, then drop it.",
        ),
        (b"\xff\xfe", "it is UTF-16 text", AS_TEXT),
        (b"\xfe\xff", "it is UTF-16 text", AS_TEXT),
        (b"ply", "it is a PLY file", EXPORT),
        (b"OFF", "it is an OFF file", EXPORT),
        (b"\x00\x05\x16\x07", "it is an AppleDouble side file of macOS", "Drop the file that it belongs to."),
        (b"ISO-10303-21", "it is a STEP file", EXPORT),
        (b"glTF", "it is a glTF file", EXPORT),
        (b"<", "it is XML outside a package (AMF?)", EXPORT),
        (b"%PDF", "it is a PDF file", NO_SHAPE),
        (b"\x89PNG", "it is a picture", NO_SHAPE),
        (b"\xff\xd8\xff", "it is a picture", NO_SHAPE),
    ];
    let start = trimmed(head);
    let by_bytes = known.iter().find(|(bytes, ..)| start.starts_with(bytes));
    let by_bytes = by_bytes.map(|(_, what, remedy)| other(*what, remedy));
    by_bytes.or_else(|| looks_like_obj(start).then(|| other("it is an OBJ file", EXPORT)))
}

/// Formats whose names say that they are not ours.
fn foreign_name(extension: &str) -> Option<Kind> {
    let (what, remedy) = match extension {
        "rar" | "7z" | "gz" | "tar" | "tgz" => ("it is an archive", UNPACK),
        "step" | "stp" | "iges" | "igs" | "sldprt" | "sldasm" | "ipt" | "f3d" | "x_t" | "catpart" | "obj" => {
            ("it is a file of a CAD program", EXPORT)
        }
        "gcode" | "sla" | "cli" => ("it is a file for a printer, not a part", EXPORT),
        "doc" | "docx" | "xls" | "xlsx" | "txt" | "md" | "csv" => ("it holds words, not a shape", NO_SHAPE),
        _ => return None,
    };
    Some(other(format!("{what} (`.{extension}`)"), remedy))
}

/// Whether the first lines are vertices as OBJ writes them.
fn looks_like_obj(start: &[u8]) -> bool {
    let is_vertex = |line: &[u8]| {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        words.next() == Some(b"v") && words.take(3).filter(|word| decimal(word).is_some()).count() == 3
    };
    is_text(start) && start.split(|&b| b == b'\n' || b == b'\r').any(is_vertex)
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
