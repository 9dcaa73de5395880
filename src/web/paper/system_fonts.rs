//! Fonts of the system, for the letters that the font of labels lacks: their outlines are drawn, so that no font is embedded.

use std::{
    cmp::Reverse,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

use pdf_writer::Content;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Endings of files that hold fonts.
const ENDINGS: [&str; 4] = ["ttf", "otf", "ttc", "otc"];
/// The folders of data where `XDG_DATA_DIRS` is not set.
const USUAL_FOLDERS: &str = "/usr/local/share:/usr/share";
/// Most files that are looked at, most folders in each other, and the largest file, bytes.
const MAX_FILES: usize = 4000;
const MAX_DEPTH: usize = 6;
const MAX_BYTES: u64 = 64 << 20;
/// Most fonts that are used together.
const MAX_FONTS: usize = 3;

/// A font of the system: its file, and its place in it.
pub(super) struct SystemFont {
    bytes: Vec<u8>,
    index: u32,
}

impl SystemFont {
    /// The font; `None` = the file holds none at that place.
    pub(super) fn face(&self) -> Option<Face<'_>> {
        Face::parse(&self.bytes, self.index).ok()
    }
}

/// The folders in which systems keep fonts: `fonts` of each folder of data (XDG Base Directory Specification).
pub(super) fn font_folders() -> Vec<PathBuf> {
    let folders = std::env::var_os("XDG_DATA_DIRS").filter(|folders| !folders.is_empty());
    let folders = folders.unwrap_or_else(|| OsString::from(USUAL_FOLDERS));
    std::env::split_paths(&folders).map(|folder| folder.join("fonts")).collect()
}

/// Fonts that together have as many of these letters as those of the folders can; few, and plain ones first.
pub(super) fn fonts_with(letters: &[char], folders: &[PathBuf]) -> Vec<SystemFont> {
    let mut files = Vec::new();
    for folder in folders {
        collect_files(folder, MAX_DEPTH, &mut files);
    }
    files.sort_by_cached_key(|(path, bytes)| (preference(path), Reverse(*bytes), path.clone()));
    let (mut fonts, mut missing) = (Vec::new(), letters.to_vec());
    for (path, _) in files {
        if missing.is_empty() || fonts.len() == MAX_FONTS {
            break;
        }
        let Ok(bytes) = fs::read(&path) else { continue };
        let count = ttf_parser::fonts_in_collection(&bytes).unwrap_or(1);
        let lacks = |index: u32| -> Option<Vec<char>> {
            let face = Face::parse(&bytes, index).ok()?;
            Some(missing.iter().copied().filter(|letter| face.glyph_index(*letter).is_none()).collect())
        };
        let best = (0..count).filter_map(|index| Some((lacks(index)?, index))).min_by_key(|(lacks, _)| lacks.len());
        if let Some((lacks, index)) = best.filter(|(lacks, _)| lacks.len() < missing.len()) {
            missing = lacks;
            fonts.push(SystemFont { bytes, index });
        }
    }
    fonts
}

/// The files of fonts below a folder, with their sizes.
fn collect_files(folder: &Path, depth: usize, files: &mut Vec<(PathBuf, u64)>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let (path, Ok(kind)) = (entry.path(), fs::metadata(entry.path())) else { continue };
        if kind.is_dir() && depth > 0 {
            collect_files(&path, depth - 1, files);
        }
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
        if kind.is_file() && kind.len() <= MAX_BYTES && ENDINGS.contains(&ending.as_str()) && files.len() < MAX_FILES {
            files.push((path, kind.len()));
        }
    }
}

/// Low for what goes with the font of labels: an upright one without serifs, of a usual weight.
fn preference(path: &Path) -> u8 {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let is = |words: &[&str]| words.iter().any(|word| name.contains(word));
    u8::from(is(&["italic", "oblique", "bold", "black", "thin", "light"]))
        + 2 * u8::from(is(&["serif", "mincho", "mono"]) && !name.contains("sans"))
}

/// Draws the outline of a glyph with its origin at a place, `size` points high, as paths to be filled.
pub(super) fn draw_glyph(content: &mut Content, face: &Face<'_>, glyph: GlyphId, origin: [f64; 2], size: f64) {
    let scale = (size / f64::from(face.units_per_em())) as f32;
    let mut pen = Pen { content, origin: origin.map(|at| at as f32), scale, at: [0.0; 2] };
    face.outline_glyph(glyph, &mut pen);
    pen.content.fill_nonzero();
}

/// Puts an outline into the content of a page.
struct Pen<'c> {
    content: &'c mut Content,
    origin: [f32; 2],
    scale: f32,
    /// Where it is, in units of the font.
    at: [f32; 2],
}

impl Pen<'_> {
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        [self.origin[0] + self.scale * x, self.origin[1] + self.scale * y]
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let [px, py] = self.place(x, y);
        self.content.move_to(px, py);
        self.at = [x, y];
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let [px, py] = self.place(x, y);
        self.content.line_to(px, py);
        self.at = [x, y];
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        // A quadratic curve as a cubic one: its inner points are two thirds of the way to that of the quadratic one.
        let near = |end: f32, middle: f32| end + 2.0 / 3.0 * (middle - end);
        let [ax, ay] = self.at;
        self.curve_to(near(ax, x1), near(ay, y1), near(x, x1), near(y, y1), x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ([ax, ay], [bx, by], [cx, cy]) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.content.cubic_to(ax, ay, bx, by, cx, cy);
        self.at = [x, y];
    }

    fn close(&mut self) {
        self.content.close_path();
    }
}

/// A small font for tests: a triangle for each letter, 1000 units wide.
#[cfg(test)]
pub(super) fn triangle_font(letters: &[char]) -> Vec<u8> {
    let be = |values: &[u16]| -> Vec<u8> { values.iter().flat_map(|value| value.to_be_bytes()).collect() };
    let glyphs = letters.len() as u16 + 1;
    // One contour of three points on the curve: flags, then steps of x and of y.
    let mut glyph = be(&[1, 0, 0, 800, 800, 2, 0]);
    glyph.extend([1, 1, 1]);
    glyph.extend(be(&[0, 800, 0xFFFF - 399, 0, 0, 800]));
    glyph.resize(glyph.len().next_multiple_of(4), 0);
    let step = glyph.len() as u16 / 2;
    let mut sorted = letters.to_vec();
    sorted.sort_unstable();
    let mut groups = Vec::new();
    for (at, letter) in sorted.iter().enumerate() {
        groups.extend(
            [u32::from(*letter), u32::from(*letter), at as u32 + 1].iter().flat_map(|value| value.to_be_bytes()),
        );
    }
    let mut cmap = be(&[0, 1, 3, 10, 0, 12, 12, 0]);
    cmap.extend([16 + groups.len() as u32, 0, sorted.len() as u32].iter().flat_map(|value| value.to_be_bytes()));
    cmap.extend(groups);
    let mut head = vec![0; 54];
    head[18..20].copy_from_slice(&1000_u16.to_be_bytes());
    let mut hhea = vec![0; 36];
    hhea[4..6].copy_from_slice(&800_u16.to_be_bytes());
    hhea[34..36].copy_from_slice(&1_u16.to_be_bytes());
    let hmtx = be(&[&[1000, 0][..], &vec![0; usize::from(glyphs) - 1]].concat());
    let maxp = [vec![0, 1, 0, 0], glyphs.to_be_bytes().to_vec(), vec![0; 26]].concat();
    let loca = be(&(0..=glyphs).map(|at| at * step).collect::<Vec<_>>());
    let glyf = glyph.repeat(usize::from(glyphs));
    let tables: [(&[u8; 4], Vec<u8>); 7] = [
        (b"cmap", cmap),
        (b"glyf", glyf),
        (b"head", head),
        (b"hhea", hhea),
        (b"hmtx", hmtx),
        (b"loca", loca),
        (b"maxp", maxp),
    ];
    let mut font = [vec![0, 1, 0, 0], (tables.len() as u16).to_be_bytes().to_vec(), vec![0; 6]].concat();
    let mut offset = 12 + 16 * tables.len();
    for (name, table) in &tables {
        font.extend(*name);
        font.extend([0, offset as u32, table.len() as u32].iter().flat_map(|value: &u32| value.to_be_bytes()));
        offset += table.len().next_multiple_of(4);
    }
    for (_, table) in &tables {
        font.extend(table);
        font.resize(font.len().next_multiple_of(4), 0);
    }
    font
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fonts_of_folders_are_found_by_what_they_have_and_few_are_taken() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("truetype/japanese");
        fs::create_dir_all(&inner).unwrap();
        fs::write(inner.join("gothic.ttf"), triangle_font(&['試', '作', '品'])).unwrap();
        fs::write(inner.join("gothic-bold.ttf"), triangle_font(&['試', '作', '品', '株'])).unwrap();
        fs::write(inner.join("broken.ttf"), b"no font").unwrap();
        let folders = [folder.path().to_owned(), PathBuf::from("/nonexistent")];
        let found = |letters: &[char]| fonts_with(letters, &folders).len();
        assert_eq!((found(&['試', '品']), found(&['試', '株']), found(&['式'])), (1, 2, 0));
        let font = &fonts_with(&['試'], &folders)[0];
        let face = font.face().unwrap();
        let mut content = Content::new();
        draw_glyph(&mut content, &face, face.glyph_index('試').unwrap(), [100.0, 50.0], 10.0);
        let drawn = String::from_utf8(content.finish().to_vec()).unwrap();
        assert_eq!(drawn.split_whitespace().collect::<Vec<_>>().join(" "), "100 50 m 108 50 l 104 58 l 100 50 l h f");
    }
}
