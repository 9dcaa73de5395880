//! Detects the format of a file by its first bytes and its size, then by its name.

use crate::{
    common::{
        decimal::parse_decimal,
        file_name::{CAMSPEC_ENDING, cad_formats},
    },
    stl::stl_read::{binary_len, claimed_count},
};

/// Length of the file's head that the detection needs, bytes.
pub(super) const HEAD_BYTES: u64 = 1024;

/// The detected format of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum FileFormat {
    /// A ZIP package, possibly a 3MF.
    Package,
    /// A CAMSPEC package: models with what is asked of them.
    Camspec,
    TextStl,
    BinaryStl,
    Obj,
    Ply,
    /// A format that is not supported.
    Other(ForeignFormat),
}

/// A file in an unsupported format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ForeignFormat {
    /// What the file looks like.
    pub(crate) what: String,
    /// How to get a readable file; a sentence.
    pub(crate) remedy: &'static str,
}

/// Remedy for a solid or mesh in another format.
const EXPORT_REMEDY: &str = concat!("Export the part from the CAD program as ", cad_formats!(), ", and drop that.");
/// Remedy for packed files.
const UNPACK_REMEDY: &str = concat!("Unpack it, and drop the ", cad_formats!(), " files that are in it.");
/// Remedy for text with 16 bits per character.
const PLAIN_TEXT_REMEDY: &str = "Save it as plain text (ASCII or UTF-8), or export the part as binary STL.";
/// Remedy for files without a shape.
const NO_SHAPE_REMEDY: &str = concat!("It holds no shape to print: drop the part as ", cad_formats!(), ".");
/// Remedy for a page that a server sent in place of a file.
const WEB_PAGE_REMEDY: &str =
    "Open it in a browser to read what the server said, sign in there, download the part again, and drop that.";
/// Remedy for unknown files.
const UNKNOWN_REMEDY: &str =
    concat!("Drop ", cad_formats!(), " files with the right extension; export other formats from the CAD program.");

/// Detects the format from the head (up to [`HEAD_BYTES`]), the size and the dropped name.
pub(super) fn detect_format(head: &[u8], len: u64, name: &str) -> FileFormat {
    let extension = name.rsplit_once('.').map_or(String::new(), |(_, e)| e.to_ascii_lowercase());
    if len == 0 {
        return foreign_format(
            "the file is empty",
            "Copy it once more; where the original is empty too, export it again.",
        );
    }
    let exact = claimed_count(head).is_some_and(|count| count > 0 && binary_len(count) == len);
    if exact {
        return FileFormat::BinaryStl;
    }
    if head.starts_with(b"PK\x03\x04") {
        return match extension.as_str() {
            "3mf" | "stl" | "zip" | "" => FileFormat::Package,
            CAMSPEC_ENDING => FileFormat::Camspec,
            "amf" => foreign_format("it is a packed AMF file", EXPORT_REMEDY),
            named => foreign_by_name(named)
                .unwrap_or_else(|| foreign_format(format!("it is a ZIP package named `.{named}`"), UNPACK_REMEDY)),
        };
    }
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return FileFormat::Ply;
    }
    if let Some(foreign) = foreign_by_bytes(head) {
        return foreign;
    }
    if looks_like_obj(skip_leading_noise(head)) {
        return FileFormat::Obj;
    }
    if claims_binary_facets(head) {
        return FileFormat::BinaryStl;
    }
    if starts_like_text_stl(head) || (is_text(head) && contains_word(head, b"facet")) {
        return FileFormat::TextStl;
    }
    match extension.as_str() {
        "stl" if is_text(head) && head.len() > 84 => foreign_format("it is text without `solid`", EXPORT_REMEDY),
        "stl" => FileFormat::BinaryStl,
        // Its first lines may be words for colours alone.
        "obj" if is_text(without_zeros(head)) => FileFormat::Obj,
        "obj" => foreign_format("it is no text, as an OBJ file is", EXPORT_REMEDY),
        "ply" => foreign_format("it does not begin with the line `ply`", EXPORT_REMEDY),
        // A package may begin after other bytes; the reader finds its directory at the end or reports that it is
        // missing.
        "3mf" => FileFormat::Package,
        "" => foreign_format("its first bytes are not known, and its name has no extension", UNKNOWN_REMEDY),
        _ => foreign_by_name(&extension).unwrap_or_else(|| {
            foreign_format(format!("neither its first bytes nor its name `.{extension}` are known"), UNKNOWN_REMEDY)
        }),
    }
}

fn foreign_format(what: impl Into<String>, remedy: &'static str) -> FileFormat {
    FileFormat::Other(ForeignFormat { what: what.into(), remedy })
}

/// Unsupported formats, recognised by their first bytes.
fn foreign_by_bytes(head: &[u8]) -> Option<FileFormat> {
    let known: [(&[u8], &str, &'static str); 11] = [
        (
            b"version https://git-lfs",
            "it is a Git LFS pointer, not the file itself",
            "Run `git lfs pull`, then drop it.",
        ),
        (b"\xff\xfe", "it is UTF-16 text", PLAIN_TEXT_REMEDY),
        (b"\xfe\xff", "it is UTF-16 text", PLAIN_TEXT_REMEDY),
        (b"OFF", "it is an OFF file", EXPORT_REMEDY),
        (b"\x00\x05\x16\x07", "it is an AppleDouble side file of macOS", "Drop the file that it belongs to."),
        (b"ISO-10303-21", "it is a STEP file", EXPORT_REMEDY),
        (b"glTF", "it is a glTF file", EXPORT_REMEDY),
        (b"<", "it is XML outside a package (AMF?)", EXPORT_REMEDY),
        (b"%PDF", "it is a PDF file", NO_SHAPE_REMEDY),
        (b"\x89PNG", "it is a picture", NO_SHAPE_REMEDY),
        (b"\xff\xd8\xff", "it is a picture", NO_SHAPE_REMEDY),
    ];
    let start = skip_leading_noise(head);
    if is_web_page(start) {
        return Some(foreign_format("it is a web page (HTML), not the part itself", WEB_PAGE_REMEDY));
    }
    let by_bytes = known.iter().find(|(bytes, ..)| start.starts_with(bytes));
    by_bytes.map(|(_, what, remedy)| foreign_format(*what, remedy))
}

/// Whether markup is that of a web page. XML of other kinds may stand before it.
fn is_web_page(start: &[u8]) -> bool {
    start.starts_with(b"<")
        && [&b"<!doctype html"[..], b"<html", b"<head>", b"<body"].iter().any(|tag| contains_word(start, tag))
}

/// Unsupported formats, recognised by their names.
fn foreign_by_name(extension: &str) -> Option<FileFormat> {
    let (what, remedy) = match extension {
        "rar" | "7z" | "gz" | "tar" | "tgz" => ("it is an archive", UNPACK_REMEDY),
        "step" | "stp" | "iges" | "igs" | "sldprt" | "sldasm" | "ipt" | "f3d" | "x_t" | "catpart" => {
            ("it is a file of a CAD program", EXPORT_REMEDY)
        }
        "mtl" => ("it holds the colours of an OBJ file", "Delete it: the OBJ file is read without colours."),
        "gcode" | "sla" | "cli" => ("it is a file for a printer, not a part", EXPORT_REMEDY),
        "doc" | "docx" | "xls" | "xlsx" | "txt" | "md" | "csv" => ("it holds text, not a shape", NO_SHAPE_REMEDY),
        _ => return None,
    };
    Some(foreign_format(format!("{what} (`.{extension}`)"), remedy))
}

/// Whether the first lines are vertices as OBJ writes them.
fn looks_like_obj(start: &[u8]) -> bool {
    let is_vertex = |line: &[u8]| {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        words.next() == Some(b"v") && words.take(3).filter(|word| parse_decimal(word).is_some()).count() == 3
    };
    is_text(start) && start.split(|&b| b == b'\n' || b == b'\r').any(is_vertex)
}

/// Whether the head starts with `solid`, after a byte order mark, white space and comments.
pub(super) fn starts_like_text_stl(head: &[u8]) -> bool {
    let start = skip_leading_noise(head);
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid")
}

/// The head without the zeros of blocks that are not written yet.
fn without_zeros(head: &[u8]) -> &[u8] {
    &head[..head.iter().rposition(|&byte| byte != 0).map_or(0, |at| at + 1)]
}

/// Whether the head is text: no control characters but white space.
pub(super) fn is_text(head: &[u8]) -> bool {
    !head.is_empty() && head.iter().all(|&b| b >= 0x20 && b != 0x7f || b.is_ascii_whitespace() || b == 0x0b)
}

/// Whether a head that starts with `solid` is binary nevertheless: the bytes of the triangle count are not text, and no
/// word `facet` follows. Such a file is damaged, since its size does not match the count.
fn claims_binary_facets(head: &[u8]) -> bool {
    let count_is_text = head.get(80..84).is_none_or(is_text);
    !count_is_text && starts_like_text_stl(head) && !contains_word(&head[84..], b"facet")
}

fn contains_word(head: &[u8], word: &[u8]) -> bool {
    head.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word))
}

/// Skips a byte order mark, white space and `#` comments.
fn skip_leading_noise(head: &[u8]) -> &[u8] {
    let mut rest = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    while rest.starts_with(b"#") {
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        rest = rest[end..].trim_ascii_start();
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_web_page_is_called_one_whatever_its_name_and_how_it_begins() {
        let what = |head: &str, name: &str| match detect_format(head.as_bytes(), head.len() as u64, name) {
            FileFormat::Other(foreign) => foreign.what,
            other => format!("{other:?}"),
        };
        for head in [
            "<!DOCTYPE html>\n<html><body>404</body></html>",
            "\u{feff}\n<html lang=\"en\">",
            "<?xml version=\"1.0\"?><!DOCTYPE html PUBLIC \"x\"><html>",
            "<!-- saved --><HTML>",
            "<head><title>Sign in</title></head>",
        ] {
            for name in ["a.stl", "a.3mf", "a.obj", "a.ply", "a"] {
                assert_eq!(what(head, name), "it is a web page (HTML), not the part itself", "{head} as {name}");
            }
        }
        assert_eq!(what("<?xml version=\"1.0\"?><amf unit=\"inch\">", "a.stl"), "it is XML outside a package (AMF?)");
    }
}
