//! Reads a PLY file, text or binary, as one part. Colours and normals mean nothing to a printer and are passed over.

use std::{
    fs::File,
    io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom},
};

use glam::DVec3;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType},
};

use super::PolygonSurface;
use crate::{FileReadError, LengthUnit, PartFileContents, ReadLimits, escape_invisible};

/// A longer head is none.
const MAX_HEAD_BYTES: u64 = 1 << 16;
/// A longer line is no line of a PLY file.
const MAX_LINE_BYTES: u64 = 1 << 20;
/// Names of the list of a face.
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// A corner.
#[derive(Default)]
struct PlyCorner(DVec3);

impl PropertyAccess for PlyCorner {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.0.x,
            "y" => &mut self.0.y,
            "z" => &mut self.0.z,
            _ => return PropertyAccessResult::Ignored,
        };
        *place = match value {
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// The corners of a face.
#[derive(Default)]
struct PlyFace(Vec<u32>);

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !CORNER_LISTS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        match value.to_u32_list() {
            Some(corners) => self.0 = corners,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

/// What is neither a corner nor a face.
struct PlyOther;

impl PropertyAccess for PlyOther {
    fn new() -> Self {
        Self
    }
}

/// Reads a file; `name` is its name without the ending.
pub(crate) fn read_ply(
    mut file: File,
    name: String,
    unit: LengthUnit,
    limits: &ReadLimits,
) -> Result<PartFileContents, FileReadError> {
    let len = file.metadata()?.len();
    let (mut input, header) = read_head(&mut file)?;
    check_counts(&header, len, limits)?;
    let (mut corners, mut faces): (Vec<PlyCorner>, Vec<PlyFace>) = (Vec::new(), Vec::new());
    for element in header.elements.values() {
        let read = match element.name.as_str() {
            "vertex" => read_element(&mut input, element, &header).map(|read| corners = read),
            "face" => read_element(&mut input, element, &header).map(|read| faces = read),
            _ => read_element::<PlyOther>(&mut input, element, &header).map(drop),
        };
        read?;
    }
    let mut surface = PolygonSurface::new("PLY", unit, limits);
    let mut face = Vec::new();
    for PlyFace(indices) in &faces {
        face.clear();
        for &index in indices {
            let corner = corners.get(index as usize).ok_or_else(|| {
                let (number, count) = (surface.faces + 1, corners.len());
                invalid(format!("face {number} names corner {index}, and the file has {count}, from 0 on"))
            })?;
            face.push(corner.0);
        }
        if face.len() < 3 {
            return Err(invalid(format!("face {} has {} corners", surface.faces + 1, face.len())));
        }
        surface.add_face(&face)?;
    }
    Ok(PartFileContents { solids: vec![surface.surface.into_solid(name)?], warnings: Vec::new() })
}

/// The least number of bytes of a file with this head. A head that cannot be read promises nothing.
///
/// # Errors
/// The disk fails.
pub(crate) fn least_ply_bytes(file: &mut File) -> std::io::Result<u64> {
    match read_head(file) {
        Err(FileReadError::Io(error)) => Err(error),
        Err(FileReadError::Truncated(_)) => Ok(u64::MAX),
        Err(_) => Ok(0),
        Ok((input, header)) => {
            let position = input.into_inner().stream_position()?;
            Ok(header
                .elements
                .values()
                .map(|element| least_element_bytes(element, header.encoding))
                .fold(position, u64::saturating_add))
        }
    }
}

/// The least number of bytes of all entries of an element.
fn least_element_bytes(element: &ElementDef, encoding: Encoding) -> u64 {
    let scalar = |kind: &ScalarType| match kind {
        // A digit and what parts it from the next.
        _ if encoding == Encoding::Ascii => 2,
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let corners = if element.name == "face" { 3 } else { 0 };
    let property = |kind: &PropertyType| match kind {
        PropertyType::Scalar(kind) => scalar(kind),
        PropertyType::List(count, kind) => scalar(count) + corners * scalar(kind),
    };
    let one: u64 = element.properties.values().map(|definition| property(&definition.data_type)).sum();
    // The last line of a text may have no end.
    (element.count as u64).saturating_mul(one).saturating_sub(u64::from(encoding == Encoding::Ascii))
}

/// Reads the head, and leaves the reader behind it.
fn read_head(file: &mut File) -> Result<(Reader<BufReader<&mut File>>, Header), FileReadError> {
    file.seek(SeekFrom::Start(0))?;
    let mut head = Vec::new();
    file.by_ref().take(MAX_HEAD_BYTES).read_to_end(&mut head)?;
    if !head.windows(10).any(|bytes| bytes == b"end_header") {
        return Err(match (head.len() as u64) < MAX_HEAD_BYTES {
            true => FileReadError::Truncated("it ends before its `end_header`".to_owned()),
            false => invalid(format!("there is no `end_header` in its first {MAX_HEAD_BYTES} bytes")),
        });
    }
    file.seek(SeekFrom::Start(0))?;
    let mut input = Reader::new(BufReader::with_capacity(1 << 16, file));
    let header = Parser::<PlyOther>::new().read_header(&mut input).map_err(told)?;
    Ok((input, header))
}

/// Refuses what the head promises and the file cannot hold, before memory is taken for it.
fn check_counts(header: &Header, len: u64, limits: &ReadLimits) -> Result<(), FileReadError> {
    let count = |name: &str| header.elements.get(name).map_or(0, |element| element.count as u64);
    if count("face") == 0 || count("vertex") == 0 {
        return Err(invalid("it holds no face: points have nothing to print".to_owned()));
    }
    if count("face") > limits.max_triangles || count("vertex") > limits.max_triangles.saturating_mul(3) {
        return Err(FileReadError::too_many_triangles(limits));
    }
    for element in header.elements.values() {
        if element.count > 0 && element.properties.is_empty() {
            return Err(invalid(format!("its element {:?} has no property", escape_invisible(&element.name))));
        }
        if least_element_bytes(element, header.encoding) > len {
            let (count, name) = (element.count, escape_invisible(&element.name));
            return Err(FileReadError::Truncated(format!("its {len} bytes cannot hold {count} times {name:?}")));
        }
    }
    let lists = &header.elements["face"].properties;
    match lists.keys().any(|name| CORNER_LISTS.contains(&name.as_str())) {
        true => Ok(()),
        false => Err(invalid("its faces have no list `vertex_indices`".to_owned())),
    }
}

/// Reads all entries of an element. A text may have empty lines, and no line that would fill the memory.
fn read_element<E: PropertyAccess>(
    input: &mut Reader<BufReader<&mut File>>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, FileReadError> {
    let parser = Parser::new();
    if header.encoding != Encoding::Ascii {
        return parser.read_payload_for_element(input, element, header).map_err(told);
    }
    let (mut entries, mut line) = (Vec::new(), Vec::new());
    while entries.len() < element.count {
        line.clear();
        input.get_mut().take(MAX_LINE_BYTES).read_until(b'\n', &mut line)?;
        let (count, all, name) = (entries.len(), element.count, escape_invisible(&element.name));
        let entry = || format!("entry {} of element {name:?}", count + 1);
        if line.is_empty() {
            return Err(FileReadError::Truncated(format!("it has {count} of {all} entries of element {name:?}")));
        }
        if line.len() as u64 >= MAX_LINE_BYTES {
            return Err(invalid(format!("the line of {} is longer than {MAX_LINE_BYTES} bytes", entry())));
        }
        if !line.trim_ascii().is_empty() {
            let read = parser.read_ascii_element(&String::from_utf8_lossy(&line), element);
            entries.push(read.map_err(|error| invalid(format!("{}: {}", entry(), first_line(&error))))?);
        }
    }
    Ok(entries)
}

fn invalid(reason: String) -> FileReadError {
    FileReadError::Invalid { format: "PLY", reason }
}

fn told(error: ParseError) -> FileReadError {
    match error.kind() {
        ErrorKind::UnexpectedEof => FileReadError::Truncated(first_line(&error)),
        _ => invalid(first_line(&error)),
    }
}

/// What the library says, in one line.
fn first_line(error: &ParseError) -> String {
    escape_invisible(error.to_string().lines().next().unwrap_or_default())
}
