//! Reads an OBJ file as one part. Colours, normals and groups mean nothing to a printer and are passed over.
//!
//! It is read line by line, so that an error names its line, names of any code page pass, and no more than the corners is in memory.

use std::{
    collections::BTreeSet,
    fs::File,
    io::{BufRead, BufReader, Read, Seek, SeekFrom},
};

use glam::DVec3;

use super::{PolygonSurface, TRIANGLES_ONLY};
use crate::{
    FileReadError, LengthUnit, PartFileContents, ReadLimits,
    common::{
        decimal::parse_decimal,
        unfinished::{ends_in_zero, unfinished_copy},
    },
    escape_invisible, format_count,
};

/// A longer line is no line of an OBJ file.
const MAX_LINE_BYTES: u64 = 1 << 20;
/// Words of lines that are named in a warning.
const MAX_UNKNOWN: usize = 5;
/// Words of lines that say how a surface looks, or how its lines are sorted.
const PASSED_OVER: [&[u8]; 24] = [
    b"vt",
    b"vn",
    b"vp",
    b"o",
    b"g",
    b"s",
    b"mg",
    b"mtllib",
    b"usemtl",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"ctech",
    b"stech",
    b"end",
];
/// Words of lines that hold lines and points.
const WITHOUT_AREA: [&[u8]; 2] = [b"l", b"p"];
/// Words of lines that hold surfaces which are no faces, and of those that name another file.
const NOT_READ: [(&[u8], &str); 6] = [
    (b"surf", "it holds a free-form surface"),
    (b"curv", "it holds a free-form curve"),
    (b"curv2", "it holds a free-form curve"),
    (b"bzp", "it holds a free-form surface"),
    (b"bsp", "it holds a free-form surface"),
    (b"call", "it names another file that belongs to it"),
];

/// Reads a file; `name` is its name without the ending.
pub(crate) fn read_obj(
    mut file: File,
    name: String,
    unit: LengthUnit,
    limits: &ReadLimits,
) -> Result<PartFileContents, FileReadError> {
    let len = file.metadata()?.len();
    if ends_in_zero(&mut file, len)? {
        return Err(unfinished_copy("which ends in zeros"));
    }
    file.seek(SeekFrom::Start(0))?;
    let mut input = BufReader::with_capacity(1 << 16, file);
    let mut reader = ObjReader::new(unit, limits);
    let mut line = Vec::new();
    while read_line(&mut input, &mut line, &mut reader.line)? {
        reader.take_line(&line)?;
    }
    let warnings = reader.warnings();
    if reader.faces.faces == 0 {
        return Err(reader.invalid("it holds no face: points and lines have nothing to print"));
    }
    Ok(PartFileContents { solids: vec![reader.faces.surface.into_solid(name)?], warnings })
}

/// Reads a line and what continues it; `false` at the end of the file. `number` counts the lines.
fn read_line(input: &mut impl BufRead, line: &mut Vec<u8>, number: &mut u64) -> Result<bool, FileReadError> {
    line.clear();
    loop {
        let before = line.len();
        input.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', line)?;
        if line.len() == before {
            return Ok(before > 0);
        }
        *number += 1;
        if line.len() as u64 >= MAX_LINE_BYTES {
            let reason = format!("line {number} is longer than {MAX_LINE_BYTES} bytes");
            return Err(FileReadError::Invalid { format: "OBJ", reason });
        }
        let text = line.trim_ascii_end().len();
        if text == 0 || line[text - 1] != b'\\' {
            return Ok(true);
        }
        line.truncate(text - 1);
        line.push(b' ');
    }
}

struct ObjReader<'l> {
    corners: Vec<DVec3>,
    faces: PolygonSurface<'l>,
    /// The number of the present line.
    line: u64,
    /// Lines that name an object.
    objects: u64,
    /// Lines and points.
    without_area: u64,
    unknown: BTreeSet<String>,
    /// The corners of the present face.
    face: Vec<DVec3>,
}

impl<'l> ObjReader<'l> {
    fn new(unit: LengthUnit, limits: &'l ReadLimits) -> Self {
        let faces = PolygonSurface::new("OBJ", unit, limits);
        let (corners, face, unknown) = (Vec::new(), Vec::new(), BTreeSet::new());
        Self { corners, faces, line: 0, objects: 0, without_area: 0, unknown, face }
    }

    fn take_line(&mut self, line: &[u8]) -> Result<(), FileReadError> {
        let is_whole = line.ends_with(b"\n");
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        let line = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        let mut words = line.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
        let taken = match words.next() {
            None => Ok(()),
            Some(b"v") => self.take_corner(words),
            Some(b"f" | b"fo") => self.take_face(words),
            Some(word) => self.take_other(word),
        };
        match taken {
            Err(FileReadError::Invalid { .. }) if !is_whole => {
                Err(FileReadError::Truncated(format!("it ends within line {}", self.line)))
            }
            taken => taken,
        }
    }

    fn take_corner<'w>(&mut self, mut words: impl Iterator<Item = &'w [u8]>) -> Result<(), FileReadError> {
        let mut number = || words.next().and_then(parse_decimal);
        let (Some(x), Some(y), Some(z)) = (number(), number(), number()) else {
            return Err(self.invalid("a corner is not three finite decimal numbers"));
        };
        if self.corners.len() as u64 >= self.faces.limits.max_triangles.saturating_mul(3) {
            return Err(FileReadError::too_many_triangles(self.faces.limits));
        }
        self.corners.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn take_face<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), FileReadError> {
        let mut face = std::mem::take(&mut self.face);
        face.clear();
        for word in words {
            let index = word.split(|&byte| byte == b'/').next().unwrap_or_default();
            face.push(self.corner_of(index)?);
        }
        if face.len() < 3 {
            return Err(self.invalid("a face has fewer than three corners"));
        }
        self.faces.add_face(&face)?;
        self.face = face;
        Ok(())
    }

    /// The corner of an index: 1 is the first of the file, -1 the last before the face.
    fn corner_of(&self, index: &[u8]) -> Result<DVec3, FileReadError> {
        let number: Option<i64> = std::str::from_utf8(index).ok().and_then(|text| text.parse().ok());
        let at = match number {
            Some(number) if number > 0 => usize::try_from(number - 1).ok(),
            Some(number) if number < 0 => {
                (self.corners.len() as i64).checked_add(number).and_then(|at| usize::try_from(at).ok())
            }
            _ => None,
        };
        at.and_then(|at| self.corners.get(at)).copied().ok_or_else(|| {
            let (index, count) = (escape_invisible(&String::from_utf8_lossy(index)), self.corners.len());
            self.invalid(&format!("a face names corner `{index}`, and {count} come before it"))
        })
    }

    fn take_other(&mut self, word: &[u8]) -> Result<(), FileReadError> {
        if let Some((_, what)) = NOT_READ.iter().find(|(known, _)| *known == word) {
            let what = format!("{what} (line {})", self.line);
            return Err(FileReadError::Unsupported { what, remedy: TRIANGLES_ONLY });
        }
        self.objects += u64::from(word == b"o");
        if WITHOUT_AREA.contains(&word) {
            self.without_area += 1;
        } else if !PASSED_OVER.contains(&word) && self.unknown.len() <= MAX_UNKNOWN {
            let word: String = String::from_utf8_lossy(word).chars().take(20).collect();
            self.unknown.insert(escape_invisible(&word));
        }
        Ok(())
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.objects > 1 {
            warnings.push(format!("the file holds {} objects; they are one part", self.objects));
        }
        if self.without_area > 0 {
            let lines = format_count(self.without_area, "line or point is", "lines and points are");
            warnings.push(format!("{lines} left out: there is nothing to print of them"));
        }
        if !self.unknown.is_empty() {
            let words: Vec<&str> = self.unknown.iter().map(String::as_str).take(MAX_UNKNOWN).collect();
            warnings.push(format!("lines that begin with unknown words are left out: {}", words.join(", ")));
        }
        warnings
    }

    fn invalid(&self, reason: &str) -> FileReadError {
        FileReadError::Invalid { format: "OBJ", reason: format!("line {}: {reason}", self.line) }
    }
}
