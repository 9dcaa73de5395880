//! The lists of vertices and triangles of a written model, read without an XML parser. They are nearly all of its text: the second reader
//! gets the text without them, and in the place of each mesh the number of its lists.

use std::{
    fs::File,
    io::{self, BufReader, Cursor, Read, Write},
    path::Path,
};

use zip::{CompressionMethod, ZipArchive, ZipWriter, result::ZipResult, write::SimpleFileOptions};

/// Bytes that are read at once.
const WINDOW_BYTES: usize = 1 << 17;
/// No line of a list is longer: the shortest digits of three numbers without an exponent have at most 1100 bytes.
const LINE_BYTES: usize = 1 << 11;

/// A mesh as its lists describe it.
#[derive(Debug, Default)]
pub(super) struct ListedMesh {
    /// Corners in the frame of the object, in the unit of the file, in the order of the file.
    pub(super) corners: Vec<[f64; 3]>,
    /// Indices of corners, which need not exist.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A package without long lists.
pub(super) struct ShortPackage {
    /// The package. A mesh whose lists were cut out has no triangles and one vertex: its x is an index into `meshes`.
    pub(super) package: Cursor<Vec<u8>>,
    /// The lists.
    pub(super) meshes: Vec<ListedMesh>,
}

impl ShortPackage {
    /// Cuts the lists out of the models of a package. `None` if a list is not written as nestd writes it: one element on each line, with
    /// its attributes in the order of the specification.
    ///
    /// # Errors
    /// The file cannot be read or is no ZIP package.
    pub(super) fn read(file: &Path) -> ZipResult<Option<Self>> {
        let mut archive = ZipArchive::new(BufReader::new(File::open(file)?))?;
        let mut package = ZipWriter::new(Cursor::new(Vec::new()));
        let mut meshes = Vec::new();
        let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        for index in 0..archive.len() {
            let name = archive.by_index_raw(index)?.name().to_owned();
            if !name.ends_with(".model") {
                package.raw_copy_file(archive.by_index_raw(index)?)?;
                continue;
            }
            package.start_file(name, plain)?;
            if !cut_lists(archive.by_index(index)?, &mut meshes, &mut package)? {
                return Ok(None);
            }
        }
        Ok(Some(Self { package: package.finish()?, meshes }))
    }
}

/// Copies a model without its lists, which are added to `meshes`. Returns false if one is in another form.
fn cut_lists(model: impl Read, meshes: &mut Vec<ListedMesh>, out: &mut impl Write) -> io::Result<bool> {
    let mut text = TextWindow { input: model, bytes: Vec::new(), at: 0, is_read: false };
    let mut is_line_start = true;
    loop {
        if is_line_start && text.take_line(b"<vertices>\n")? {
            let Some(mesh) = read_lists(&mut text)? else { return Ok(false) };
            let number = meshes.len();
            writeln!(out, r#"<vertices><vertex x="{number}" y="0" z="0"/></vertices><triangles></triangles>"#)?;
            meshes.push(mesh);
            continue;
        }
        let rest = text.rest()?;
        if rest.is_empty() {
            return Ok(true);
        }
        let line_end = rest.iter().position(|&byte| byte == b'\n');
        let length = line_end.map_or(rest.len(), |at| at + 1);
        is_line_start = line_end.is_some();
        out.write_all(&rest[..length])?;
        text.at += length;
    }
}

/// Reads the lists of a mesh, from the first vertex to the end of the triangles.
fn read_lists(text: &mut TextWindow<impl Read>) -> io::Result<Option<ListedMesh>> {
    let mut mesh = ListedMesh::default();
    while let Some((corner, length)) = vertex_line(text.rest()?) {
        mesh.corners.push(corner);
        text.at += length;
    }
    if !text.take_line(b"</vertices>\n")? || !text.take_line(b"<triangles>\n")? {
        return Ok(None);
    }
    while let Some((triangle, length)) = triangle_line(text.rest()?) {
        mesh.triangles.push(triangle);
        text.at += length;
    }
    let is_whole = text.take_line(b"</triangles>\n")? && !mesh.triangles.is_empty();
    Ok(is_whole.then_some(mesh))
}

/// The corner on a line and the length of the line, bytes.
fn vertex_line(text: &[u8]) -> Option<([f64; 3], usize)> {
    let (x, rest) = decimal(text.strip_prefix(br#"<vertex x=""#)?)?;
    let (y, rest) = decimal(rest.strip_prefix(br#"" y=""#)?)?;
    let (z, rest) = decimal(rest.strip_prefix(br#"" z=""#)?)?;
    let rest = rest.strip_prefix(b"\"/>\n")?;
    Some(([x, y, z], text.len() - rest.len()))
}

/// The triangle on a line and the length of the line, bytes.
fn triangle_line(text: &[u8]) -> Option<([u32; 3], usize)> {
    let (a, rest) = index(text.strip_prefix(br#"<triangle v1=""#)?)?;
    let (b, rest) = index(rest.strip_prefix(br#"" v2=""#)?)?;
    let (c, rest) = index(rest.strip_prefix(br#"" v3=""#)?)?;
    let rest = rest.strip_prefix(b"\"/>\n")?;
    Some(([a, b, c], text.len() - rest.len()))
}

fn decimal(text: &[u8]) -> Option<(f64, &[u8])> {
    let (number, length) = fast_float2::parse_partial::<f64, _>(text).ok()?;
    number.is_finite().then(|| (number, &text[length..]))
}

fn index(text: &[u8]) -> Option<(u32, &[u8])> {
    let length = text.iter().take_while(|byte| byte.is_ascii_digit()).take(10).count();
    let number = text[..length].iter().fold(0, |number, digit| 10 * number + u64::from(digit - b'0'));
    (length > 0).then_some((u32::try_from(number).ok()?, &text[length..]))
}

/// A text that is read in pieces, of which each line of a list is whole in memory.
struct TextWindow<R> {
    input: R,
    bytes: Vec<u8>,
    /// Where the text goes on in `bytes`.
    at: usize,
    /// Whether the end of the text is in `bytes`.
    is_read: bool,
}

impl<R: Read> TextWindow<R> {
    /// What follows: at least [`LINE_BYTES`], unless the text ends.
    fn rest(&mut self) -> io::Result<&[u8]> {
        if self.bytes.len() - self.at < LINE_BYTES && !self.is_read {
            self.bytes.drain(..self.at);
            self.at = 0;
            let wanted = WINDOW_BYTES - self.bytes.len();
            let got = (&mut self.input).take(wanted as u64).read_to_end(&mut self.bytes)?;
            self.is_read = got < wanted;
        }
        Ok(&self.bytes[self.at..])
    }

    /// Goes past a line if it follows.
    fn take_line(&mut self, line: &[u8]) -> io::Result<bool> {
        let follows = self.rest()?.starts_with(line);
        self.at += if follows { line.len() } else { 0 };
        Ok(follows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESH: &str = "<mesh>\n<vertices>\n<vertex x=\"-1.5\" y=\"0\" z=\"0.0000001\"/>\n</vertices>\n<triangles>\n\
                        <triangle v1=\"0\" v2=\"4294967295\" v3=\"7\"/>\n</triangles>\n</mesh>\n";

    fn cut(text: &str) -> Option<(String, Vec<ListedMesh>)> {
        let (mut meshes, mut out) = (Vec::new(), Vec::new());
        let is_cut = cut_lists(text.as_bytes(), &mut meshes, &mut out).unwrap();
        is_cut.then(|| (String::from_utf8(out).unwrap(), meshes))
    }

    #[test]
    fn each_mesh_leaves_its_number() {
        let (text, meshes) = cut(&format!("<a/>\n{MESH}<b>\n{MESH}</b>")).unwrap();
        let left = |number| {
            format!(
                "<mesh>\n<vertices><vertex x=\"{number}\" y=\"0\" z=\"0\"/></vertices><triangles></triangles>\n</mesh>\n"
            )
        };
        assert_eq!(text, format!("<a/>\n{}<b>\n{}</b>", left(0), left(1)));
        assert_eq!((meshes[1].corners[0], meshes[1].triangles[0]), ([-1.5, 0.0, 1e-7], [0, u32::MAX, 7]));
    }

    #[test]
    fn lists_longer_than_the_window_are_read_whole() {
        let vertices: String = (0..9000).map(|n| format!("<vertex x=\"{n}\" y=\"{n}.25\" z=\"0\"/>\n")).collect();
        let many = MESH.replace("<vertices>\n", &format!("<vertices>\n{vertices}"));
        let (_, meshes) = cut(&many).unwrap();
        assert_eq!(meshes[0].corners.len(), 9001);
        assert!((0..9000).all(|n| meshes[0].corners[n] == [n as f64, n as f64 + 0.25, 0.0]));
    }

    #[test]
    fn lists_in_another_form_are_left_to_the_parser() {
        for (from, to) in [
            ("x=\"-1.5\" y=\"0\"", "y=\"0\" x=\"-1.5\""),
            ("0.0000001", "nan"),
            ("\"0.0000001\"", "\"0.0000001 \""),
            ("4294967295", "4294967296"),
            ("v3=\"7\"", "v3=\"7\" p1=\"1\""),
            ("v3=\"7\"", "v3=\"\""),
            ("</vertices>\n", "</vertices> "),
            ("<triangle v1=\"0\" v2=\"4294967295\" v3=\"7\"/>\n", ""),
            ("</triangles>\n</mesh>\n", ""),
        ] {
            assert!(MESH.contains(from) && cut(&MESH.replace(from, to)).is_none(), "{to}");
        }
    }
}
